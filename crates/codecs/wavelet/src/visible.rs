//! Perceptually weighted thresholding: slices ranked by their effect on renderings instead of on the table.
//!
//! Plain energy gives all cells of the table the same weight. A third of them are within 20 degrees of the horizon,
//! where values are large, vary most, and fill hardly any pixels. Here the weight of each sample is the effect of its
//! error on renderings.

use super::haar::flip_coefficient;
use super::log_encode::LogEncoding;
use super::table::Table;
use brdfc_formats::direction::{DirectionPair, Vector, cell_centre};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Reflected light, `f_r cos θi` in units of `μ`, below which differences become invisible.
const DARK: f64 = 0.01;
/// Exponents of `cos θi` and `cos θo` in the weight of a sample.
const EXPONENTS: [f64; 2] = [1.35, 2.25];

/// Weighted squared norm of each coefficient over all outer cells and channels: `E_k = Σ c_k² w_k`, with `w_k` the mean
/// of `weight` over the inner cells that the coefficient changes.
///
/// `coefficients` belong to the log-encoded `samples`.
pub fn visible_energies(coefficients: &Table, samples: &Table, encoding: LogEncoding) -> Vec<f64> {
    let (channels, rows, cells) = coefficients.values.dim();
    let grid = coefficients.grid;
    let n = grid.n();
    let (inner_cells, outer_cells) = (Cells::new(n), Cells::new(coefficients.fold.n));
    let of_row = |row: usize| {
        let outer = coefficients.fold.rows()[row] as usize;
        let (mut energies, mut weights) = (vec![0.0; cells], vec![0.0; cells]);
        for channel in 0..channels {
            for ((inner, weight_here), f) in weights.iter_mut().enumerate().zip(samples.row(channel, row)) {
                let pair = grid.parameterisation.from_axes(outer_cells.centres[outer], inner_cells.centres[inner]);
                *weight_here =
                    outer_cells.areas[outer] * inner_cells.areas[inner] * weight(pair, f64::from(*f), encoding);
            }
            add_energies(&mut weights, n, coefficients.row(channel, row), &mut energies);
        }
        energies
    };
    let by_row: Vec<Vec<f64>> = (0..rows).into_par_iter().map(of_row).collect();
    let mut stored = vec![0.0; cells];
    for energies in &by_row {
        stored.iter_mut().zip(energies).for_each(|(sum, energy)| *sum += energy);
    }
    // As in `slice_energies`: weights have the symmetry of the table.
    let whole = |k: usize| {
        let mut parts: Vec<f64> =
            coefficients.fold.flips().iter().map(|flip| stored[flip_coefficient(k, *flip).0]).collect();
        parts.sort_by(f64::total_cmp);
        parts.iter().sum()
    };
    (0..cells).map(whole).collect()
}

/// Cells of a grid of `n x n`.
struct Cells {
    centres: Vec<Vector>,
    /// Solid angles, up to a common factor.
    areas: Vec<f64>,
}

impl Cells {
    fn new(n: usize) -> Self {
        let centre = |cell| cell_centre(cell % n, cell / n, n);
        let area = |cell| (PI * ((cell / n) as f64 + 0.5) / n as f64).sin();
        Self { centres: (0..n * n).map(centre).collect(), areas: (0..n * n).map(area).collect() }
    }
}

/// Effect of a squared error of the log-encoded value on renderings.
///
/// The eye sees ratios of reflected light `y = f_r cos θi`, so an error `dv` counts as `d ln(y + DARK)`. The weight of
/// a pair is its frequency in renderings: grazing light falls on few surfaces, and surfaces at grazing angles to the
/// viewer are foreshortened and near outlines. The natural exponents of the cosines are 1 and 2; these are slightly
/// higher, chosen by the colour differences of renderings of measured materials.
fn weight(pair: DirectionPair, f: f64, encoding: LogEncoding) -> f64 {
    if !pair.is_above_horizon() {
        return 0.0;
    }
    let (cosine_in, cosine_out) = (pair.incoming[2], pair.outgoing[2]);
    let relative = f / encoding.mean;
    // dv = df / (f + ε μ).
    let slope = cosine_in * (relative + encoding.bias) / (cosine_in * relative + DARK);
    slope * slope * cosine_in.powf(EXPONENTS[0]) * cosine_out.powf(EXPONENTS[1])
}

