//! The tilt of weights that stops their drift.
//!
//! Normalised weights `λ_ij` are the probabilities of a random walk. Let `ρ(θ)` be the largest eigenvalue of the matrix
//! `λ_ij exp(θ · t_ij)`, with `t_ij` the tiles that an edge advances, and `r = exp(h)` its positive eigenvector. Then
//! `P_ij = λ_ij exp(θ · t_ij) r_j / (ρ r_i)` are probabilities again (Doob's transform), and their drift is the
//! gradient of `log ρ`. That is a convex function of `θ`, which grows without bound in all directions, because a
//! surface over the tile has walks to every tile. It therefore has one minimum, where the drift is 0. Only the weights
//! of the edges matter, not their positions.
//!
//! Newton's method finds `θ` and `h` together. It requires solutions of systems with `I - P`: the shares of time `π`;
//! parameters `u` with a drift, `(I - P) u = Σ_j P_ij t_ij - c`, which are also the derivative of `h` with respect to
//! `θ`; the correction of `h`. The second derivative of `log ρ` is the variance of `t_ij + u_j - u_i - c`.

use super::super::sparse::Symbolic;
use super::error::{DRIFT_LIMIT, ParameteriseError, RESIDUAL_LIMIT};
use super::walk::{Solver, Walk};
use super::weights::Edge;
use brdfc_core::progress::Progress;
use rayon::prelude::*;
use std::sync::Arc;

/// Largest difference between the logarithms of the row sums at convergence.
const UNEVENNESS_LIMIT: f64 = 1e-9;
/// Maximum number of Newton steps towards the tilt: four or five are usual.
const TILT_STEPS: usize = 100;
/// Residual that solutions aim at.
const EXACT: f64 = 1e-13;
/// Relative residual of solutions that only lead to the next step.
const ROUGH: f64 = 1e-4;
/// Largest change of the logarithm of a weight in one step: keeps the second derivative at a similar size.
const MAX_CHANGE: f64 = 1.0;
/// Maximum number of rounds for the first shares of time; one or two are usual.
const FIRST_ROUNDS: usize = 20;
/// Steps of the walk in each of them.
const FIRST_WALK: usize = 32;
const UNEVEN: &str = "the weights differ too much from one another";
/// Number of progress steps of a well-conditioned solution.
pub(super) const STEPS: usize = 14;

/// Parameters and the weights that they come from.
pub(super) struct Solution {
    pub coordinates: Vec<[f64; 2]>,
    pub residual: f64,
    pub tilt: f64,
}

/// Solves `u_i = Σ_j λ_ij (u_j + tile_ij)` with the tilt that makes it solvable, from a first guess, whose first vertex
/// stays fixed. `progress` receives about [`STEPS`] steps.
///
/// # Errors
/// Returns an error for weights outside the range of floats, for a drift or residual that does not vanish, and
/// [`ParameteriseError::Cancelled`].
pub(super) fn solve(
    edges: &[Edge],
    guess: &[[f64; 2]],
    symbolic: &mut Option<Arc<Symbolic>>,
    progress: &dyn Progress,
) -> Result<Solution, ParameteriseError> {
    let n = guess.len();
    let mut tilt = [0.0f64; 2];
    let mut potential = vec![0.0; n];
    let mut u = [0, 1].map(|k| guess.iter().map(|c| c[k]).collect::<Vec<f64>>());
    let mut share = first_shares(edges, n)?;
    let mut solver = None;
    let mut drift = [f64::NAN; 2];
    for _ in 0..TILT_STEPS {
        let (walk, log_sums) = tilted(edges, tilt, &potential);
        let solver = match &solver {
            Some(made) => {
                stationary(made, &walk, &mut share)?;
                made
            }
            None => solver.insert(first_solver(&walk, &mut share, symbolic, progress)?),
        };
        progress.step()?;
        let steps = mean_steps(&walk, n);
        drift = [0, 1].map(|k| share.iter().zip(&steps).map(|(s, d)| s * d[k]).sum());
        let mean_log: f64 = share.iter().zip(&log_sums).map(|(s, l)| s * l).sum();
        let uneven = log_sums.iter().map(|l| (l - mean_log).abs()).fold(0.0, f64::max);
        if !drift.iter().chain([&uneven]).all(|v| v.is_finite()) {
            break;
        }
        let found = drift.iter().all(|d| d.abs() < DRIFT_LIMIT) && uneven < UNEVENNESS_LIMIT;

        let longest = steps.iter().map(|d| d[0].abs().max(d[1].abs())).fold(0.0, f64::max);
        let enough = if found { EXACT } else { (ROUGH * longest).max(EXACT) };
        u.par_iter_mut().enumerate().for_each(|(k, u)| {
            let right: Vec<f64> = share.iter().zip(&steps).map(|(s, d)| s * (d[k] - drift[k])).collect();
            solver.forward(&walk, &share, &right, u, enough);
        });
        progress.step()?;
        if found {
            return finish(&walk, u, guess[0], tilt);
        }
        let mut correction = vec![0.0; n];
        if uneven > 0.0 {
            let right: Vec<f64> = share.iter().zip(&log_sums).map(|(s, l)| s * (l - mean_log)).collect();
            solver.forward(&walk, &share, &right, &mut correction, (ROUGH * uneven).max(EXACT));
        }
        let Some(step) = newton_step(&walk, &share, &u, &correction, drift) else { break };
        let change = |edge: &Edge| {
            let (from, to) = (edge.from as usize, edge.to.vertex as usize);
            let along = along(edge, &u, drift);
            (step[0] * along[0] + step[1] * along[1] + correction[to] - correction[from]).abs()
        };
        let damping = (MAX_CHANGE / edges.iter().map(change).fold(0.0, f64::max)).min(1.0);
        (0..2).for_each(|k| tilt[k] += damping * step[k]);
        for (i, h) in potential.iter_mut().enumerate() {
            *h += damping * (correction[i] + step[0] * u[0][i] + step[1] * u[1][i]);
        }
        if !tilt.iter().chain(&potential).all(|t| t.is_finite()) {
            break;
        }
    }
    Err(ParameteriseError::Drift { found: drift[0].hypot(drift[1]) })
}

