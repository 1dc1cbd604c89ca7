//! Figure 10: distance between blended and real indirections, for two grids of views with the same number of samples.

use brdfc_flat_btf::encode::EncodeError;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::vdim::{OVERSAMPLING, indirection};
use brdfc_formats::direction::{Vector, from_polar};
use brdfc_formats::flat_btf::{Vdim, VdimHeader};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use std::convert::Infallible;
use std::f64::consts::TAU;

/// Errors of one grid of views. Distances are in texels of a flat BTF of 256 x 256.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct GridRow {
    /// Polar angles.
    pub polar_angles: u32,
    /// Rows of azimuths, of which the last repeats the first.
    pub azimuth_rows: u32,
    /// Mean distance between blended and real parameters, over views uniform in polar angle and azimuth.
    pub mean: f64,
    /// Median distance, in which silhouettes weigh less.
    pub median: f64,
    /// Mean distances by polar angle, in bands of ten degrees from 0 on.
    pub bands: Vec<f64>,
    /// Median distances by polar angle.
    pub band_medians: Vec<f64>,
}

/// The paper's grids.
const GRIDS: [[u32; 2]; 2] = [[8, 32], [16, 16]];
const BANDS: usize = 8;
/// Texels of the reference plane per side.
const SIZE: u32 = 48;
/// Views per band; each sees every texel once.
const VIEWS: usize = 24;
const FLAT_TEXELS: f64 = 256.0;
const SEED: u64 = 10;

/// Errors of both grids, with four rays for each texel and view.
///
/// # Errors
/// Returns an error if displacements or heights are out of the range of maps.
pub fn grid_errors(model: &MesoModel) -> Result<Vec<GridRow>, EncodeError<Infallible>> {
    GRIDS
        .into_iter()
        .map(|[polar_angles, azimuth_rows]| {
            let largest_angle = (10.0 * BANDS as f32).to_radians();
            let header =
                VdimHeader { size: SIZE, block: 1, polar_angles, azimuth_rows, largest_angle, levels: 1, lights: 0 };
            let map = indirection::<EncodeError<Infallible>>(model, header, OVERSAMPLING, false, &())?;
            let bands: Vec<Vec<f64>> = (0..BANDS).map(|band| band_errors(model, &map, band)).collect();
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let all: Vec<f64> = bands.iter().flatten().copied().collect();
            Ok(GridRow {
                polar_angles,
                azimuth_rows,
                mean: mean(&all),
                median: median(all),
                bands: bands.iter().map(|band| mean(band)).collect(),
                band_medians: bands.into_iter().map(median).collect(),
            })
        })
        .collect()
}

/// Distances for random views of one band, at the texels' centres.
fn band_errors(model: &MesoModel, map: &Vdim, band: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED + band as u64);
    let views: Vec<_> = (0..VIEWS)
        .map(|_| {
            let polar = 10.0 * (band as f64 + random.random::<f64>());
            from_polar(polar.to_radians(), TAU * random.random::<f64>())
        })
        .collect();
    let size = SIZE as usize;
    let errors = |view: Vector| {
        let error = |(texel, blended): (usize, [f32; 2])| {
            let at = [texel % size, texel / size].map(|c| (c as f64 + 0.5) / size as f64);
            let real = model.seen(at, view).parameters;
            let off = [0, 1].map(|k| {
                let d = real[k] - f64::from(blended[k]);
                d - d.round()
            });
            FLAT_TEXELS * off[0].hypot(off[1])
        };
        map.parameters(view.map(|c| c as f32)).into_par_iter().enumerate().map(error).collect::<Vec<_>>()
    };
    views.into_iter().flat_map(errors).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
