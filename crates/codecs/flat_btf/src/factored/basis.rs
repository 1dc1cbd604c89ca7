//! Components of each view and light, as floats.

use super::matrix::{Rows, add_product, add_square, packed_length};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// `V x L` pairs of a view and a light, each with three rows of K components: lightness and two opponent colours.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Basis {
    pub(super) views: usize,
    pub(super) lights: usize,
    pub(super) components: usize,
    /// View by view, light by light, colour by colour.
    pub(super) values: Vec<f32>,
}

impl Basis {
    /// The rows of a view: `3 L x K`.
    pub(super) fn view(&self, view: usize) -> Rows<'_> {
        let length = 3 * self.lights * self.components;
        Rows::new(&self.values[view * length..][..length], 3 * self.lights, self.components)
    }

    /// The rows of a pair: `3 x K`.
    pub(super) fn pair(&self, view: usize, light: usize) -> &[f32] {
        let length = 3 * self.components;
        &self.values[(view * self.lights + light) * length..][..length]
    }

    /// For each pair the packed sum of squares of its rows: `Bᵀ B`. Bytes: `2 V L K (K + 1)`.
    pub(super) fn squares(&self) -> Squares {
        let length = packed_length(self.components);
        let mut numbers = vec![0.0; self.views * self.lights * length];
        let pairs = self.values.par_chunks_exact(3 * self.components);
        numbers.par_chunks_exact_mut(length).zip(pairs).for_each(|(packed, rows)| {
            rows.chunks_exact(self.components).for_each(|row| add_square(packed, row));
        });
        Squares { lights: self.lights, length, numbers }
    }

    /// The basis truncated to its leading components.
    pub(super) fn truncated(&self, components: usize) -> Self {
        let values = self.values.chunks_exact(self.components).flat_map(|row| row[..components].iter().copied());
        Self { components, values: values.collect(), ..*self }
    }

    /// Returns the same product with orthonormal columns, sorted by decreasing energy of their weights. `weights`:
    /// texels x K.
    pub(super) fn sorted(&self, weights: &mut Vec<f32>) -> Self {
        let k = self.components;
        let own = gram(&self.values, k);
        let theirs = gram(weights, k);
        if !own.iter().chain(theirs.iter()).all(|value| value.is_finite()) {
            return self.clone();
        }
        // Own = V Λ Vᵀ: B V Λ^-½ is orthonormal, weights become W V Λ^½.
        let eigen = own.symmetric_eigen();
        let floor = eigen.eigenvalues.max() * 1e-12;
        // All values are black.
        if floor <= 0.0 {
            return self.clone();
        }
        let roots: Vec<f64> = eigen.eigenvalues.iter().map(|value| value.max(floor).sqrt()).collect();
        let scaled = |power: f64| {
            DMatrix::from_fn(k, k, |row, column| eigen.eigenvectors[(row, column)] * roots[column].powf(power))
        };
        let (shrink, grow) = (scaled(-1.0), scaled(1.0));
        let energy = (grow.transpose() * theirs * &grow).symmetric_eigen();
        let mut order: Vec<usize> = (0..k).collect();
        order.sort_by(|a, b| energy.eigenvalues[*b].total_cmp(&energy.eigenvalues[*a]));
        let turn = DMatrix::from_fn(k, k, |row, column| energy.eigenvectors[(row, order[column])]);
        *weights = turned(weights, &(grow * &turn));
        Self { values: turned(&self.values, &(shrink * &turn)), ..*self }
    }
}

/// Packed squares of all pairs.
#[derive(Debug, Clone)]
pub(super) struct Squares {
    lights: usize,
    /// Length of a packed matrix.
    pub(super) length: usize,
    numbers: Vec<f32>,
}

impl Squares {
    /// For a view, one row per light.
    pub(super) fn view(&self, view: usize) -> Rows<'_> {
        let length = self.lights * self.length;
        Rows::new(&self.numbers[view * length..][..length], self.lights, self.length)
    }

    /// For a light, one row per view.
    pub(super) fn light(&self, light: usize, views: usize) -> Rows<'_> {
        let stride = self.lights * self.length;
        let numbers = &self.numbers[light * self.length..];
        Rows { numbers, rows: views, columns: self.length, strides: [stride, 1] }
    }
}

/// `Aᵀ A` of rows of k numbers, in double precision.
fn gram(rows: &[f32], k: usize) -> DMatrix<f64> {
    // Fixed chunks, so that the sum does not depend on the number of threads.
    let pieces: Vec<DMatrix<f64>> = rows
        .par_chunks(4096 * k)
        .map(|piece| {
            let mut sum = DMatrix::zeros(k, k);
            for row in piece.chunks_exact(k) {
                for i in 0..k {
                    for j in i..k {
                        sum[(j, i)] += f64::from(row[i]) * f64::from(row[j]);
                    }
                }
            }
            sum
        })
        .collect();
    let lower = pieces.into_iter().fold(DMatrix::zeros(k, k), |sum, piece| sum + piece);
    DMatrix::from_fn(k, k, |row, column| lower[(row.max(column), row.min(column))])
}

/// Multiplies rows of k numbers with a matrix.
fn turned(rows: &[f32], matrix: &DMatrix<f64>) -> Vec<f32> {
    let k = matrix.nrows();
    let by_rows: Vec<f32> = (0..k * k).map(|at| matrix[(at / k, at % k)] as f32).collect();
    let mut result = vec![0.0; rows.len()];
    result.par_chunks_mut(1024 * k).zip(rows.par_chunks(1024 * k)).for_each(|(target, rows)| {
        add_product(target, k, Rows::new(rows, rows.len() / k, k), Rows::new(&by_rows, k, k));
    });
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorting_keeps_the_product() {
        let number = |k: usize| ((k * 7919) % 1009) as f32 / 504.5 - 1.0;
        let basis = Basis { views: 2, lights: 5, components: 6, values: (0..180).map(number).collect() };
        let mut weights: Vec<f32> = (0..6 * 8).map(|k| number(k + 555)).collect();
        let product = |basis: &Basis, weights: &[f32]| -> Vec<f32> {
            let row = |weights: &[f32]| -> Vec<f32> {
                basis.values.chunks_exact(6).map(|row| row.iter().zip(weights).map(|(b, w)| b * w).sum()).collect()
            };
            weights.chunks_exact(6).flat_map(row).collect()
        };
        let before = product(&basis, &weights);
        let sorted = basis.sorted(&mut weights);
        for (a, b) in before.iter().zip(product(&sorted, &weights)) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
        let (own, theirs) = (gram(&sorted.values, 6), gram(&weights, 6));
        for i in 0..6 {
            for j in 0..6 {
                assert!((own[(i, j)] - f64::from(u8::from(i == j))).abs() < 1e-5, "{own}");
                assert!(i == j || theirs[(i, j)].abs() < 1e-4 * theirs[(0, 0)], "{theirs}");
            }
            assert!(i == 0 || theirs[(i, i)] <= theirs[(i - 1, i - 1)]);
        }
    }
}
