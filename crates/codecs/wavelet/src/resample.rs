//! Resampling of the source on the grid, with one evaluation per symmetry orbit.

use super::fold::Fold;
use super::table::{Grid, Table};
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, cell_centre, normalize};
use ndarray::Array3;
use rayon::prelude::*;

/// Lowest `z` of an evaluated direction. The half-difference grid has directions on and below the horizon, where models
/// diverge or are undefined; they are raised to this value. Cells of the finest tangent-pole grid are above it.
const LOWEST_Z: f64 = 5e-4;

/// Largest value of a sample, 1/sr: far above any reflectance, far below the maximum of f32.
const LARGEST: f64 = 1e30;

/// Evaluates `source` at every cell centre pair of `grid`, `f_r` in 1/sr.
///
/// Negative values and NaN are raised to 0 and counted. Pairs that the half-difference grid puts below the horizon have
/// the value just above it, so that the table continues smoothly.
pub fn resample(source: &dyn Source, grid: Grid) -> (Table, Tally) {
    let n = grid.n();
    let cells = grid.cells();
    let channels = if source.is_grey() { 1 } else { 3 };
    let fold = Fold::new(n, grid.parameterisation, source.symmetry());
    let centres: Vec<Vector> = (0..cells).map(|cell| cell_centre(cell % n, cell / n, n)).collect();

    let evaluated: Vec<(Vec<f32>, Tally)> = fold
        .rows()
        .par_iter()
        .enumerate()
        .map(|(row, outer)| {
            let mut tally = Tally::default();
            let mut values = vec![0.0f32; channels * cells];
            for inner in 0..cells {
                if fold.exchanged(row, inner).is_some_and(|partner| partner < (row, inner)) {
                    continue;
                }
                let pair = grid.parameterisation.from_axes(centres[*outer as usize], centres[inner]);
                let value = source.eval(raised(pair), &mut tally);
                let (mut raised, mut lowered) = (false, false);
                for channel in 0..channels {
                    // NaN fails this comparison too.
                    let usable = value[channel] >= 0.0;
                    raised |= !usable;
                    lowered |= value[channel] > LARGEST;
                    values[channel * cells + inner] = if usable { value[channel].min(LARGEST) as f32 } else { 0.0 };
                }
                tally.negative_raised += u64::from(raised);
                tally.largest_lowered += u64::from(lowered);
            }
            (values, tally)
        })
        .collect();

    let mut tally = Tally::default();
    let mut values = Array3::zeros((channels, fold.rows().len(), cells));
    let all = values.as_slice_mut().expect("a new array has standard layout");
    for (row, (row_values, row_tally)) in evaluated.iter().enumerate() {
        tally += *row_tally;
        for channel in 0..channels {
            all[(channel * fold.rows().len() + row) * cells..][..cells]
                .copy_from_slice(&row_values[channel * cells..][..cells]);
        }
    }
    fill_exchanged(&fold, channels, cells, all);
    (Table { grid, fold, values }, tally)
}

/// Copies each evaluated sample to its counterpart with exchanged light and viewer.
fn fill_exchanged(fold: &Fold, channels: usize, cells: usize, values: &mut [f32]) {
    let rows = fold.rows().len();
    for row in 0..rows {
        for inner in 0..cells {
            let Some((from_row, from_inner)) = fold.exchanged(row, inner) else { return };
            if (from_row, from_inner) < (row, inner) {
                for channel in 0..channels {
                    values[(channel * rows + row) * cells + inner] =
                        values[(channel * rows + from_row) * cells + from_inner];
                }
            }
        }
    }
}

fn raised(pair: DirectionPair) -> DirectionPair {
    let raise = |v: Vector| if v[2] >= LOWEST_Z { v } else { normalize([v[0], v[1], LOWEST_Z]) };
    DirectionPair::new(raise(pair.incoming), raise(pair.outgoing))
}
