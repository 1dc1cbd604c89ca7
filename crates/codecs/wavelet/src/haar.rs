//! The Haar transform (section 4.2 and equation 2 of Claustres et al. 2007), over the inner hemisphere.
//!
//! One level splits along longitude, then splits the smooth half along latitude. Coefficients are numbered as in
//! [`brdfc_formats::wavelet::haar`]: 0 is the scaling coefficient, level `j` starts at `4^j` with `2^j x 2^j` latitude
//! details, followed by `2^(j+1)` rows of `2^j` longitude details.

use super::fold::Flip;
use super::table::Table;
pub use brdfc_formats::wavelet::haar::inverse;
use num_traits::Float;
use rayon::prelude::*;

/// Analysis (equation 2, left) of one image of `n` x `n` samples (row by row, `n` a power of two) into as many
/// coefficients: `l = (a + b) / √2`, `h = (a - b) / √2`. `smooth` is scratch space.
pub fn forward<T: Float>(samples: &[T], n: usize, coefficients: &mut [T], smooth: &mut Vec<T>) {
    let r = T::from(std::f64::consts::FRAC_1_SQRT_2).expect("every float holds 1/√2");
    smooth.clear();
    smooth.extend_from_slice(samples);
    let mut size = n;
    while size > 1 {
        let half = size / 2;
        let (latitude, longitude) = coefficients[half * half..4 * half * half].split_at_mut(half * half);
        for row in 0..size {
            for column in 0..half {
                let (a, b) = (smooth[row * size + 2 * column], smooth[row * size + 2 * column + 1]);
                longitude[row * half + column] = (a - b) * r;
                smooth[row * half + column] = (a + b) * r;
            }
        }
        for row in 0..half {
            for column in 0..half {
                let (a, b) = (smooth[2 * row * half + column], smooth[(2 * row + 1) * half + column]);
                latitude[row * half + column] = (a - b) * r;
                smooth[row * half + column] = (a + b) * r;
            }
        }
        size = half;
    }
    coefficients[0] = smooth[0];
}

/// Transforms every row of a table.
pub fn transform(table: &Table) -> Table {
    let (n, cells) = (table.grid.n(), table.grid.cells());
    let mut result = table.clone();
    let values = result.values.as_slice_mut().expect("tables are stored in standard layout");
    values.par_chunks_mut(cells).for_each_init(
        || (vec![0.0; cells], Vec::new()),
        |(coefficients, scratch), row| {
            forward(row, n, coefficients, scratch);
            row.copy_from_slice(coefficients);
        },
    );
    result
}

/// Effect of a flip of the samples on coefficients: `coefficient k of the flipped image = sign * coefficient[image]`.
/// Details across the flipped axis change sign.
pub fn flip_coefficient(k: usize, flip: Flip) -> (usize, f32) {
    if k == 0 {
        return (0, 1.0);
    }
    let side = 1usize << (k.ilog2() / 2);
    let first = side * side;
    let longitude = k >= 2 * first;
    let (base, rows) = if longitude { (2 * first, 2 * side) } else { (first, side) };
    let (row, column) = ((k - base) / side, (k - base) % side);
    let image_row = if flip.rows { rows - 1 - row } else { row };
    let image_column = if flip.columns { side - 1 - column } else { column };
    let changes_sign = if longitude { flip.columns } else { flip.rows };
    (base + image_row * side + image_column, if changes_sign { -1.0 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn transformed<T: Float>(samples: &[T], n: usize) -> Vec<T> {
        let mut coefficients = vec![T::zero(); n * n];
        forward(samples, n, &mut coefficients, &mut Vec::new());
        coefficients
    }

    fn restored<T: Float>(coefficients: &[T], n: usize) -> Vec<T> {
        let mut samples = vec![T::zero(); n * n];
        inverse(coefficients, n, &mut samples, &mut Vec::new());
        samples
    }

    fn images() -> impl Strategy<Value = (usize, Vec<f64>)> {
        (1u32..=5).prop_flat_map(|levels| {
            let n = 1usize << levels;
            let wide =
                prop_oneof![-10.0f64..10.0, (-12.0f64..6.0).prop_map(|e| 10f64.powf(e)), Just(1e-310), Just(0.0)];
            (Just(n), prop::collection::vec(wide, n * n))
        })
    }

    proptest! {
        #[test]
        fn reconstruction_is_perfect((n, samples) in images()) {
            let largest = samples.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            for (a, b) in samples.iter().zip(restored(&transformed(&samples, n), n)) {
                prop_assert!((a - b).abs() <= 1e-13 * largest);
            }
        }

        #[test]
        fn energy_is_preserved((n, samples) in images()) {
            let energy = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
            let (before, after) = (energy(&samples), energy(&transformed(&samples, n)));
            prop_assert!((before - after).abs() <= 1e-12 * before);
        }

        #[test]
        fn single_precision_follows_double((n, samples) in images()) {
            let single: Vec<f32> = samples.iter().map(|v| *v as f32).collect();
            let norm = samples.iter().map(|v| v * v).sum::<f64>().sqrt();
            for (a, b) in transformed(&samples, n).into_iter().zip(transformed(&single, n)) {
                prop_assert!((a - f64::from(b)).abs() <= 2e-6 * norm + f64::from(f32::MIN_POSITIVE));
            }
        }

        #[test]
        fn flips_permute_coefficients((n, samples) in images(), which in 0usize..4) {
            let flip = Flip::ALL[which];
            let flipped: Vec<f64> = (0..n * n).map(|cell| samples[flip.cell(cell, n)]).collect();
            let (plain, image) = (transformed(&samples, n), transformed(&flipped, n));
            for k in 0..n * n {
                let (from, sign) = flip_coefficient(k, flip);
                prop_assert!((image[k] - f64::from(sign) * plain[from]).abs() <= 1e-9 * (1.0 + plain[from].abs()));
            }
        }
    }

    #[test]
    fn a_constant_has_only_a_scaling_coefficient() {
        let coefficients = transformed(&[3.0f64; 64], 8);
        assert!((coefficients[0] - 24.0).abs() < 1e-12);
        assert!(coefficients[1..].iter().all(|c| c.abs() < 1e-12));
    }

    #[test]
    fn a_longitude_edge_is_one_longitude_detail() {
        let samples: Vec<f64> = (0..16).map(|cell| if cell % 4 < 2 { 1.0 } else { -1.0 }).collect();
        let coefficients = transformed(&samples, 4);
        let large: Vec<usize> = (0..16).filter(|k| coefficients[*k].abs() > 1e-12).collect();
        assert_eq!(large, [2, 3], "level 0: two rows of one longitude detail");
    }
}
