//! Smoothing by moving least squares on the dense grid, in the log domain (section 3 of Claustres et al. 2007: "a
//! moving least square approximation is applied to smooth the resulting data").
//!
//! At each sample a polynomial is fitted to the `(2r + 1)^4` samples around it and evaluated there. With a basis and a
//! weight that are products over the four axes the normal equations separate, so the fit is four passes of a small
//! one-dimensional fit. Windows are truncated at the border of the grid, where the fit becomes one-sided.

use super::table::Table;
use ndarray::Array3;
use rayon::prelude::*;

/// Number of samples on each side of a window.
pub const RADIUS: usize = 2;
/// Degree of the polynomial along each axis.
pub const DEGREE: usize = 2;

/// Smooths a log-encoded table along all four axes.
pub fn smooth(table: &Table) -> Table {
    let n = table.grid.n();
    let kernels: Vec<Kernel> = (0..n).map(|position| Kernel::at(position, n)).collect();
    let inner = map_rows(table, |channel, row, output| {
        let samples = table.row(channel, row);
        let mut across = vec![0.0f32; samples.len()];
        for cell in 0..samples.len() {
            across[cell] = kernels[cell % n].apply(|column| samples[cell - cell % n + column]);
        }
        for cell in 0..samples.len() {
            output[cell] = kernels[cell / n].apply(|line| across[line * n + cell % n]);
        }
    });
    let along = |table: &Table, step: usize| {
        map_rows(table, |channel, row, output| {
            let cell = table.fold.rows()[row] as usize;
            let position = if step == 1 { cell % n } else { cell / n };
            let kernel = &kernels[position];
            let first = cell - position * step;
            output.fill(0.0);
            for (tap, weight) in kernel.taps() {
                let (other, flip) = table.fold.locate(first + tap * step);
                let samples = table.row(channel, other);
                for (inner, value) in output.iter_mut().enumerate() {
                    *value += (weight * f64::from(samples[flip.cell(inner, n)])) as f32;
                }
            }
        })
    };
    along(&along(&inner, 1), n)
}

/// Weights of the samples in one window.
struct Kernel {
    first: usize,
    weights: Vec<f64>,
}

impl Kernel {
    /// The value at `position` of the weighted least-squares polynomial through the window around it.
    fn at(position: usize, n: usize) -> Self {
        let first = position.saturating_sub(RADIUS);
        let last = (position + RADIUS).min(n - 1);
        let degree = DEGREE.min(last - first);
        let offsets: Vec<f64> = (first..=last).map(|tap| tap as f64 - position as f64).collect();
        let basis = nalgebra::DMatrix::from_fn(offsets.len(), degree + 1, |row, power| {
            offsets[row].powi(power as i32) * weight(offsets[row]).sqrt()
        });
        let inverse = basis.pseudo_inverse(1e-12).expect("a positive tolerance");
        let weights = offsets.iter().enumerate().map(|(tap, t)| inverse[(0, tap)] * weight(*t).sqrt()).collect();
        Self { first, weights }
    }

    fn taps(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.weights.iter().enumerate().map(|(k, weight)| (self.first + k, *weight))
    }

    fn apply(&self, sample: impl Fn(usize) -> f32) -> f32 {
        self.taps().map(|(tap, weight)| weight * f64::from(sample(tap))).sum::<f64>() as f32
    }
}

/// Weight of a sample in the fit, by its offset in samples: `(1 - (t / (r + 1))²)²`, 0 outside the window.
fn weight(offset: f64) -> f64 {
    (1.0 - (offset / (RADIUS as f64 + 1.0)).powi(2)).powi(2)
}

fn map_rows(table: &Table, f: impl Fn(usize, usize, &mut [f32]) + Sync) -> Table {
    let (channels, rows, cells) = table.values.dim();
    let mut values = Array3::zeros((channels, rows, cells));
    let all = values.as_slice_mut().expect("a new array has standard layout");
    all.par_chunks_mut(cells).enumerate().for_each(|(index, output)| f(index / rows, index % rows, output));
    Table { grid: table.grid, fold: table.fold.clone(), values }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fold::Fold;
    use crate::table::Grid;
    use brdfc_core::Symmetry;
    use brdfc_formats::direction::Parameterisation;

    const GRID: Grid = Grid { parameterisation: Parameterisation::TangentPole, levels: 3 };

    fn table(symmetry: Symmetry, value: impl Fn([usize; 4]) -> f64) -> Table {
        let fold = Fold::new(8, GRID.parameterisation, symmetry);
        let values = Array3::from_shape_fn((1, fold.rows().len(), 64), |(_, row, inner)| {
            let outer = fold.rows()[row] as usize;
            value([outer % 8, outer / 8, inner % 8, inner / 8]) as f32
        });
        Table { grid: GRID, fold, values }
    }

    #[test]
    fn quadratics_are_preserved_up_to_the_border() {
        let quadratic = |c: [usize; 4]| {
            let [a, b, x, y] = c.map(|v| v as f64 / 8.0);
            1.0 + a - 2.0 * b * b + x * y + 0.5 * x * x * a
        };
        let plain = table(Symmetry::NONE, quadratic);
        for (a, b) in plain.values.iter().zip(smooth(&plain).values.iter()) {
            assert!((a - b).abs() < 2e-5, "{a} {b}");
        }
    }

    #[test]
    fn noise_shrinks_and_its_mean_stays() {
        let noise = |c: [usize; 4]| {
            let hash = c.iter().fold(17u32, |h, v| (h ^ *v as u32).wrapping_mul(0x9E37_79B1).rotate_left(13));
            f64::from(hash) / f64::from(u32::MAX) - 0.5
        };
        let rough = table(Symmetry::NONE, noise);
        let smoothed = smooth(&rough);
        let energy = |t: &Table| t.values.iter().map(|v| f64::from(v * v)).sum::<f64>();
        assert!(energy(&smoothed) < 0.25 * energy(&rough), "{} {}", energy(&smoothed), energy(&rough));
        assert!((smoothed.mean() - rough.mean()).abs() < 0.01);
    }

    #[test]
    fn folded_and_unfolded_tables_smooth_alike() {
        let even = |c: [usize; 4]| {
            let m = c.map(|v| (v as f64 - 3.5).abs());
            (m[0] * 1.3).sin() + m[1] * m[2] * 0.1 + (m[3] - m[0]).abs()
        };
        let mirror = Symmetry { isotropic: false, mirror: true, reciprocal: false };
        let (folded, whole) = (smooth(&table(mirror, even)), smooth(&table(Symmetry::NONE, even)));
        for outer in 0..64 {
            let (row, flip) = folded.fold.locate(outer);
            for inner in 0..64 {
                let (a, b) = (folded.row(0, row)[flip.cell(inner, 8)], whole.row(0, outer)[inner]);
                assert!((a - b).abs() < 1e-5);
            }
        }
    }
}