/// First guess of the shares of time: sums of the weights at each vertex, exact for symmetric weights.
fn first_shares(edges: &[Edge], n: usize) -> Result<Vec<f64>, ParameteriseError> {
    let mut share = vec![0.0; n];
    edges.iter().for_each(|edge| share[edge.from as usize] += edge.weight);
    let total: f64 = share.iter().sum();
    share.iter_mut().for_each(|s| *s /= total);
    if let Some(vertex) = share.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(ParameteriseError::Singular {
            reason: format!("the weights at vertex {vertex} are not finite numbers above 0"),
        });
    }
    Ok(share)
}

/// Probabilities of the tilted weights, and the logarithm of the row sum at each vertex before normalisation.
fn tilted<'a>(edges: &'a [Edge], tilt: [f64; 2], potential: &[f64]) -> (Walk<'a>, Vec<f64>) {
    let mut probabilities = Vec::with_capacity(edges.len());
    let mut log_sums = vec![0.0; potential.len()];
    for row in edges.chunk_by(|a, b| a.from == b.from) {
        let from = row[0].from as usize;
        let plain: f64 = row.iter().map(|edge| edge.weight).sum();
        let exponent = |edge: &Edge| {
            let [x, y] = edge.to.tile.map(f64::from);
            tilt[0] * x + tilt[1] * y + (potential[edge.to.vertex as usize] - potential[from])
        };
        let largest = row.iter().map(exponent).fold(f64::NEG_INFINITY, f64::max);
        let start = probabilities.len();
        probabilities.extend(row.iter().map(|edge| edge.weight / plain * (exponent(edge) - largest).exp()));
        let sum: f64 = probabilities[start..].iter().sum();
        probabilities[start..].iter_mut().for_each(|p| *p /= sum);
        log_sums[from] = sum.ln() + largest;
    }
    (Walk { edges, probabilities }, log_sums)
}

/// A solver, and the shares of time that it was built for.
fn first_solver(
    walk: &Walk<'_>,
    share: &mut [f64],
    symbolic: &mut Option<Arc<Symbolic>>,
    progress: &dyn Progress,
) -> Result<Solver, ParameteriseError> {
    let mut excess = vec![0.0; share.len()];
    let ones = vec![1.0; share.len()];
    for _ in 0..FIRST_ROUNDS {
        // Steps of the walk reduce local errors; the solver reduces distant ones.
        for _ in 0..FIRST_WALK {
            walk.backward(share, &ones, &mut excess);
            share.iter_mut().zip(&excess).for_each(|(s, e)| *s -= 0.5 * e);
        }
        let solver = Solver::new(walk, share, symbolic, progress)?;
        progress.step()?;
        if stationary(&solver, walk, share)? < 2.0 {
            return Ok(solver);
        }
    }
    Err(ParameteriseError::Singular { reason: UNEVEN.into() })
}

