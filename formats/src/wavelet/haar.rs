//! Tree of Haar coefficients (section 4.2) and its synthesis. The encoder has the analysis.

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

/// Synthesis, the inverse of `l = (a + b) / √2`, `h = (a - b) / √2`: `a = (l + h) / √2`, `b = (l - h) / √2`. `split` is
/// scratch memory.
pub fn inverse<T: Float>(coefficients: &[T], n: usize, samples: &mut [T], split: &mut Vec<T>) {
    let r = T::from(std::f64::consts::FRAC_1_SQRT_2).expect("every float holds 1/√2");
    split.clear();
    split.resize(n * n, T::zero());
    samples[0] = coefficients[0];
    let mut half = 1;
    while half < n {
        let (latitude, longitude) = coefficients[half * half..4 * half * half].split_at(half * half);
        for row in 0..half {
            for column in 0..half {
                let (l, h) = (samples[row * half + column], latitude[row * half + column]);
                split[2 * row * half + column] = (l + h) * r;
                split[(2 * row + 1) * half + column] = (l - h) * r;
            }
        }
        for cell in 0..2 * half * half {
            let (l, h) = (split[cell], longitude[cell]);
            samples[2 * cell] = (l + h) * r;
            samples[2 * cell + 1] = (l - h) * r;
        }
        half *= 2;
    }
}
