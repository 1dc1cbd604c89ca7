//! Smoothing of dense tables by moving least squares (section 3 of Claustres et al. 2007: "a moving least square
//! approximation is applied to smooth the resulting data").
//!
//! At each cell a quadratic is fitted to the logarithms of the cells around it and evaluated there. With a basis and a
//! weight that are products over the axes the normal equations separate, so the fit is one pass of a small
//! one-dimensional fit per axis. Windows are truncated at the ends of an axis that is not periodic, where the fit becomes
//! one-sided, and skip cells without a value. The fit sums differences from the cell, so that constants keep their bits.
//!
//! The residual of a cell against the fit to the other cells is `(y - ŷ) / (1 - h)`, with `h` the share of the cell's own
//! value in the fit `ŷ`. Its mean square along a line and its neighbours is the sum of noise and error of the fit, so that
//! its minimum over a list of radii balances both: narrow fits in highlights, wide ones where reflectance changes slowly.
//! Lines whose residuals grow steeply even at the smallest radii keep their values: the grid does not resolve them.

use brdfc_core::words::percent;
use rayon::prelude::*;

/// Radii among which left-out values choose.
const RADII: [usize; 5] = [2, 3, 4, 6, 8];
/// Number of lines on each side whose residuals decide about a line, along each axis.
const AROUND: usize = 2;
/// Degree of the polynomial along each axis.
const DEGREE: usize = 2;
/// Least ratio of the mean squares of residuals at the second and the first radius on a line that keeps its values.
const STEEP: f64 = 4.0;
/// Limit of a residual in the mean square, in units of the median.
const CAP: f64 = 4.0;
/// Maximum share of a cell in its own fit.
const MAX_SHARE: f64 = 0.95;
/// Bias of the logarithm `ln(f + bias)`, in units of the median of positive values.
const LOG_BIAS: f64 = 0.05;
/// Standard deviation of normal noise over the median of its absolute values.
const NORMAL: f64 = 1.4826;

/// Continuation of an axis beyond its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Cells along the axis do not depend on each other.
    Separate,
    /// The axis ends.
    Open,
    /// The axis starts again.
    Periodic,
}

/// Result of smoothing a table.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Smoothed {
    /// Estimated noise of the values: standard deviation as a fraction of the value, from left-out values. Without noise
    /// it is the error of the fit.
    pub noise: f64,
    /// Smallest and largest number of cells on each side of a fit; 0 for cells that keep their values.
    pub radius: [usize; 2],
}

impl Smoothed {
    /// Lines of `brdfc info`.
    pub fn lines(&self) -> [(&'static str, String); 2] {
        let [least, most] = self.radius;
        let radius = if least == most { least.to_string() } else { format!("{least} to {most}") };
        // The residuals of a given radius may be detail.
        let noise = format!("{}{}", if least == most { "at most " } else { "" }, percent(self.noise));
        [("estimated noise of the values", noise), ("cells on each side of a fit", radius)]
    }
}

/// Smooths linear RGB values in the order of a shape, last axis fastest, with a radius, or by radii that left-out values
/// choose for each line of the last axis. NaN stays NaN.
pub fn smooth(values: &mut [[f32; 3]], grid: Grid, radius: Option<usize>) -> Smoothed {
    let bias = log_bias(values);
    // A comparison, because the maximum of NaN and 0 is 0.
    let logarithm = |v: f32| ((if v < 0.0 { 0.0 } else { f64::from(v) }) + bias).ln();
    let channel = |channel: usize| values.iter().map(|value| logarithm(value[channel])).collect();
    let logs: [Vec<f64>; 3] = std::array::from_fn(channel);
    let radii = match radius {
        Some(radius) => vec![radius; values.len() / grid.shape[2]],
        None => grid.chosen(&logs),
    };
    let mut used = radii.clone();
    used.sort_unstable();
    used.dedup();
    let mut changes: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; values.len()]);
    let mut noise = Vec::new();
    for (log, changes) in logs.iter().zip(&mut changes) {
        let mut left_out = Vec::new();
        for radius in used.iter().copied().filter(|radius| *radius > 0) {
            let Fitted { change, own } = grid.fitted(log, radius);
            let variance = grid.variance(radius);
            for line in (0..radii.len()).filter(|line| radii[*line] == radius) {
                for cell in line * grid.shape[2]..(line + 1) * grid.shape[2] {
                    if change[cell].is_nan() {
                        continue;
                    }
                    changes[cell] = change[cell];
                    let residual = -change[cell] / (1.0 - own[cell].min(MAX_SHARE));
                    left_out.push(residual);
                    // Values in the dark noise do not count.
                    let dark = bias * (-log[cell] - change[cell]).exp();
                    noise.extend((dark < 0.5).then(|| residual.abs() / ((1.0 - dark) * (1.0 + variance).sqrt())));
                }
            }
        }
        // Means of logarithms are below medians for symmetric noise, and equal to them for log-normal noise.
        let offset = median(left_out);
        let moved = |(change, log): (&mut f64, &f64)| *change += if log.is_nan() { 0.0 } else { offset };
        let lines = changes.chunks_mut(grid.shape[2]).zip(log.chunks(grid.shape[2])).zip(&radii);
        lines.filter(|(_, radius)| **radius > 0).for_each(|((a, b), _)| a.iter_mut().zip(b).for_each(moved));
    }
    for (cell, value) in values.iter_mut().enumerate() {
        for (channel, value) in value.iter_mut().enumerate().filter(|(_, value)| !value.is_nan()) {
            let old = f64::from(*value);
            *value = (old + (old.max(0.0) + bias) * changes[channel][cell].exp_m1()).max(old.min(0.0)) as f32;
        }
    }
    Smoothed { noise: NORMAL * median(noise), radius: [used.first(), used.last()].map(|radius| *radius.unwrap_or(&0)) }
}

