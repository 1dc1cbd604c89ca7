//! Matrices in slices, row by row: products and packed symmetric matrices.

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};

/// A matrix in a slice, with row and column strides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) numbers: &'a [f32],
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) strides: [usize; 2],
}

impl<'a> Rows<'a> {
    /// Rows without gaps.
    pub(super) fn new(numbers: &'a [f32], rows: usize, columns: usize) -> Self {
        Self { numbers, rows, columns, strides: [columns, 1] }
    }

    pub(super) fn transposed(self) -> Self {
        let [row, column] = self.strides;
        Self { rows: self.columns, columns: self.rows, strides: [column, row], ..self }
    }

    fn view(self) -> DMatrixView<'a, f32, Dyn, Dyn> {
        let [row, column] = self.strides;
        DMatrixView::from_slice_with_strides(self.numbers, self.rows, self.columns, row, column)
    }
}

/// Smallest side of a product that the library computes; its own path for smaller ones reads beyond matrices with
/// strides.
const MIN_SIDE: usize = 6;

/// `sum += a b`; rows of the sum are `stride` apart.
pub(super) fn add_product(sum: &mut [f32], stride: usize, a: Rows<'_>, b: Rows<'_>) {
    assert_eq!(a.columns, b.rows, "sides of a product");
    if a.rows.min(a.columns).min(b.columns) >= MIN_SIDE {
        let mut sum = DMatrixViewMut::from_slice_with_strides_mut(sum, a.rows, b.columns, stride, 1);
        let sum: &mut DMatrixViewMut<'_, f32, Dyn, Dyn> = &mut sum;
        sum.gemm(1.0, &a.view(), &b.view(), 1.0);
        return;
    }
    for (row, sum) in sum.chunks_mut(stride).take(a.rows).enumerate() {
        for k in 0..a.columns {
            let factor = a.numbers[row * a.strides[0] + k * a.strides[1]];
            for (column, sum) in sum[..b.columns].iter_mut().enumerate() {
                *sum += factor * b.numbers[k * b.strides[0] + column * b.strides[1]];
            }
        }
    }
}

/// Length of a packed symmetric matrix: row by row, each from the diagonal on.
pub(super) fn packed_length(side: usize) -> usize {
    side * (side + 1) / 2
}

/// `packed += v vᵀ`.
pub(super) fn add_square(packed: &mut [f32], v: &[f32]) {
    let mut rest = packed;
    for (i, factor) in v.iter().enumerate() {
        let (row, below) = rest.split_at_mut(v.len() - i);
        row.iter_mut().zip(&v[i..]).for_each(|(sum, other)| *sum += factor * other);
        rest = below;
    }
}

/// Solves `(A + ridge) x = b` for a packed positive semidefinite A and several consecutive right sides, in place.
/// `room` is overwritten.
pub(super) fn solve(packed: &[f32], ridge: impl Fn(usize) -> f64, right: &mut [f64], room: &mut Vec<f64>) {
    let columns = right.len();
    room.clear();
    room.extend(packed.iter().map(|number| f64::from(*number)));
    let side = ((8 * packed.len() + 1).isqrt() - 1) / 2;
    let start = |row: usize| row * side - row * row.saturating_sub(1) / 2;
    for row in 0..side {
        room[start(row)] += ridge(row);
    }
    // Gaussian elimination on the packed rows: they become pivots times unit triangular rows.
    for pivot in 0..side {
        let (done, below) = room.split_at_mut(start(pivot) + side - pivot);
        let row = &done[start(pivot)..];
        let scale = 1.0 / row[0].max(f64::MIN_POSITIVE);
        let mut rest = below;
        for k in 1..side - pivot {
            let (target, next) = rest.split_at_mut(side - pivot - k);
            let factor = row[k] * scale;
            target.iter_mut().zip(&row[k..]).for_each(|(number, other)| *number -= factor * other);
            for first in (0..columns).step_by(side) {
                right[first + pivot + k] -= factor * right[first + pivot];
            }
            rest = next;
        }
    }
    for first in (0..columns).step_by(side) {
        let right = &mut right[first..first + side];
        for row in (0..side).rev() {
            let numbers = &room[start(row)..][..side - row];
            let known: f64 = numbers[1..].iter().zip(&right[row + 1..]).map(|(a, x)| a * x).sum();
            right[row] = (right[row] - known) / numbers[0].max(f64::MIN_POSITIVE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, seed: u32) -> Vec<f32> {
        (0..count as u32).map(|k| ((k * 7919 + seed * 104_729) % 1009) as f32 / 504.5 - 1.0).collect()
    }

    #[test]
    fn products_are_those_of_rows() {
        for [rows, inner, columns] in
            [[7, 9, 8], [6, 6, 6], [1, 9, 8], [7, 3, 8], [12, 24, 2], [40, 300, 33], [1, 1, 1]]
        {
            let (a, b) = (numbers(rows * inner, 1), numbers(inner * columns, 2));
            let naive = |i: usize, j: usize| (0..inner).map(|k| a[inner * i + k] * b[columns * k + j]).sum::<f32>();
            let (ra, rb) = (Rows::new(&a, rows, inner), Rows::new(&b, inner, columns));
            let mut plain = vec![1.0; rows * columns];
            add_product(&mut plain, columns, ra, rb);
            let across: Vec<f32> = (0..columns * inner).map(|k| b[columns * (k % inner) + k / inner]).collect();
            let mut other = vec![1.0; rows * columns];
            add_product(&mut other, columns, ra, Rows::new(&across, columns, inner).transposed());
            let down: Vec<f32> = (0..inner * rows).map(|k| a[inner * (k % rows) + k / rows]).collect();
            // The last row of the sum has no padding.
            let stride = columns + 2;
            let mut third = vec![1.0; rows * stride - 2];
            add_product(&mut third, stride, Rows::new(&down, inner, rows).transposed(), rb);
            for i in 0..rows {
                for j in 0..columns {
                    for found in [plain[columns * i + j], other[columns * i + j], third[stride * i + j]] {
                        assert!((found - 1.0 - naive(i, j)).abs() < 1e-4, "{i}, {j}: {found}");
                    }
                }
            }
            assert!(rows == 1 || third[columns] == 1.0);
        }
    }

    #[test]
    fn packed_matrices_solve() {
        let side = 6;
        let mut packed = vec![0.0; packed_length(side)];
        (0..9).for_each(|k| add_square(&mut packed, &numbers(side, k)));
        let x = numbers(side, 77);
        // (A + ridge) x, from the squares that form A.
        let ridge = |k: usize| 0.01 * (k + 1) as f64;
        let mut right: Vec<f64> = (0..side).map(|k| ridge(k) * f64::from(x[k])).collect();
        for v in (0..9).map(|k| numbers(side, k)) {
            let share: f64 = v.iter().zip(&x).map(|(a, b)| f64::from(a * b)).sum();
            (0..side).for_each(|k| right[k] += f64::from(v[k]) * share);
        }
        let mut twice = [right.clone(), right.iter().map(|r| 2.0 * r).collect()].concat();
        solve(&packed, ridge, &mut twice, &mut Vec::new());
        for k in 0..side {
            assert!((twice[k] - f64::from(x[k])).abs() < 1e-4 && (twice[side + k] - 2.0 * twice[k]).abs() < 1e-9);
        }
    }
}
