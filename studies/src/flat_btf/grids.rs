//! Figure 10: distance between blended and real indirections, for two grids of views with the same number of samples.

use brdfc_flat_btf::displacement::{coarser, displacements};
use brdfc_flat_btf::indirection::{self, indirection};
use brdfc_flat_btf::model::MesoModel;
use brdfc_formats::direction::from_polar;
use brdfc_formats::flat_btf::{
    DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatValues, Indirection, IndirectionHeader, IndirectionMap, NormalMap,
    ReferenceMap,
};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

/// Errors of one grid of views. Distances are in texels of a flat BTF of 256 x 256.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct GridRow {
    /// Polar angles.
    pub zenith_samples: u32,
    /// Azimuths.
    pub azimuth_samples: u32,
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

/// Rays per texel and axis of stored maps, the default of `brdfc flatten`.
pub(super) const MAP_OVERSAMPLING: usize = 2;

/// Errors of both grids, with four rays for each texel and view.
pub fn grid_errors(model: &MesoModel) -> Vec<GridRow> {
    GRIDS
        .into_iter()
        .map(|[zenith_samples, azimuth_samples]| {
            let header = IndirectionHeader {
                size: SIZE,
                zenith_samples,
                azimuth_samples,
                largest_angle: (10.0 * BANDS as f32).to_radians(),
            };
            let decoder = stored_map(model, header);
            let bands: Vec<Vec<f64>> = (0..BANDS).map(|band| band_errors(model, &decoder, band)).collect();
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let all: Vec<f64> = bands.iter().flatten().copied().collect();
            GridRow {
                zenith_samples,
                azimuth_samples,
                mean: mean(&all),
                median: median(all),
                bands: bands.iter().map(|band| mean(band)).collect(),
                band_medians: bands.into_iter().map(median).collect(),
            }
        })
        .collect()
}

/// The stored map of a model, in a decoder that supports only indirections.
pub(super) fn stored_map(model: &MesoModel, header: IndirectionHeader) -> FlatBtfDecoder {
    let found = indirection(model, header, MAP_OVERSAMPLING, &()).expect("it is never cancelled");
    of_samples(found)
}

/// The stored map of a model, and the displacements that are stored instead of it.
pub(super) fn stored_maps(model: &MesoModel, header: IndirectionHeader) -> [FlatBtfDecoder; 2] {
    let found = indirection(model, header, MAP_OVERSAMPLING, &()).expect("it is never cancelled");
    let reference = ReferenceMap::new(header.size, found.reference.clone()).expect("parameters are near the tile");
    let moved = |texel, k, a| found.displacement(texel, k, a);
    let (compact, reference) =
        displacements(header, &reference, moved, coarser(header.size)).expect("displacements are a few tiles");
    let compact = map_alone(reference, compact.into());
    [of_samples(found), compact]
}

fn of_samples(found: indirection::Indirection) -> FlatBtfDecoder {
    let header = found.header;
    let mut displacements = found.displacements.into_iter();
    let map = IndirectionMap::from_displacements(header, |_, _, _| displacements.next().expect("one for each view"));
    let reference = ReferenceMap::new(header.size, found.reference).expect("parameters are near the tile");
    map_alone(reference, map.expect("displacements are a few tiles").into())
}

fn map_alone(reference: ReferenceMap, indirection: Indirection) -> FlatBtfDecoder {
    let parts = FlatBtfParts {
        reference,
        indirection,
        normal: NormalMap::new(1, vec![[0.0, 0.0, 1.0]]).expect("a unit vector"),
        diffuse: DiffuseMap::new(1, vec![0]).expect("black"),
        values: FlatValues::None,
    };
    FlatBtfDecoder::new(parts).expect("parts of one size")
}

/// Distances for random views of one band, at the texels' centres.
fn band_errors(model: &MesoModel, decoder: &FlatBtfDecoder, band: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED + band as u64);
    let views: Vec<_> = (0..VIEWS)
        .map(|_| {
            let polar = 10.0 * (band as f64 + random.random::<f64>());
            from_polar(polar.to_radians(), TAU * random.random::<f64>())
        })
        .collect();
    let size = SIZE as usize;
    let error = |index: usize| {
        let (view, texel) = (views[index / (size * size)], index % (size * size));
        let at = [texel % size, texel / size].map(|c| (c as f64 + 0.5) / size as f64);
        let real = model.seen(at, view).parameters;
        let blended = decoder.indirection(at.map(|c| c as f32), view.map(|c| c as f32));
        let off = [0, 1].map(|k| {
            let d = real[k] - f64::from(blended[k]);
            d - d.round()
        });
        FLAT_TEXELS * off[0].hypot(off[1])
    };
    (0..VIEWS * size * size).into_par_iter().map(error).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