/// Shape and axes of a table.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Cells along each axis, the last one fastest.
    pub shape: [usize; 3],
    /// Continuation of each axis.
    pub axes: [Axis; 3],
}

/// Fits at the cells of one channel.
struct Fitted {
    /// Fit minus value; NaN without a value.
    change: Vec<f64>,
    /// Share of the cell's own value.
    own: Vec<f64>,
}

impl Grid {
    /// Number of cells on each side of a fit along an axis.
    fn radius(&self, axis: usize, radius: usize) -> usize {
        match self.axes[axis] {
            Axis::Separate => 0,
            Axis::Open => radius.min(self.shape[axis] - 1),
            Axis::Periodic => radius.min((self.shape[axis] - 1) / 2),
        }
    }

    /// Fits at all cells.
    fn fitted(&self, log: &[f64], radius: usize) -> Fitted {
        let mut fitted = log.to_vec();
        let mut own = vec![1.0; log.len()];
        for axis in (0..3).rev() {
            let radius = self.radius(axis, radius);
            if radius > 0 {
                fitted = self.pass(&fitted, axis, radius, &mut own);
            }
        }
        fitted.par_iter_mut().zip(log).for_each(|(fitted, log)| *fitted -= log);
        Fitted { change: fitted, own }
    }

    /// Fits along one axis.
    fn pass(&self, log: &[f64], axis: usize, radius: usize, own: &mut [f64]) -> Vec<f64> {
        let [n, step] = [self.shape[axis], self.shape[axis + 1..].iter().product()];
        let inner = Kernel::new((0..=2 * radius).map(|tap| Some(tap as f64 - radius as f64)), radius);
        let mut fitted = vec![0.0; log.len()];
        let at = |cell: usize, (fitted, own): (&mut f64, &mut f64)| {
            let position = cell / step % n;
            let first = cell - position * step;
            let taps = (position + n - radius..=position + n + radius).map(|tap| match self.axes[axis] {
                Axis::Periodic => Some(first + tap % n * step),
                _ => (n..2 * n).contains(&tap).then(|| first + (tap - n) * step),
            });
            let differences = taps.map(|other| other.map_or(f64::NAN, |other| log[other] - log[cell]));
            let sum = inner.sum(differences.clone());
            let (sum, share) = if sum.is_nan() && !log[cell].is_nan() {
                let offset = |(tap, d): (usize, f64)| (!d.is_nan()).then_some(tap as f64 - radius as f64);
                let kernel = Kernel::new(differences.clone().enumerate().map(offset), radius);
                (kernel.sum(differences.map(|d| if d.is_nan() { 0.0 } else { d })), kernel.weights[radius])
            } else {
                (sum, inner.weights[radius])
            };
            *fitted = log[cell] + sum;
            *own *= share;
        };
        fitted.par_iter_mut().zip(own).enumerate().for_each(|(cell, outputs)| at(cell, outputs));
        fitted
    }

