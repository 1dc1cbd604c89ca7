//! Values of the nodes, by weighted least squares over samples, so that the filtered table is close, not only the
//! nodes.

use super::lattice::{Equations, Lattice, Means, Taps};
use super::targets::{Targets, UNSEEN};
use rayon::prelude::*;

/// Steps of conjugate gradients in an encoding and in a trial.
const STEPS: usize = 30;
const TRIAL_STEPS: usize = 16;
/// Strength of the ties between neighbouring nodes, relative to the mean strength of the ties that samples create.
const SMOOTHNESS: f32 = 1e-4;
/// Difference of lightness, relative to white's, above which samples count less than by their square: errors are means
/// of differences, not of squares.
const LARGE: f32 = 0.01;
/// Number of updates of the weights from the residuals.
const REWEIGHTED: usize = 1;

/// Fitted nodes.
pub struct Solution {
    /// Logarithms, `[node][channel]`. Grey ones are repeated in all three channels.
    pub nodes: Vec<[f32; 3]>,
    /// Last equations of each channel, or of the single grey channel.
    pub equations: Vec<Equations<1>>,
}

/// Fits logarithms; `taps` belong to the samples.
///
/// Solves least squares, then again with weights that fall with the residual (iteratively reweighted least squares).
pub fn fit(lattice: Lattice, taps: &[Taps], targets: &Targets) -> Solution {
    let channels = if targets.grey { 1 } else { 3 };
    let mut shares = vec![1.0; taps.len()];
    let mut means = Means::new(lattice);
    taps.iter().zip(&targets.logarithms).for_each(|(taps, values)| means.add(taps, *values));
    let mut nodes = means.of_nodes();
    let mut equations = Vec::new();
    for round in 0..=REWEIGHTED {
        let solved: (Vec<Equations<1>>, Vec<Vec<[f32; 1]>>) =
            (0..channels).into_par_iter().map(|c| channel(lattice, taps, targets, c, &shares, &nodes)).unzip();
        for (k, node) in nodes.iter_mut().enumerate() {
            *node = std::array::from_fn(|c| solved.1[c.min(channels - 1)][k][0]);
        }
        equations = solved.0;
        if round < REWEIGHTED {
            shares.par_iter_mut().enumerate().with_min_len(4096).for_each(|(k, share)| {
                let found = lattice.value(&taps[k], &nodes);
                let (expected, weights) = (targets.logarithms[k], targets.weights[k]);
                let square: f32 = (0..channels).map(|c| (weights[c] * (expected[c] - found[c])).powi(2)).sum();
                *share = LARGE / (square.sqrt() + LARGE);
            });
        }
    }
    Solution { nodes, equations }
}

/// Fits all channels at once, with the mean of their weights and fewer steps: accurate enough to compare tables. The
/// taps belong to the first samples.
pub fn fit_roughly(lattice: Lattice, taps: impl Iterator<Item = Taps>, targets: &Targets) -> Vec<[f32; 3]> {
    // Vector instructions process four numbers at once.
    let four = |v: [f32; 3]| [v[0], v[1], v[2], 0.0];
    let mut equations = Equations::<4>::new(lattice);
    let mut means = Means::new(lattice);
    for ((taps, logarithms), weights) in taps.zip(&targets.logarithms).zip(&targets.weights) {
        let seen = weights.iter().map(|w| w * w).sum::<f32>() / 3.0;
        equations.add(&taps, four(*logarithms), seen + UNSEEN * UNSEEN);
        means.add(&taps, *logarithms);
    }
    equations.smooth(SMOOTHNESS);
    let mut nodes: Vec<[f32; 4]> = means.of_nodes().into_iter().map(four).collect();
    equations.solve(&mut nodes, TRIAL_STEPS);
    nodes.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
}

fn channel(
    lattice: Lattice,
    taps: &[Taps],
    targets: &Targets,
    channel: usize,
    shares: &[f32],
    nodes: &[[f32; 3]],
) -> (Equations<1>, Vec<[f32; 1]>) {
    let mut equations = Equations::<1>::new(lattice);
    for (k, taps) in taps.iter().enumerate() {
        let weight = targets.weights[k][channel].powi(2) * shares[k] + UNSEEN * UNSEEN;
        equations.add(taps, [targets.logarithms[k][channel]], weight);
    }
    equations.smooth(SMOOTHNESS);
    let mut solved: Vec<[f32; 1]> = nodes.iter().map(|node| [node[channel]]).collect();
    equations.solve(&mut solved, STEPS);
    (equations, solved)
}
