//! Tree of Haar coefficients (section 4.2) and its synthesis. The encoder has the analysis.

use super::lift::{Lift, rise};
use num_traits::Float;

/// Coefficient indices of the latitude and the longitude detail of one step from level `j` to `j + 1`.
///
/// Coefficient 0 is the scaling coefficient. Level `j` starts at `4^j`: first `2^j x 2^j` latitude details, then
/// `2^(j+1)` rows of `2^j` longitude details.
pub fn detail_indices(j: u32, parent_column: usize, parent_row: usize, child_row: usize) -> (usize, usize) {
    let side = 1usize << j;
    let first = side * side;
    (first + parent_row * side + parent_column, 2 * first + child_row * side + parent_column)
}

/// Mean of two halves.
pub trait Mean<T> {
    /// True if the rise is not always zero.
    const RAISED: bool;
    /// Rise over the mean of two rows with detail `h`, for the pair `row` at level `j`, in units of the samples. `unit`
    /// is the unit of the detail.
    fn of_rows(&self, h: T, unit: T, j: u32, row: usize) -> T;
    /// Same for two columns.
    fn of_columns(&self, h: T, unit: T, j: u32, column: usize) -> T;
}

/// Mean of the transformed values, as in the paper.
pub struct Plain;

impl<T: Float> Mean<T> for Plain {
    const RAISED: bool = false;

    fn of_rows(&self, _: T, _: T, _: u32, _: usize) -> T {
        T::zero()
    }

    fn of_columns(&self, _: T, _: T, _: u32, _: usize) -> T {
        T::zero()
    }
}

/// Logarithm of the mean of values whose logarithms are transformed.
impl Mean<f32> for Lift {
    const RAISED: bool = true;

    fn of_rows(&self, h: f32, unit: f32, j: u32, row: usize) -> f32 {
        rise(h / unit, self.latitude(j, row)) * unit
    }

    fn of_columns(&self, h: f32, unit: f32, j: u32, column: usize) -> f32 {
        rise(h / unit, self.longitude(j, column)) * unit
    }
}

/// Synthesis, the inverse of `l = (a + b) / √2`, `h = (a - b) / √2`: `a = (l + h) / √2`, `b = (l - h) / √2`, after
/// subtraction of the rise from `l`. `split` is scratch memory.
pub fn inverse<T: Float, M: Mean<T>>(coefficients: &[T], n: usize, mean: &M, samples: &mut [T], split: &mut Vec<T>) {
    let r = T::from(std::f64::consts::FRAC_1_SQRT_2).expect("every float holds 1/√2");
    split.clear();
    split.resize(n * n, T::zero());
    samples[0] = coefficients[0];
    let mut half = 1;
    while half < n {
        let (of_rows, of_columns) = units(half, n);
        let j = half.ilog2();
        let (latitude, longitude) = coefficients[half * half..4 * half * half].split_at(half * half);
        for row in 0..half {
            for column in 0..half {
                let h = latitude[row * half + column];
                let mut l = samples[row * half + column];
                if M::RAISED {
                    l = l - mean.of_rows(h, of_rows, j, row);
                }
                split[2 * row * half + column] = (l + h) * r;
                split[(2 * row + 1) * half + column] = (l - h) * r;
            }
        }
        for cell in 0..2 * half * half {
            let h = longitude[cell];
            let mut l = split[cell];
            if M::RAISED {
                l = l - mean.of_columns(h, of_columns, j, cell % half);
            }
            samples[2 * cell] = (l + h) * r;
            samples[2 * cell + 1] = (l - h) * r;
        }
        half *= 2;
    }
}

/// Scale of a sample of 1 in the details of rows and of columns with `half` pairs per side: `n / half`, and that
/// divided by √2.
pub fn units<T: Float>(half: usize, n: usize) -> (T, T) {
    let rows = T::from(n / half).expect("every float holds small powers of two");
    (rows, rows * T::from(std::f64::consts::FRAC_1_SQRT_2).expect("every float holds 1/√2"))
}
