//! Importance samples of a material's lobe. For each outgoing direction, the density of half vectors is tabulated, and
//! its cumulative distribution is inverted at the points of a low-discrepancy sequence. Each step has its own file;
//! this one sequences them.
//!
//! Section 3.3 of Bagher et al. 2012, "Interactive rendering of acquired materials on dynamic geometry using bandwidth
//! prediction".
//!
//! The pack stores half vectors, not incoming directions, because a lobe follows the mirror direction: the half vectors
//! of one outgoing direction also fit its neighbours.

mod distribution;
mod distributions;
mod facts;
mod grid;
mod half_vector;
mod lobe;
mod recipe;
mod sequence;

pub use distribution::Distribution;
pub use distributions::LobeDistributions;
pub use facts::ImportanceFacts;
pub use grid::HalfGrid;
pub use lobe::cell_probabilities;
pub use recipe::ImportanceRecipe;
pub use sequence::sequence_point;

use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use rayon::prelude::*;

/// Computes samples of `source` for all outgoing directions. The result does not depend on the number of threads.
///
/// # Errors
/// Returns an error if a number of the recipe is out of range.
pub fn importance_samples(
    source: &dyn Source,
    recipe: &ImportanceRecipe,
) -> Result<(ImportancePack, Tally), FormatError> {
    let symmetry = source.symmetry();
    let header = recipe.check(symmetry.isotropic)?;
    let points: Vec<[f64; 2]> = (0..recipe.samples).map(sequence_point).collect();
    let rows: Vec<u32> = (0..header.rows()).collect();
    // Mirror images require no evaluation.
    let mirrored = symmetry.mirror && !symmetry.isotropic;
    let made: Vec<(Vec<[f32; 4]>, Tally)> = rows
        .par_iter()
        .map(|row| {
            let mut tally = Tally::default();
            if mirrored && mirror_image(&header, *row).0 != *row {
                return (Vec::new(), tally);
            }
            let probabilities = cell_probabilities(source, &header, *row, recipe, &mut tally);
            let distribution = Distribution::new(recipe.grid, &probabilities);
            (points.iter().map(|point| distribution.sample(*point)).collect(), tally)
        })
        .collect();
    let mut texels = Vec::with_capacity(rows.len() * recipe.samples as usize);
    let mut tally = Tally::default();
    for row in rows {
        let (original, [x, y]) = if mirrored { mirror_image(&header, row) } else { (row, [1.0; 2]) };
        let (samples, counts) = &made[original as usize];
        texels.extend(samples.iter().map(|[hx, hy, hz, density]| [x * hx, y * hy, *hz, *density]));
        if original == row {
            tally += *counts;
        }
    }
    Ok((ImportancePack::new(header, texels)?, tally))
}

/// The row of the first quarter turn that a row mirrors, and the signs of x and y that map it there.
fn mirror_image(header: &ImportanceHeader, row: u32) -> (u32, [f32; 2]) {
    let (polar, azimuth, quarter) = (row / header.azimuths, row % header.azimuths, header.azimuths / 4);
    let (original, signs) = match azimuth / quarter {
        0 => (azimuth, [1.0, 1.0]),
        1 => (2 * quarter - 1 - azimuth, [-1.0, 1.0]),
        2 => (azimuth - 2 * quarter, [-1.0, -1.0]),
        _ => (header.azimuths - 1 - azimuth, [1.0, -1.0]),
    };
    (polar * header.azimuths + original, signs)
}
