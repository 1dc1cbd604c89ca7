//! Wavelet transforms compared with sums in f64, forward and inverse.

use super::fed::{Filling, Numbers, levels, table};
use super::row::{Measure, StressRow, U, Worst};
use super::stages::Stages;
use brdfc_core::Symmetry;
use brdfc_formats::wavelet::haar::detail_indices;
use brdfc_source::smooth::{Axis, Grid};
use std::f64::consts::PI;

fn norm(samples: &[f32]) -> f64 {
    // Below it, numbers of f32 have fewer digits.
    samples.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt() + f64::from(f32::MIN_POSITIVE)
}

/// Roundings through this number of levels: each halves twice, by a sum and a product with a rounded number.
fn roundings(levels: u32) -> f64 {
    f64::from(2 * levels) * 3.0 * U
}

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let [mut analysis, mut back, mut constants, mut daubechies] = [Worst::default(); 4];
    for levels in levels(small) {
        let n = 1usize << levels;
        for filling in Filling::ALL {
            let samples = filling.numbers(n * n, &mut Numbers::new(4));
            let (norm, bound) = (norm(&samples), roundings(levels));
            let coefficients = (stages.haar)(&samples, n);
            for (found, exact) in coefficients.iter().zip(sums(&samples, n)) {
                analysis.add((f64::from(*found) - exact) / (norm * bound));
            }
            for (found, exact) in (stages.haar_inverse)(&coefficients, n).iter().zip(&samples) {
                back.add(f64::from(found - exact) / (norm * 2.0 * bound));
            }
            if matches!(filling, Filling::Zero | Filling::Constant) {
                coefficients[1..].iter().for_each(|detail| constants.check(*detail == 0.0));
            }
            daubechies_there_and_back(stages, &samples, n, norm, &mut daubechies);
        }
    }
    let fed = "all grids: 1e-12 to 1e6, denormals, zeros, constants, a spike";
    let of_norm = "3 roundings at each of 2 N steps, relative to the norm of the image";
    vec![
        analysis.row(["Haar, f32", fed], Measure::OfBound, 1.0, of_norm),
        back.row(["Haar and back, f32", fed], Measure::OfBound, 1.0, "perfect reconstruction: twice as many steps"),
        constants.row(
            ["Haar, f32", "constant and zero images"],
            Measure::Count,
            0.0,
            "a - a is 0: no detail, so no slice",
        ),
        daubechies.row(
            ["Daubechies and back, f32", fed],
            Measure::OfBound,
            1.0,
            "16 products and sums at each of 4 N steps, relative to the norm of the image",
        ),
        means(stages),
        smooth(stages, small),
    ]
}

/// Coefficients by definition: differences of sums over blocks, times `2^-(N-j)`, of longitudes `√2` times that.
fn sums(samples: &[f32], n: usize) -> Vec<f64> {
    let levels = n.ilog2();
    let sum = |rows: [usize; 2], columns: [usize; 2]| -> f64 {
        (rows[0]..rows[1]).flat_map(|r| (columns[0]..columns[1]).map(move |c| f64::from(samples[r * n + c]))).sum()
    };
    let mut coefficients = vec![0.0; n * n];
    coefficients[0] = sum([0, n], [0, n]) / n as f64;
    for j in 0..levels {
        let (block, half) = (n >> j, n >> (j + 1));
        let scale = 1.0 / f64::from(1u32 << (levels - j));
        for row in 0..1usize << j {
            for column in 0..1usize << j {
                let (top, left) = (row * block, column * block);
                let columns = [left, left + block];
                for child in 0..2 {
                    let rows = [top + child * half, top + (child + 1) * half];
                    let (latitude, longitude) = detail_indices(j, column, row, 2 * row + child);
                    let sign = if child == 0 { scale } else { -scale };
                    coefficients[latitude] += sign * sum(rows, columns);
                    let apart = sum(rows, [left, left + half]) - sum(rows, [left + half, left + block]);
                    coefficients[longitude] = std::f64::consts::SQRT_2 * scale * apart;
                }
            }
        }
    }
    coefficients
}