/// Improves the shares of time until inflow and outflow balance at each vertex. They sum to 1. Returns the largest
/// factor by which one changed.
fn stationary(solver: &Solver, walk: &Walk<'_>, share: &mut [f64]) -> Result<f64, ParameteriseError> {
    let n = share.len();
    // Inflow less outflow of each vertex; shares are sought as multiples of the current ones.
    let mut excess = vec![0.0; n];
    walk.backward(share, &vec![1.0; n], &mut excess);
    excess.iter_mut().for_each(|e| *e = -*e);
    let mut change = vec![0.0; n];
    solver.backward(walk, share, &excess, &mut change, EXACT);
    let mut largest = 1.0f64;
    for (s, c) in share.iter_mut().zip(&change) {
        let factor = (1.0 + c).clamp(0.1, 10.0);
        largest = largest.max(factor).max(1.0 / factor);
        *s *= factor;
    }
    let total: f64 = share.iter().sum();
    share.iter_mut().for_each(|s| *s /= total);
    if share.iter().all(|s| *s > 0.0 && s.is_finite()) {
        return Ok(largest);
    }
    Err(ParameteriseError::Singular { reason: UNEVEN.into() })
}

/// For each vertex, the mean over its edges of the tiles that they advance.
fn mean_steps(walk: &Walk<'_>, n: usize) -> Vec<[f64; 2]> {
    let mut steps = vec![[0.0; 2]; n];
    for (edge, p) in walk.edges.iter().zip(&walk.probabilities) {
        (0..2).for_each(|k| steps[edge.from as usize][k] += p * f64::from(edge.to.tile[k]));
    }
    steps
}

/// Advance of an edge in parameters, less the drift: its mean over the edges of a vertex is 0.
fn along(edge: &Edge, u: &[Vec<f64>; 2], drift: [f64; 2]) -> [f64; 2] {
    let (from, to) = (edge.from as usize, edge.to.vertex as usize);
    [0, 1].map(|k| f64::from(edge.to.tile[k]) + u[k][to] - u[k][from] - drift[k])
}

/// The change of the tilt that stops the drift to first order, together with the correction of the potential.
fn newton_step(
    walk: &Walk<'_>,
    share: &[f64],
    u: &[Vec<f64>; 2],
    correction: &[f64],
    drift: [f64; 2],
) -> Option<[f64; 2]> {
    let (mut variance, mut gradient) = ([[0.0f64; 2]; 2], drift);
    for (edge, p) in walk.edges.iter().zip(&walk.probabilities) {
        let (from, to) = (edge.from as usize, edge.to.vertex as usize);
        let along = along(edge, u, drift);
        let p = share[from] * p;
        for a in 0..2 {
            (0..2).for_each(|b| variance[a][b] += p * along[a] * along[b]);
            gradient[a] += p * along[a] * (correction[to] - correction[from]);
        }
    }
    let [[a, b], [c, d]] = variance;
    let determinant = a * d - b * c;
    let step = [(b * gradient[1] - d * gradient[0]) / determinant, (c * gradient[0] - a * gradient[1]) / determinant];
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// Translates the solution so that the first vertex stays in place, and checks the equations themselves, without a
/// drift.
fn finish(walk: &Walk<'_>, u: [Vec<f64>; 2], first: [f64; 2], tilt: [f64; 2]) -> Result<Solution, ParameteriseError> {
    let shift = [0, 1].map(|k| first[k] - u[k][0]);
    let coordinates: Vec<[f64; 2]> = u[0].iter().zip(&u[1]).map(|(x, y)| [x + shift[0], y + shift[1]]).collect();
    let mut off: Vec<[f64; 2]> = coordinates.iter().map(|c| c.map(|v| -v)).collect();
    for (edge, p) in walk.edges.iter().zip(&walk.probabilities) {
        let to = coordinates[edge.to.vertex as usize];
        (0..2).for_each(|k| off[edge.from as usize][k] += p * (to[k] + f64::from(edge.to.tile[k])));
    }
    let residual = off.iter().flatten().fold(0.0, |largest: f64, r| if r.is_nan() { *r } else { largest.max(r.abs()) });
    if residual > RESIDUAL_LIMIT || residual.is_nan() {
        return Err(ParameteriseError::Residual { found: residual });
    }
    Ok(Solution { coordinates, residual, tilt: tilt[0].hypot(tilt[1]) })
}

/// Drift of the untilted weights.
#[cfg(test)]
pub(super) fn drift_without_tilt(edges: &[Edge], n: usize) -> Result<[f64; 2], ParameteriseError> {
    let (walk, _) = tilted(edges, [0.0; 2], &vec![0.0; n]);
    let mut share = first_shares(edges, n)?;
    first_solver(&walk, &mut share, &mut None, &())?;
    let steps = mean_steps(&walk, n);
    Ok([0, 1].map(|k| share.iter().zip(&steps).map(|(s, d)| s * d[k]).sum()))
}
