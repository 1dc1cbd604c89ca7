//! Rounding of fitted nodes to texels, so that the filtered values are close, not each node alone.

use super::fit::Solution;
use super::lattice::Equations;
use super::targets::Targets;
use brdfc_formats::FormatError;
use brdfc_formats::table::{TableHeader, TablePack};
use rayon::prelude::*;

/// Number of steps of a ten-bit texel.
pub const STEPS: f32 = 1023.0;

/// Creates the pack of a fit, with the range of each channel from its lowest to its highest value. Nodes that hardly
/// any sample uses are clamped to the range of the samples.
///
/// # Errors
/// Returns the errors of [`TablePack::new`].
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
            // Halves of grey materials are as fine without error diffusion.
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

/// Rounds each share to the step that best compensates the rounding errors of its neighbours, in the metric of the fit,
/// like error diffusion of pixels: if all nodes should be half a step higher, every other one becomes a whole step higher.
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

/// Maximum displacement of a node that compensates for others; it limits nodes that hardly any sample uses.
const FARTHEST: f32 = 1.0 / STEPS;
/// Number of passes over all nodes.
const SWEEPS: usize = 3;