fn daubechies_there_and_back(stages: &Stages, samples: &[f32], n: usize, norm: f64, worst: &mut Worst) {
    let bound = f64::from(4 * n.ilog2()) * 16.0 * U;
    for (found, exact) in (stages.daubechies)(samples, n).iter().zip(samples) {
        worst.add(f64::from(found - exact) / (norm * bound));
    }
}

/// Levels of detail keep `∫ f cos θ_o dω` of each outer cell.
fn means(stages: &Stages) -> StressRow {
    let mut worst = Worst::default();
    for levels in 2..=3 {
        let n = 1usize << levels;
        for filling in Filling::ALL {
            let samples: Vec<f32> = filling.numbers(n * n, &mut Numbers::new(5)).iter().map(|v| v.abs()).collect();
            let finest = table(levels, Symmetry::NONE, &samples);
            for level in 0..=levels {
                let coarse = (stages.means)(&finest, level);
                for row in 0..finest.fold.rows().len() {
                    let [found, exact] = [&coarse, &finest].map(|table| albedo(table.row(0, row)));
                    // Denormal numbers have few digits.
                    worst.add((found - exact) / (U * exact + PI * f64::from(f32::from_bits(1))));
                }
            }
        }
    }
    worst.row(
        ["means of levels, f32", "tables of 1e-12 to 1e6, denormals, zeros, constants, a spike, all levels"],
        Measure::OfBound,
        1.0,
        "one rounding of each mean, or a denormal step: the albedo of each outer cell is kept",
    )
}

/// `∫ f cos θ_o dω` of the inner cells of a square grid, by `∫ sin² φ dφ` of colatitudes and `∫ sin θ dθ` of longitudes.
fn albedo(values: &[f32]) -> f64 {
    let n = values.len().isqrt();
    let width = PI / n as f64;
    let middle = |k: usize| (k as f64 + 0.5) * width;
    let weight = |cell: usize| {
        let rows = 0.5 * width - 0.5 * (2.0 * middle(cell / n)).cos() * width.sin();
        rows * 2.0 * middle(cell % n).sin() * (0.5 * width).sin()
    };
    values.iter().enumerate().map(|(cell, value)| f64::from(*value) * weight(cell)).sum()
}

/// Squares along each axis are preserved, since the fit has their degree.
fn smooth(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    let shape = if small { [6, 5, 8] } else { [12, 10, 16] };
    let [_, rows, columns] = shape;
    let logarithm = |cell: usize| {
        let [a, b, c] = [cell / columns / rows, cell / columns % rows, cell % columns].map(|at| at as f64 / 16.0);
        a - 2.0 * b * b + (c * a).powi(2)
    };
    let exact: Vec<f64> = (0..shape.iter().product()).map(|cell| logarithm(cell).exp()).collect();
    let mut sorted = exact.clone();
    sorted.sort_by(f64::total_cmp);
    // The logarithms of values with this bias are the polynomial: the bias of smoothing is 0.05 times their median.
    let bias = 0.05 / 1.05 * sorted[sorted.len() / 2];
    for first in [Axis::Open, Axis::Separate] {
        let grid = Grid { shape, axes: [first, Axis::Open, Axis::Open] };
        for (scale, radius) in [1e-12, 1.0, 1e6].into_iter().zip([2, 5, 16]) {
            let samples: Vec<[f32; 3]> = exact.iter().map(|value| [(scale * (value - bias)) as f32; 3]).collect();
            let mut found = samples.clone();
            (stages.smooth)(&mut found, grid, Some(radius));
            for (found, exact) in found.iter().flatten().zip(samples.iter().flatten()) {
                worst.add(f64::from(found / exact) - 1.0);
            }
        }
    }
    worst.row(
        ["smoothing, f32", "logarithms that are polynomials of its degree, of values times 1e-12 to 1e6, up to the border"],
        Measure::Relative,
        64.0 * U,
        "sums of rounded values with weights whose magnitudes add up to a few at a border, and one rounding of the result",
    )
}
