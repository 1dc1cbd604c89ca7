//! The linear systems of a random walk over the edges of a mesh, and their solver.
//!
//! With `π` the share of time that the walk spends at each vertex, `diag(π) (I - P)` is a Laplacian plus a circulation:
//! `S + K` with `S` symmetric, `K` skew, and the rows and columns of both summing to 0. A circulation is local, so that
//! `S⁻¹ (S + K)` stays near the identity for any number of vertices: one sparse Cholesky factorisation of `S` and a few
//! steps of a minimal residual method replace the LU factorisation of the whole, which fills in far more (the splitting
//! of Concus and Golub 1976, "A generalized conjugate gradient method for nonsymmetric systems of linear equations";
//! the steps of Eisenstat, Elman and Schultz 1983, "Variational iterative methods for nonsymmetric systems of linear
//! equations", ORTHOMIN).

use super::super::sparse::{Cholesky, FactorError, Symbolic};
use super::error::ParameteriseError;
use super::weights::Edge;
use brdfc_core::progress::Progress;
use std::collections::VecDeque;
use std::sync::Arc;

/// Number of previous directions that each step is made orthogonal to.
const MAX_DIRECTIONS: usize = 6;
/// Maximum number of steps of one solution.
const MAX_STEPS: usize = 400;
/// Steps without progress after which the iteration stops.
const IDLE_STEPS: usize = 6;

/// A random walk: `probabilities[e]` is the probability of leaving along edge `e`; they sum to 1 for each vertex.
pub(super) struct Walk<'a> {
    pub edges: &'a [Edge],
    pub probabilities: Vec<f64>,
}

impl Walk<'_> {
    /// `out = diag(scale) (I - P) x`.
    fn forward(&self, scale: &[f64], x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (edge, p) in self.edges.iter().zip(&self.probabilities) {
            // Sums differences along edges, which loses no precision if values are large and close together.
            let from = edge.from as usize;
            out[from] += p * (x[from] - x[edge.to.vertex as usize]);
        }
        out.iter_mut().zip(scale).for_each(|(o, s)| *o *= s);
    }

    /// `out = (diag(scale) (I - P))ᵀ x`.
    pub fn backward(&self, scale: &[f64], x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (edge, p) in self.edges.iter().zip(&self.probabilities) {
            let (from, to) = (edge.from as usize, edge.to.vertex as usize);
            let flow = scale[from] * p * x[from];
            out[from] += flow;
            out[to] -= flow;
        }
    }
}

/// Solves systems of walks close to the walk that it was built for.
pub(super) struct Solver {
    /// Factor of the symmetric part without the first row and column; `None` for a single vertex.
    factor: Option<Cholesky>,
}

impl Solver {
    /// Factorises a walk. `share` need not be the exact share of time at each vertex. All walks that share `symbolic`
    /// have the same edges. `progress` receives a few steps.
    pub fn new(
        walk: &Walk<'_>,
        share: &[f64],
        symbolic: &mut Option<Arc<Symbolic>>,
        progress: &dyn Progress,
    ) -> Result<Self, ParameteriseError> {
        let n = share.len();
        if n < 2 {
            return Ok(Self { factor: None });
        }
        let refused = |error: FactorError| match error {
            FactorError::Cancelled(cancelled) => cancelled.into(),
            error => ParameteriseError::Singular { reason: error.to_string() },
        };
        let mut places = Vec::with_capacity(walk.edges.len() + n);
        let mut values = Vec::with_capacity(walk.edges.len() + n);
        let mut diagonal = vec![0.0; n];
        for (edge, p) in walk.edges.iter().zip(&walk.probabilities) {
            let (from, to) = (edge.from, edge.to.vertex);
            if from == to {
                continue;
            }
            let half = 0.5 * share[from as usize] * p;
            diagonal[from as usize] += half;
            diagonal[to as usize] += half;
            if from.min(to) > 0 {
                places.push([from - 1, to - 1]);
                values.push(-half);
            }
        }
        places.extend((0..n as u32 - 1).map(|row| [row; 2]));
        values.extend(&diagonal[1..]);
        let symbolic = match symbolic {
            Some(known) => known,
            None => symbolic.insert(Arc::new(Symbolic::new(n - 1, &places).map_err(refused)?)),
        };
        let factor = Cholesky::new(symbolic, &values, progress).map_err(refused)?;
        Ok(Self { factor: Some(factor) })
    }

