//! Texels of fitted nodes, rounded so that what filtering makes of them is close, not each for itself.

use super::fit::Solution;
use super::lattice::Equations;
use super::targets::Targets;
use brdfc_formats::FormatError;
use brdfc_formats::table::{TableHeader, TablePack};
use rayon::prelude::*;

/// Steps of a texel of ten bits.
const STEPS: f32 = 1023.0;

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
fn rounded(equations: &Equations<1>, exact: &[f32]) -> Vec<f32> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;
    use brdfc_formats::table::{Axes, KNOTS, TableSymmetry};

    /// A flat table between two steps: rounding each node alone is off everywhere, together they are right in the mean.
    #[test]
    fn rounding_errors_cancel() {
        let mut knots: [f32; KNOTS] = std::array::from_fn(|k| k as f32 / 16.0);
        knots[KNOTS - 1] = 1.0;
        let header = TableHeader {
            channels: 3,
            symmetry: TableSymmetry { mirror: true, ..TableSymmetry::default() },
            axes: Axes { half: 8, difference: 8, azimuth: 8, layers: 1 },
            mean: 1.0,
            bias: 1e-4,
            low: [0.0; 3],
            span: [1.0; 3],
            slope: 0.0,
            knots,
        };
        let lattice = Lattice::new(&header);
        let mut equations = Equations::<1>::new(lattice);
        let taps: Vec<_> = brdfc_metrics::sampling::random_pairs(20_000, 4)
            .into_iter()
            .map(|pair| lattice.taps(&header.position(pair)))
            .collect();
        taps.iter().for_each(|taps| equations.add(taps, [0.0], 1.0));
        let exact = vec![400.3 / STEPS; lattice.len()];
        let off = |shares: &[f32]| {
            let nodes: Vec<[f32; 1]> = shares.iter().map(|share| [*share]).collect();
            let square = |taps| (STEPS * lattice.value(taps, &nodes)[0] - 400.3).powi(2);
            (taps.iter().map(square).sum::<f32>() / taps.len() as f32).sqrt()
        };
        let alone: Vec<f32> = exact.iter().map(|share| (share * STEPS).round() / STEPS).collect();
        let together = rounded(&equations, &exact);
        assert!((off(&alone) - 0.3).abs() < 1e-3, "{}", off(&alone));
        assert!(off(&together) < 0.7 * off(&alone), "{} after {}", off(&together), off(&alone));
        assert!(together.iter().all(|share| ((share * STEPS) - (share * STEPS).round()).abs() < 1e-3));
    }
}
