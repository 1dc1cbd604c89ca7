//! Fits basis and weights to some texels by alternating least squares: each in turn, the other fixed.

use super::basis::{Basis, Squares};
use super::matrix::{Rows, add_product, add_square, packed_length, solve};
use super::sample::Values;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Texels of a strip, the unit of parallel work.
const STRIP: usize = 64;
/// Ridge for weights and for the basis, as a share of the mean of the diagonal.
const WEIGHT_RIDGE: f64 = 1e-4;
const BASIS_RIDGE: f64 = 1e-5;
/// Additional columns of the first guess of a basis, and its number of power iterations.
const OVERSAMPLING: usize = 8;
const GUESS_ROUNDS: usize = 2;
const SEED: u64 = 0xb515;

/// A basis, and the weights of the fitted texels.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) basis: Basis,
    /// Texels x K.
    pub(super) weights: Vec<f32>,
}

impl Fit {
    /// Computes a first guess of `components`: the leading singular vectors of the lit values. `fit_roots` are factors of
    /// cube roots: `texels x L`.
    ///
    /// Multiplies with the values `2 (GUESS_ROUNDS + 1)` times; takes another `4 K (3 V L + texels)` bytes.
    pub(super) fn guess(values: &Values, fit_roots: &[f32], components: usize) -> Self {
        let (views, lights, texels) = (values.views, values.lights, values.texels);
        let columns = components + OVERSAMPLING;
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut left: Vec<f32> = (0..texels * columns).map(|_| random.random::<f32>() - 0.5).collect();
        let mut basis = Basis { views, lights, components: columns, values: Vec::new() };
        for _ in 0..=GUESS_ROUNDS {
            orthonormalise(&mut left, columns);
            basis.values = right_side(values, fit_roots, &left, columns);
            left = weighted_sums(values, fit_roots, &basis);
        }
        orthonormalise(&mut left, columns);
        basis.values = right_side(values, fit_roots, &left, columns);
        let sorted = basis.sorted(&mut left);
        let weights = left.chunks_exact(columns).flat_map(|row| row[..components].iter().copied()).collect();
        Self { basis: sorted.truncated(components), weights }
    }

    /// Runs one round: weights, then the basis.
    pub(super) fn improve(&mut self, values: &Values, fit_roots: &[f32]) {
        let squares = self.basis.squares();
        self.weights = solve_weights(values, fit_roots, &self.basis, &squares);
        drop(squares);
        self.basis.values = solve_basis(values, fit_roots, &self.weights, &self.basis);
        self.basis = self.basis.sorted(&mut self.weights);
    }

    /// Prior of the weights for a noise of `variance` per value: added to the diagonal when solving for them.
    pub(super) fn prior(&self, variance: f64) -> Vec<f64> {
        let k = self.basis.components;
        let count = (self.weights.len() / k).max(1) as f64;
        (0..k)
            .map(|component| {
                let energy = |row: &[f32]| f64::from(row[component]).powi(2);
                variance / (self.weights.chunks_exact(k).map(energy).sum::<f64>() / count).max(1e-9)
            })
            .collect()
    }
}

/// Orthonormalises the columns of rows by Gram and Schmidt, twice. Linearly dependent columns become 0.
fn orthonormalise(rows: &mut [f32], columns: usize) {
    let count = rows.len() / columns;
    let mut by_columns: Vec<Vec<f64>> =
        (0..columns).map(|k| (0..count).map(|row| f64::from(rows[row * columns + k])).collect()).collect();
    for k in 0..columns {
        let (done, rest) = by_columns.split_at_mut(k);
        let own = &mut rest[0];
        let before = own.iter().map(|x| x * x).sum::<f64>();
        for _ in 0..2 {
            for other in done.iter() {
                let share: f64 = own.iter().zip(other).map(|(a, b)| a * b).sum();
                own.iter_mut().zip(other).for_each(|(a, b)| *a -= share * b);
            }
        }
        let length = own.iter().map(|x| x * x).sum::<f64>();
        let scale = if length > 1e-14 * before { 1.0 / length.sqrt() } else { 0.0 };
        own.iter_mut().for_each(|x| *x *= scale);
    }
    for (k, column) in by_columns.iter().enumerate() {
        column.iter().enumerate().for_each(|(row, x)| rows[row * columns + k] = *x as f32);
    }
}

/// Computes `Xᵀ left`: rows of the values' columns.
fn right_side(values: &Values, fit_roots: &[f32], left: &[f32], columns: usize) -> Vec<f32> {
    let length = 3 * values.lights;
    let mut result = vec![0.0; values.views * length * columns];
    result.par_chunks_mut(length * columns).enumerate().for_each(|(view, target)| {
        let mut rows = Vec::new();
        values.scaled(view, 0..values.texels, fit_roots, &mut rows);
        let left = Rows::new(left, values.texels, columns);
        add_product(target, columns, Rows::new(&rows, values.texels, length).transposed(), left);
    });
    result
}

