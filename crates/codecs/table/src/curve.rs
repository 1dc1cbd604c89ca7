//! The curve of factored packs: what of the logarithms depends on `θ_h` alone and is too fine for the table's columns. In a
//! microfacet model it is the distribution of half vectors (Bagher, Snyder and Nowrouzezahrai 2016 tabulate it, too).

use super::samples::Samples;
use super::targets::{Targets, UNSEEN};
use brdfc_formats::FormatError;
use brdfc_formats::container::TexelFormat;
use brdfc_formats::table::Curve;

/// A curve has one node for so many texels of a pack, and no more than this.
const TEXELS_PER_NODE: usize = 32;
const MOST_NODES: usize = 128;
const FEWEST_NODES: usize = 16;
/// How strongly nodes are tied to their neighbours, of what samples tie them by in the mean.
const SMOOTHNESS: f64 = 1e-4;

/// Nodes of the curve of a pack of so many texels.
pub fn nodes_within(texels: usize) -> usize {
    (texels / TEXELS_PER_NODE).clamp(FEWEST_NODES, MOST_NODES)
}

/// The curve closest to logarithms of the samples, by least squares with the weights of the targets. Its lowest value is
/// left to the table.
///
/// # Errors
/// As [`Curve::new`].
pub fn fit(
    samples: &Samples,
    targets: &Targets,
    logarithms: &[[f32; 3]],
    nodes: usize,
    format: TexelFormat,
) -> Result<Curve, FormatError> {
    let [red, green, blue] = std::array::from_fn(|channel| solved(samples, targets, logarithms, nodes, channel));
    let values: Vec<[f64; 3]> = (0..nodes).map(|k| [red[k], green[k], blue[k]]).collect();
    let range = |channel: usize| {
        let of_channel = || values.iter().map(|value| value[channel]);
        (of_channel().fold(f64::INFINITY, f64::min), of_channel().fold(f64::NEG_INFINITY, f64::max))
    };
    let ranges: [(f64, f64); 3] = std::array::from_fn(range);
    let share =
        |value: f64, (low, high): (f64, f64)| if high > low { ((value - low) / (high - low)) as f32 } else { 0.0 };
    let shares: Vec<[f32; 3]> =
        values.iter().map(|value| std::array::from_fn(|c| share(value[c], ranges[c]))).collect();
    Curve::new(format, ranges.map(|(low, high)| (high - low) as f32), &shares)
}

/// What a curve adds at each sample.
pub fn along(curve: &Curve, samples: &Samples) -> Vec<[f32; 3]> {
    let (values, span) = (curve.values(), curve.span());
    samples
        .angles
        .iter()
        .map(|angles| {
            let (lower, weight) = place(values.len(), angles.theta_half);
            std::array::from_fn(|c| span[c] * (values[lower][c] + weight * (values[lower + 1][c] - values[lower][c])))
        })
        .collect()
}

fn place(nodes: usize, theta_half: f32) -> (usize, f32) {
    let at = Curve::position(nodes, theta_half);
    let lower = (at as usize).min(nodes - 2);
    (lower, at - lower as f32)
}

/// The tridiagonal normal equations of one channel, solved by elimination.
fn solved(samples: &Samples, targets: &Targets, logarithms: &[[f32; 3]], nodes: usize, channel: usize) -> Vec<f64> {
    let mut diagonal = vec![0.0f64; nodes];
    let mut beside = vec![0.0f64; nodes - 1];
    let mut right = vec![0.0f64; nodes];
    for (k, angles) in samples.angles.iter().enumerate() {
        let (lower, upper_share) = place(nodes, angles.theta_half);
        let weight = f64::from(targets.weights[k][channel].powi(2) + UNSEEN * UNSEEN);
        let (value, b) = (f64::from(logarithms[k][channel]), f64::from(upper_share));
        let a = 1.0 - b;
        diagonal[lower] += weight * a * a;
        diagonal[lower + 1] += weight * b * b;
        beside[lower] += weight * a * b;
        right[lower] += weight * a * value;
        right[lower + 1] += weight * b * value;
    }
    let tie = SMOOTHNESS * diagonal.iter().sum::<f64>() / nodes as f64 + f64::MIN_POSITIVE;
    for k in 0..nodes - 1 {
        diagonal[k] += tie;
        diagonal[k + 1] += tie;
        beside[k] -= tie;
    }
    for k in 1..nodes {
        let share = beside[k - 1] / diagonal[k - 1];
        diagonal[k] -= share * beside[k - 1];
        right[k] -= share * right[k - 1];
    }
    right[nodes - 1] /= diagonal[nodes - 1];
    for k in (0..nodes - 1).rev() {
        right[k] = (right[k] - beside[k] * right[k + 1]) / diagonal[k];
    }
    right
}
