//! The curve of factored packs: the part of the logarithms that depends on `θ_h` alone and is too fine for the table's
//! columns. In a microfacet model it is the distribution of half vectors (Bagher, Snyder and Nowrouzezahrai 2016
//! tabulate it, too).

use super::samples::Samples;
use super::targets::{Targets, UNSEEN};
use brdfc_formats::FormatError;
use brdfc_formats::table::Curve;

/// Texels of a pack per node of its curve, and the maximum number of nodes.
const TEXELS_PER_NODE: usize = 32;
const MAX_NODES: usize = 128;
pub(super) const MIN_NODES: usize = 16;
/// Strength of the ties between neighbouring nodes, relative to the mean strength of the ties that samples create.
const SMOOTHNESS: f64 = 1e-4;

/// Number of nodes of the curve for a pack of `texels` texels.
pub fn nodes_within(texels: usize) -> usize {
    (texels / TEXELS_PER_NODE).clamp(MIN_NODES, MAX_NODES)
}

/// Fits nodes of the curve to logarithms of the samples, by least squares with the weights of the targets.
pub fn fit(samples: &Samples, targets: &Targets, logarithms: &[[f32; 3]], nodes: usize) -> Vec<[f64; 3]> {
    let [red, green, blue] = std::array::from_fn(|channel| solved(samples, targets, logarithms, nodes, channel));
    (0..nodes).map(|k| [red[k], green[k], blue[k]]).collect()
}

/// Converts rows of nodes to the stored form, the finest level of detail first. Zero is where most of the finest row
/// is; the table takes the offset.
///
/// # Errors
/// Returns the errors of [`Curve::new`], for example for rows of different lengths.
pub fn stored(rows: &[Vec<[f64; 3]>], channels: u32) -> Result<Curve, FormatError> {
    let middle: [f64; 3] = std::array::from_fn(|channel| {
        let mut values: Vec<f64> = rows[0].iter().map(|value| value[channel]).collect();
        let at = values.len() / 2;
        *values.select_nth_unstable_by(at, f64::total_cmp).1
    });
    let values: Vec<[f32; 3]> =
        rows.iter().flatten().map(|value| std::array::from_fn(|c| (value[c] - middle[c]) as f32)).collect();
    Curve::new(channels, rows.len() as u32 - 1, &values)
}

/// Value of the curve at `θ_h`.
pub fn at(nodes: &[[f64; 3]], theta_half: f32) -> [f64; 3] {
    let (lower, weight) = place(nodes.len(), theta_half);
    std::array::from_fn(|c| nodes[lower][c] + f64::from(weight) * (nodes[lower + 1][c] - nodes[lower][c]))
}

/// Contribution of the finest level of a curve at each sample.
pub fn along(curve: &Curve, samples: &Samples) -> Vec<[f32; 3]> {
    let mut values = curve.values();
    values.truncate(curve.nodes());
    samples
        .angles
        .iter()
        .map(|angles| {
            let (lower, weight) = place(values.len(), angles.theta_half);
            std::array::from_fn(|c| values[lower][c] + weight * (values[lower + 1][c] - values[lower][c]))
        })
        .collect()
}

fn place(nodes: usize, theta_half: f32) -> (usize, f32) {
    let at = Curve::position(nodes, theta_half);
    let lower = (at as usize).min(nodes - 2);
    (lower, at - lower as f32)
}

/// Solves the tridiagonal normal equations of one channel by elimination.
fn solved(samples: &Samples, targets: &Targets, logarithms: &[[f32; 3]], nodes: usize, channel: usize) -> Vec<f64> {
    let mut diagonal = vec![0.0f64; nodes];
    let mut off_diagonal = vec![0.0f64; nodes - 1];
    let mut right = vec![0.0f64; nodes];
    for (k, angles) in samples.angles.iter().enumerate() {
        let (lower, upper_share) = place(nodes, angles.theta_half);
        let weight = f64::from(targets.weights[k][channel].powi(2) + UNSEEN * UNSEEN);
        let (value, b) = (f64::from(logarithms[k][channel]), f64::from(upper_share));
        let a = 1.0 - b;
        diagonal[lower] += weight * a * a;
        diagonal[lower + 1] += weight * b * b;
        off_diagonal[lower] += weight * a * b;
        right[lower] += weight * a * value;
        right[lower + 1] += weight * b * value;
    }
    let tie = SMOOTHNESS * diagonal.iter().sum::<f64>() / nodes as f64 + f64::MIN_POSITIVE;
    for k in 0..nodes - 1 {
        diagonal[k] += tie;
        diagonal[k + 1] += tie;
        off_diagonal[k] -= tie;
    }
    for k in 1..nodes {
        let share = off_diagonal[k - 1] / diagonal[k - 1];
        diagonal[k] -= share * off_diagonal[k - 1];
        right[k] -= share * right[k - 1];
    }
    right[nodes - 1] /= diagonal[nodes - 1];
    for k in (0..nodes - 1).rev() {
        right[k] = (right[k] - off_diagonal[k] * right[k + 1]) / diagonal[k];
    }
    right
}