    fn precondition(&self, r: &[f64]) -> Vec<f64> {
        let mut z = r.to_vec();
        z[0] = 0.0;
        if let Some(factor) = &self.factor {
            factor.solve(z[1..].as_chunks_mut::<1>().0);
        }
        z
    }

    /// Solves `diag(scale) (I - P) x = right` from a first guess, up to a constant. `right` sums to 0. Returns the
    /// largest residual of a row divided by its scale.
    pub fn forward(&self, walk: &Walk<'_>, scale: &[f64], right: &[f64], x: &mut [f64], enough: f64) -> f64 {
        self.solve(|x, out| walk.forward(scale, x, out), scale, right, x, enough)
    }

    /// Solves the transposed system; see [`Solver::forward`].
    pub fn backward(&self, walk: &Walk<'_>, scale: &[f64], right: &[f64], x: &mut [f64], enough: f64) -> f64 {
        self.solve(|x, out| walk.backward(scale, x, out), scale, right, x, enough)
    }

    fn solve(
        &self,
        apply: impl Fn(&[f64], &mut [f64]),
        scale: &[f64],
        right: &[f64],
        x: &mut [f64],
        enough: f64,
    ) -> f64 {
        let n = x.len();
        let largest = |r: &[f64]| r.iter().zip(scale).map(|(r, s)| (r / s).abs()).fold(0.0, larger);
        let mut r = vec![0.0; n];
        let total: f64 = scale.iter().sum();
        let residual = |x: &[f64], r: &mut Vec<f64>| {
            apply(x, r);
            r.iter_mut().zip(right).for_each(|(r, b)| *r = b - *r);
            // The mean residual is rounding: no solution removes it.
            let rest = r.iter().sum::<f64>() / total;
            subtract_scaled(r, rest, scale);
        };
        residual(x, &mut r);
        let mut exact = largest(&r);
        let mut directions: VecDeque<Direction> = VecDeque::with_capacity(MAX_DIRECTIONS);
        let (mut least, mut idle) = (product(&r, &r), 0);
        for _ in 0..MAX_STEPS {
            if exact <= enough || exact.is_nan() {
                break;
            }
            let mut along = self.precondition(&r);
            let mut image = vec![0.0; n];
            apply(&along, &mut image);
            for direction in &directions {
                let share = product(&image, &direction.image) / direction.squared;
                subtract_scaled(&mut along, share, &direction.along);
                subtract_scaled(&mut image, share, &direction.image);
            }
            let squared = product(&image, &image);
            let step = product(&r, &image) / squared;
            if !step.is_finite() {
                break;
            }
            subtract_scaled(x, -step, &along);
            subtract_scaled(&mut r, step, &image);
            if directions.len() == MAX_DIRECTIONS {
                directions.pop_front();
            }
            directions.push_back(Direction { along, image, squared });
            let now = product(&r, &r);
            idle = if now < 0.9 * least { 0 } else { idle + 1 };
            least = least.min(now);
            if largest(&r) <= enough || idle == IDLE_STEPS {
                // The updated residual has accumulated rounding: recompute it.
                residual(x, &mut r);
                let before = std::mem::replace(&mut exact, largest(&r));
                if exact > 0.5 * before {
                    break;
                }
                directions.clear();
                (least, idle) = (product(&r, &r), 0);
            }
        }
        residual(x, &mut r);
        largest(&r)
    }
}

/// A previous step.
struct Direction {
    along: Vec<f64>,
    image: Vec<f64>,
    squared: f64,
}

/// The larger one; NaN stays.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a -= share b`.
fn subtract_scaled(a: &mut [f64], share: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= share * b);
}
