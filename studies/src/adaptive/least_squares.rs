//! Fits of models that are linear but for one parameter of each lobe.

use rayon::prelude::*;

/// A value of each point and channel.
pub type Column = Vec<[f32; 3]>;

/// Weight of the squared diagonal that makes nearly equal columns solvable.
const RIDGE: f64 = 1e-6;
/// Rounds over all weights, and the relative change that ends them.
const ROUNDS: (usize, f64) = (2000, 1e-9);
/// Halvings of the step of [`refine`].
const HALVINGS: usize = 6;

/// A weighted sum of columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Weights of 0 or more, for each column and channel.
    pub weights: Vec<[f64; 3]>,
    /// Sum of squared differences from the target.
    pub error: f64,
}

/// The weighted sum of columns that is closest to a target, by coordinate descent.
pub fn non_negative(columns: &[&Column], target: &Column) -> Solution {
    let gram: Vec<Vec<[f64; 3]>> = columns.iter().map(|a| columns.iter().map(|b| product(a, b)).collect()).collect();
    let right: Vec<[f64; 3]> = columns.iter().map(|column| product(column, target)).collect();
    let squares = product(target, target);
    let mut solution = Solution { weights: vec![[0.0; 3]; columns.len()], error: 0.0 };
    for channel in 0..3 {
        let weights = descended(&|a, b| gram[a][b][channel], &|at| right[at][channel], columns.len());
        let of = |a: usize| weights[a] * ((0..weights.len()).map(|b| gram[a][b][channel] * weights[b]).sum::<f64>());
        let linear: f64 = weights.iter().zip(&right).map(|(weight, right)| weight * right[channel]).sum();
        solution.error += (squares[channel] - 2.0 * linear + (0..weights.len()).map(of).sum::<f64>()).max(0.0);
        solution.weights.iter_mut().zip(weights).for_each(|(all, weight)| all[channel] = weight);
    }
    solution
}

fn descended(gram: &dyn Fn(usize, usize) -> f64, right: &dyn Fn(usize) -> f64, count: usize) -> Vec<f64> {
    let mut weights = vec![0.0; count];
    for _ in 0..ROUNDS.0 {
        let mut moved = 0.0f64;
        for at in 0..count {
            let own = gram(at, at) * (1.0 + RIDGE);
            if own <= 0.0 {
                continue;
            }
            let others: f64 = (0..count).filter(|k| *k != at).map(|k| gram(at, k) * weights[k]).sum();
            let next = ((right(at) - others) / own).max(0.0);
            moved = moved.max((next - weights[at]).abs() / (next + weights[at]).max(1e-6));
            weights[at] = next;
        }
        if moved < ROUNDS.1 {
            break;
        }
    }
    weights
}

fn product(a: &Column, b: &Column) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (a, b) in a.iter().zip(b) {
        (0..3).for_each(|k| sum[k] += f64::from(a[k]) * f64::from(b[k]));
    }
    sum
}

/// A value of a parameter, and what was found there.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum<T> {
    /// The parameter.
    pub at: f64,
    /// The error there.
    pub error: f64,
    /// Other results there.
    pub found: T,
}

/// The parameter with the least error of `steps` from `low` to `high`, in equal ratios.
///
/// # Panics
/// Panics without steps.
pub fn scan<T: Send>([low, high]: [f64; 2], steps: usize, of: impl Fn(f64) -> (f64, T) + Sync) -> Minimum<T> {
    let at = |step: usize| low * (high / low).powf(step as f64 / (steps - 1).max(1) as f64);
    let found = |step: usize| {
        let (error, found) = of(at(step));
        Minimum { at: at(step), error, found }
    };
    let all: Vec<Minimum<T>> = (0..steps).into_par_iter().map(found).collect();
    all.into_iter().min_by(|a, b| a.error.total_cmp(&b.error)).expect("there are steps")
}

/// The parameter with the least error around another one, within a factor of about `ratio`.
pub fn refine<T>(mut best: Minimum<T>, ratio: f64, of: impl Fn(f64) -> (f64, T)) -> Minimum<T> {
    let mut step = ratio.ln();
    for _ in 0..HALVINGS {
        step *= 0.5;
        for turn in [-step, step] {
            let at = best.at * turn.exp();
            let (error, found) = of(at);
            if error < best.error {
                best = Minimum { at, error, found };
                break;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_recovered_and_never_negative() {
        let column = |phase: f32| -> Column { (0..50).map(|k| [(0.3 * k as f32 + phase).sin() + 1.5; 3]).collect() };
        let (a, b, c) = (column(0.0), column(1.0), column(2.5));
        let target: Column =
            (0..50).map(|k| [0.5 * a[k][0] + 2.0 * b[k][0], 3.0 * c[k][1], a[k][2] - 0.4 * c[k][2]]).collect();
        let found = non_negative(&[&a, &b, &c], &target);
        for (channel, expected) in [[0.5, 2.0, 0.0], [0.0, 0.0, 3.0]].iter().enumerate() {
            for (weight, expected) in found.weights.iter().zip(expected) {
                assert!((weight[channel] - expected).abs() < 1e-3, "{channel} {:?}", found.weights);
            }
        }
        // The third channel needs a negative weight.
        assert!(found.weights.iter().all(|weight| weight[2] >= 0.0) && found.error > 0.1, "{found:?}");
    }

    #[test]
    fn searches_find_the_least_error() {
        let of = |x: f64| ((x / 0.3).ln().powi(2), ());
        let coarse = scan([0.01, 1.0], 8, of);
        let fine = refine(coarse.clone(), 2.0, of);
        assert!((fine.at / 0.3 - 1.0).abs() < 0.03, "{fine:?}");
        assert!(coarse.error > fine.error, "the control");
    }
}