/// Adds `c² w` of every coefficient of one inner image; `weights` becomes scratch space. The order of halving is that
/// of [`super::haar::forward`].
fn add_energies(weights: &mut [f64], n: usize, coefficients: &[f32], energies: &mut [f64]) {
    let mut add =
        |k: usize, weight: f64| energies[k] += weight * f64::from(coefficients[k]) * f64::from(coefficients[k]);
    let mut size = n;
    while size > 1 {
        let half = size / 2;
        for row in 0..size {
            for column in 0..half {
                let mean = 0.5 * (weights[row * size + 2 * column] + weights[row * size + 2 * column + 1]);
                add(2 * half * half + row * half + column, mean);
                weights[row * half + column] = mean;
            }
        }
        for row in 0..half {
            for column in 0..half {
                let mean = 0.5 * (weights[2 * row * half + column] + weights[(2 * row + 1) * half + column]);
                add(half * half + row * half + column, mean);
                weights[row * half + column] = mean;
            }
        }
        size = half;
    }
    add(0, weights[0]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::haar;
    use crate::log_encode::log_encode;
    use crate::resample::resample;
    use crate::table::Grid;
    use crate::threshold::{keep, ranking, slice_energies};
    use brdfc_core::analytic::Ggx;
    use brdfc_formats::direction::Parameterisation;

    const ENCODING: LogEncoding = LogEncoding { mean: 0.5, bias: 3e-4 };

    #[test]
    fn grazing_and_dark_count_less() {
        let at = |theta_i, theta_o, f| weight(DirectionPair::from_angles(theta_i, 0.3, theta_o, 2.0), f, ENCODING);
        assert!(at(1.4, 0.2, 0.5) < 0.3 * at(0.2, 0.2, 0.5));
        assert!(at(0.2, 1.4, 0.5) < 0.1 * at(0.2, 0.2, 0.5));
        assert!(at(0.2, 0.2, 1e-4) < 0.5 * at(0.2, 0.2, 0.5));
        // The eye sees ratios: bright and brighter values have equal weights.
        assert!((at(0.2, 0.2, 50.0) / at(0.2, 0.2, 5.0) - 1.0).abs() < 0.02);
        assert_eq!(at(1.6, 0.2, 0.5), 0.0);
    }

    #[test]
    fn equal_weights_give_plain_energies() {
        let coefficients: Vec<f32> = (0..64).map(|k| k as f32 - 20.0).collect();
        let mut energies = vec![0.0; 64];
        add_energies(&mut [1.0; 64], 8, &coefficients, &mut energies);
        assert!(coefficients.iter().zip(&energies).all(|(c, e)| f64::from(c * c) == *e));
    }

    #[test]
    fn a_coefficient_has_the_mean_weight_of_what_it_changes() {
        let n = 8;
        let weights: Vec<f64> = (0..n * n).map(|i| 1.0 + (i * i % 13) as f64).collect();
        for k in 0..n * n {
            let mut coefficients = vec![0.0f32; n * n];
            coefficients[k] = 1.0;
            let mut samples = vec![0.0f32; n * n];
            haar::inverse(&coefficients, n, &mut samples, &mut Vec::new());
            let expected: f64 = samples.iter().zip(&weights).map(|(s, w)| f64::from(s * s) * w).sum();
            let mut energies = vec![0.0; n * n];
            add_energies(&mut weights.clone(), n, &coefficients, &mut energies);
            assert!((energies[k] - expected).abs() < 1e-5 * expected, "{k}: {} {expected}", energies[k]);
        }
    }

    /// With as many slices, the weighted error is smaller than with plain energy.
    #[test]
    fn visible_ranking_has_a_smaller_visible_error() {
        let source = Ggx { kd: [0.1; 3], f0: [0.5; 3], alpha_x: 0.25, alpha_y: 0.25 };
        let grid = Grid { parameterisation: Parameterisation::TangentPole, levels: 4 };
        let (samples, _) = resample(&source, grid);
        let encoding = LogEncoding::of(&samples, 0.01);
        let coefficients = haar::transform(&log_encode(&samples, encoding));
        let visible = visible_energies(&coefficients, &samples, encoding);
        let plain = slice_energies(&coefficients);
        // Dropped coefficients are lost; losses within one image overlap, so the sum is an estimate.
        let lost = |by: &[f64], of: &[f64]| {
            let slices = keep(&ranking(by, 4), 32);
            let dropped = (0..of.len()).filter(|k| !slices.contains(&(*k as u32)));
            dropped.map(|k| of[k]).sum::<f64>()
        };
        assert!(lost(&visible, &visible) < 0.9 * lost(&plain, &visible));
        assert!(lost(&plain, &plain) < 0.9 * lost(&visible, &plain));
    }
}