    /// Radius of each line of the last axis; 0 for lines that keep their values.
    fn chosen(&self, logs: &[Vec<f64>; 3]) -> Vec<usize> {
        let squares = RADII.map(|radius| self.squares(logs, radius));
        let [_, rows, _] = self.shape;
        let around = |line: usize| {
            let [a, b] = [line / rows, line % rows];
            let near = |axis: usize, at: usize| match self.axes[axis] {
                Axis::Separate => at..=at,
                _ => at.saturating_sub(AROUND)..=(at + AROUND).min(self.shape[axis] - 1),
            };
            near(0, a).flat_map(move |a| near(1, b).map(move |b| a * rows + b))
        };
        let radius = |line: usize| {
            let errors = squares.each_ref().map(|squares| around(line).map(|line| squares[line]).sum::<f64>());
            let best = (0..RADII.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap_or(0);
            if best == 0 && errors[1] > STEEP * errors[0] { 0 } else { RADII[best] }
        };
        (0..self.shape[0] * rows).map(radius).collect()
    }

    /// Sum of the squared left-out residuals of each line, up to a limit.
    fn squares(&self, logs: &[Vec<f64>; 3], radius: usize) -> Vec<f64> {
        let mut sums = vec![0.0; self.shape[0] * self.shape[1]];
        for log in logs {
            let Fitted { mut change, own } = self.fitted(log, radius);
            let left_out = |(change, own): (&mut f64, &f64)| *change = (*change / (1.0 - own.min(MAX_SHARE))).powi(2);
            change.iter_mut().zip(&own).for_each(left_out);
            let limit = CAP * CAP * median(change.iter().copied().filter(|square| !square.is_nan()).collect());
            for (sum, line) in sums.iter_mut().zip(change.chunks(self.shape[2])) {
                *sum += line.iter().filter(|square| !square.is_nan()).map(|square| square.min(limit)).sum::<f64>();
            }
        }
        sums
    }

    /// Variance of a left-out fit inside the table, for values of unit variance.
    fn variance(&self, radius: usize) -> f64 {
        let (mut squares, mut own) = (1.0, 1.0);
        for radius in (0..3).map(|axis| self.radius(axis, radius)).filter(|radius| *radius > 0) {
            let kernel = Kernel::new((0..=2 * radius).map(|tap| Some(tap as f64 - radius as f64)), radius);
            squares *= kernel.weights.iter().map(|weight| weight * weight).sum::<f64>();
            own *= kernel.weights[radius];
        }
        (squares - own * own) / (1.0 - own.min(MAX_SHARE)).powi(2)
    }
}

/// Weights of the cells of one window.
struct Kernel {
    weights: Vec<f64>,
}

impl Kernel {
    /// The value at offset 0 of the weighted least-squares polynomial through cells at these offsets; `None` for cells
    /// without a value. Windows of few cells give the cell itself.
    fn new(offsets: impl Iterator<Item = Option<f64>> + Clone, radius: usize) -> Self {
        let scaled = |offset: f64| offset / (radius as f64 + 1.0);
        let mut m = [0.0; 2 * DEGREE + 1];
        for t in offsets.clone().flatten().map(scaled) {
            m.iter_mut().enumerate().for_each(|(power, sum)| *sum += weight(t) * t.powi(power as i32));
        }
        // First row of the inverse of the normal matrix.
        let [a, b, c] = [m[2] * m[4] - m[3] * m[3], m[2] * m[3] - m[1] * m[4], m[1] * m[3] - m[2] * m[2]];
        let determinant = m[0] * a + m[1] * b + m[2] * c;
        let is_determined = offsets.clone().flatten().count() > DEGREE + 1;
        let weights = offsets.map(|offset| match offset.map(scaled) {
            Some(t) if is_determined => weight(t) * (a + t * (b + t * c)) / determinant,
            Some(t) => f64::from(u8::from(t == 0.0)),
            None => 0.0,
        });
        Self { weights: weights.collect() }
    }

    fn sum(&self, differences: impl Iterator<Item = f64>) -> f64 {
        self.weights.iter().zip(differences).map(|(weight, difference)| weight * difference).sum()
    }
}

/// Weight of a cell in the fit, by its offset in units of the radius plus 1: `(1 - t²)²`.
fn weight(t: f64) -> f64 {
    (1.0 - t * t).powi(2)
}

/// Bias of the logarithm: a fraction of the median of all positive values, below which they are dark noise; 1 if all are black.
pub(crate) fn log_bias<T: Copy + Into<f64>>(values: &[[T; 3]]) -> f64 {
    let positive: Vec<f64> = values.iter().flatten().map(|v| (*v).into()).filter(|v| *v > 0.0).collect();
    if positive.is_empty() { 1.0 } else { LOG_BIAS * median(positive) }
}

/// The median; 0 without values.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const GRID: Grid = Grid { shape: [12, 10, 16], axes: [Axis::Open, Axis::Open, Axis::Periodic] };

    fn table(grid: Grid, value: impl Fn([usize; 3]) -> f64) -> Vec<[f32; 3]> {
        let [_, b, c] = grid.shape;
        let cell = |cell: usize| [value([cell / (b * c), cell / c % b, cell % c]) as f32; 3];
        (0..grid.shape.iter().product()).map(cell).collect()
    }