/// Computes `X basis`: a row of K per texel.
fn weighted_sums(values: &Values, fit_roots: &[f32], basis: &Basis) -> Vec<f32> {
    let k = basis.components;
    let mut sums = vec![0.0; values.texels * k];
    sums.par_chunks_mut(STRIP * k).enumerate().for_each(|(strip, sums)| {
        let (first, count) = (strip * STRIP, sums.len() / k);
        let mut rows = Vec::new();
        for view in 0..values.views {
            values.scaled(view, first..first + count, fit_roots, &mut rows);
            add_product(sums, k, Rows::new(&rows, count, 3 * values.lights), basis.view(view));
        }
    });
    sums
}

/// Least squares weights of all texels, for a given basis and fit_roots.
fn solve_weights(values: &Values, fit_roots: &[f32], basis: &Basis, squares: &Squares) -> Vec<f32> {
    let (k, lights) = (basis.components, values.lights);
    let mut weights = weighted_sums(values, fit_roots, basis);
    weights.par_chunks_mut(STRIP * k).enumerate().for_each(|(strip, weights)| {
        let (first, count) = (strip * STRIP, weights.len() / k);
        let mut sums = vec![0.0; count * squares.length];
        let mut factors = Vec::new();
        for view in 0..values.views {
            lit_squares(values, fit_roots, view, first..first + count, &mut factors);
            add_product(&mut sums, squares.length, Rows::new(&factors, count, lights), squares.view(view));
        }
        let mut room = Vec::new();
        for (weights, packed) in weights.chunks_exact_mut(k).zip(sums.chunks_exact(squares.length)) {
            let ridge = WEIGHT_RIDGE * trace(packed, k).max(1e-6 * k as f64) / k as f64 + 1e-6;
            let mut right: Vec<f64> = weights.iter().map(|sum| f64::from(*sum)).collect();
            solve(packed, |_| ridge, &mut right, &mut room);
            weights.iter_mut().zip(right).for_each(|(weight, solved)| *weight = solved as f32);
        }
    });
    weights
}

/// Weight of a view of each texel times the squares of its fit_roots: `texels x L`.
fn lit_squares(
    values: &Values,
    fit_roots: &[f32],
    view: usize,
    texels: std::ops::Range<usize>,
    factors: &mut Vec<f32>,
) {
    factors.clear();
    for texel in texels {
        let weight = values.weight(view, texel);
        factors.extend(fit_roots[texel * values.lights..][..values.lights].iter().map(|s| weight * s * s));
    }
}

pub(super) fn trace(packed: &[f32], side: usize) -> f64 {
    let mut at = 0;
    let mut sum = 0.0;
    for row in 0..side {
        sum += f64::from(packed[at]);
        at += side - row;
    }
    sum
}

/// Least squares basis, with a ridge towards its previous values.
fn solve_basis(values: &Values, fit_roots: &[f32], weights: &[f32], before: &Basis) -> Vec<f32> {
    let (k, lights, texels) = (before.components, values.lights, values.texels);
    let length = packed_length(k);
    let mut squares = vec![0.0; texels * length];
    squares.par_chunks_mut(length).zip(weights.par_chunks(k)).for_each(|(packed, row)| add_square(packed, row));
    let mut values_of_views = before.values.clone();
    values_of_views.par_chunks_mut(3 * lights * k).enumerate().for_each(|(view, target)| {
        let mut factors = Vec::new();
        lit_squares(values, fit_roots, view, 0..texels, &mut factors);
        let mut sums = vec![0.0; lights * length];
        let factors = Rows::new(&factors, texels, lights).transposed();
        add_product(&mut sums, length, factors, Rows::new(&squares, texels, length));
        let mut rows = Vec::new();
        values.scaled(view, 0..texels, fit_roots, &mut rows);
        let mut right = vec![0.0; 3 * lights * k];
        let weights = Rows::new(weights, texels, k);
        add_product(&mut right, k, Rows::new(&rows, texels, 3 * lights).transposed(), weights);
        let mut room = Vec::new();
        for ((target, packed), right) in
            target.chunks_exact_mut(3 * k).zip(sums.chunks_exact(length)).zip(right.chunks_exact(3 * k))
        {
            let ridge = BASIS_RIDGE * trace(packed, k) / k as f64 + 1e-3;
            let pulled = right.iter().zip(target.iter()).map(|(sum, old)| f64::from(*sum) + ridge * f64::from(*old));
            let mut right: Vec<f64> = pulled.collect();
            solve(packed, |_| ridge, &mut right, &mut room);
            target.iter_mut().zip(right).for_each(|(number, solved)| *number = solved as f32);
        }
    });
    values_of_views
}
