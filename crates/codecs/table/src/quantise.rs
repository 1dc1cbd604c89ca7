//! Texels of fitted nodes, rounded so that what filtering makes of them is close, not each for itself.

use super::fit::Solution;
use super::lattice::Equations;
use super::targets::Targets;
use brdfc_formats::FormatError;
use brdfc_formats::table::{TableHeader, TablePack};
use rayon::prelude::*;

/// Steps of a texel of ten bits.
pub const STEPS: f32 = 1023.0;

/// The pack of a fit: each channel from its lowest to its highest. Nodes that hardly any sample touches stay in the range of
/// the samples.
///
/// # Errors
/// As [`TablePack::new`].
pub fn quantise(mut header: TableHeader, solution: &Solution, targets: &Targets) -> Result<TablePack, FormatError> {
    let nodes = &solution.nodes;
    let mut values = vec![[0.0f32; 3]; nodes.len()];
    let shares: Vec<(f32, f32, Vec<f32>)> = (0..3)
        .into_par_iter()
        .map(|channel| {
            let range = |values: &mut dyn Iterator<Item = f32>| {
                values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
            };
            let (least, most) = range(&mut targets.logarithms.iter().map(|v| v[channel]));
            let clamped: Vec<f32> = nodes.iter().map(|node| node[channel].clamp(least, most)).collect();
            let (low, high) = range(&mut clamped.iter().copied());
            let span = high - low;
            let shares: Vec<f32> = clamped.iter().map(|v| if span > 0.0 { (v - low) / span } else { 0.0 }).collect();
            // Halves of grey materials are as fine as that already.
            let rounded = match solution.equations.get(channel) {
                Some(equations) if header.channels == 3 => rounded(equations, &shares),
                _ => shares,
            };
            (low, span, rounded)
        })
        .collect();
    for (channel, (low, span, shares)) in shares.into_iter().enumerate() {
        (header.low[channel], header.span[channel]) = (low, span);
        values.iter_mut().zip(shares).for_each(|(value, share)| value[channel] = share);
    }
    TablePack::new(header, &values)
}

/// Rounds each share to the step that makes up best for what its neighbours were rounded by, in the sense of the fit, as
/// error diffusion does for pixels: where all nodes should be half a step higher, every other one is a whole step higher.
pub fn rounded(equations: &Equations<1>, exact: &[f32]) -> Vec<f32> {
    let nearest = |share: f32| (share * STEPS).round().clamp(0.0, STEPS) / STEPS;
    let mut shares: Vec<f32> = exact.iter().map(|share| nearest(*share)).collect();
    let mut errors: Vec<f32> = shares.iter().zip(exact).map(|(share, exact)| share - exact).collect();
    for _ in 0..SWEEPS {
        for node in 0..exact.len() {
            let pull = equations.pull(node, &errors).clamp(-FARTHEST, FARTHEST);
            shares[node] = nearest(exact[node] - pull);
            errors[node] = shares[node] - exact[node];
        }
    }
    shares
}

/// How far a node may move to make up for others: those that hardly any sample touches would else go far.
const FARTHEST: f32 = 1.0 / STEPS;
/// How often all nodes are looked at.
const SWEEPS: usize = 3;