    /// Deterministic normal noise of a cell.
    fn noise(cell: [usize; 3]) -> f64 {
        let uniform = |salt: u32| {
            let hash = cell.iter().fold(salt, |h, v| (h ^ *v as u32).wrapping_mul(0x9E37_79B1).rotate_left(13));
            (f64::from(hash ^ hash >> 15) + 0.5) / 2f64.powi(32)
        };
        (-2.0 * uniform(17).ln()).sqrt() * (2.0 * PI * uniform(91)).cos()
    }

    #[test]
    fn constants_keep_their_bits() {
        for value in [0.0, 0.1, 1.0 / 3.0, 7e-4, 123.456] {
            let plain = table(GRID, |_| value);
            for radius in [None, Some(2), Some(16)] {
                let mut smoothed = plain.clone();
                let found = smooth(&mut smoothed, GRID, radius);
                assert!(smoothed == plain && found.noise == 0.0, "{value} {radius:?}");
            }
        }
    }

    #[test]
    fn quadratics_are_preserved_up_to_the_border() {
        let grid = Grid { axes: [Axis::Open; 3], ..GRID };
        let value = |cell: usize| {
            let [a, b, c] = [cell / 160, cell / 16 % 10, cell % 16].map(|v| v as f64 / 10.0);
            1.0 + a - 2.0 * b * b + a * c + 0.5 * c * c * b
        };
        let mut log: Vec<f64> = (0..1920).map(value).collect();
        // Cells without a value stay without one, and others do not see them.
        for hole in [0, 333, 334, 335, 1000, 1919] {
            log[hole] = f64::NAN;
        }
        for radius in [2, 3, 8] {
            let Fitted { change, .. } = grid.fitted(&log, radius);
            for (change, log) in change.iter().zip(&log) {
                assert!(change.is_nan() == log.is_nan() && (change.is_nan() || change.abs() < 1e-9), "{change}");
            }
        }
        let cubic: Vec<f64> = (0..1920).map(|cell| (f64::from(cell % 16) / 3.0).powi(3)).collect();
        assert!(grid.fitted(&cubic, 3).change.iter().any(|change| change.abs() > 1e-3), "the control");
    }

    #[test]
    fn noise_falls_and_is_estimated() {
        let grid = Grid { shape: [24, 24, 36], ..GRID };
        let truth = |[a, b, c]: [usize; 3]| {
            (1.0 + 0.02 * a as f64) * (-0.03 * b as f64).exp() * (1.0 + 0.2 * (PI * c as f64 / 18.0).cos())
        };
        let error = |values: &[[f32; 3]]| {
            let exact = table(grid, truth);
            let square = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(a[1] / b[1] - 1.0).powi(2);
            (values.iter().zip(&exact).map(square).sum::<f64>() / values.len() as f64).sqrt()
        };
        for share in [0.02, 0.1, 0.3] {
            let rough = table(grid, |cell| truth(cell) * (share * noise(cell)).exp());
            let mut smoothed = rough.clone();
            let found = smooth(&mut smoothed, grid, None);
            let [before, after] = [error(&rough), error(&smoothed)];
            println!("noise {share}: {before:.4} before, {after:.4} after, {found:?}");
            assert!(after < 0.3 * before, "{before} {after}");
            assert!((found.noise / share - 1.0).abs() < 0.1 && found.radius[1] == 8, "{share} {found:?}");
            // A fixed small radius removes less.
            let mut little = rough.clone();
            smooth(&mut little, grid, Some(2));
            assert!(error(&little) > 1.3 * after, "{} {after}", error(&little));
        }
    }

    #[test]
    fn symmetries_of_a_table_stay() {
        let even = |[a, b, c]: [usize; 3]| {
            let c = c.min(16 - c);
            (1.0 + a as f64 * 0.1 + b as f64) * (0.2 * noise([a, b, c])).exp()
        };
        let mut values = table(GRID, even);
        smooth(&mut values, GRID, None);
        for ring in values.chunks(16) {
            for c in 1..8 {
                assert!((ring[c][0] / ring[16 - c][0] - 1.0).abs() < 2e-7, "{} {}", ring[c][0], ring[16 - c][0]);
            }
        }
        assert!(values.iter().all(|[r, g, b]| r == g && g == b), "a grey table stays grey");
    }

    #[test]
    fn highlights_that_the_grid_does_not_resolve_keep_their_values() {
        let peak = |[a, b, _]: [usize; 3]| if a < 2 { 200.0 } else { 1.0 + 0.01 * b as f64 };
        let mut values = table(GRID, peak);
        let found = smooth(&mut values, GRID, None);
        assert!(found.radius[0] == 0 && values[0][0] == 200.0, "{found:?} {}", values[0][0]);
        let mut flattened = table(GRID, peak);
        smooth(&mut flattened, GRID, Some(4));
        assert!((flattened[16 * 10][0] - 200.0).abs() > 1.0, "the control: {}", flattened[160][0]);
    }
}
