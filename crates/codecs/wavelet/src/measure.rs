//! Codec error: a decoded pack against its table, at every sample of the grid.

use super::table::Table;
use brdfc_formats::crop::{DirectionRange, Elevations};
use brdfc_formats::direction::{Parameterisation, cell_centre};
use brdfc_formats::vector_math::exp;
use brdfc_formats::wavelet::{RowScratch, WaveletDecoder};
use brdfc_metrics::compare::Reciprocity;
use brdfc_metrics::norms::{NormSums, Norms};
use rayon::prelude::*;

/// Outer cells per unit of parallel work: fixed, so that sums do not depend on threads.
const CHUNK: usize = 64;
/// Side of the square tiles in which exchanged samples are paired; divides [`CHUNK`].
const TILE: usize = 32;

/// Codec error on the grid.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct GridError {
    /// Norms over all samples above the horizon.
    pub norms: Norms,
    /// Largest difference of directional albedo over incoming cells, from sums over the grid. Tangent-pole grids only;
    /// 0 otherwise.
    pub albedo_max_difference: f64,
    /// Mean of `|f'(i, o) - f'(o, i)| / f` over all pairs of cells. Tangent-pole grids only; 0 otherwise.
    pub reciprocity: f64,
}

/// Decodes the whole table and compares it with `reference` (values of `f`, not logarithms), at the samples of a range
/// of directions. Reciprocity is measured over the whole pack.
pub fn grid_error(reference: &Table, decoder: &WaveletDecoder, directions: DirectionRange) -> GridError {
    let grid = reference.grid;
    let (n, cells, channels) = (grid.n(), grid.cells(), reference.channels());
    let mean = f64::from(decoder.header().mean);
    let centre = |cell: usize| cell_centre(cell % n, cell / n, n);
    let tangent_pole = grid.parameterisation == Parameterisation::TangentPole;
    let seen: Vec<bool> = (0..cells).map(|cell| directions.view.contain(centre(cell))).collect();
    // Solid angle of a cell times the outgoing cosine.
    let albedo_weight: Vec<f64> = (0..cells)
        .map(|cell| {
            if !seen[cell] {
                return 0.0;
            }
            let [x, _, z] = centre(cell);
            (std::f64::consts::PI / n as f64).powi(2) * x.hypot(z) * z
        })
        .collect();

    let parts: Vec<(NormSums, f64, Vec<f32>)> = (0..cells.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut sums = NormSums::new(mean);
            let mut albedo_max: f64 = 0.0;
            let mut decoded = vec![0.0f32; cells];
            let mut unfolded = vec![0.0f32; cells];
            let mut all_decoded = Vec::new();
            let mut scratch = RowScratch::default();
            for outer in chunk * CHUNK..((chunk + 1) * CHUNK).min(cells) {
                if tangent_pole && !directions.light.contain(centre(outer)) {
                    continue;
                }
                let (row, flip) = reference.fold.locate(outer);
                for channel in 0..channels {
                    decoder.decode_row(outer, channel, &mut decoded, &mut scratch);
                    let (mean, bias) = (decoder.header().mean, decoder.header().bias);
                    decoded.iter_mut().for_each(|v| *v = (mean * (exp(*v) - bias)).max(0.0));
                    let samples = reference.row(channel, row);
                    flip.unfold(samples, n, &mut unfolded);
                    if tangent_pole {
                        if directions.view == Elevations::ALL {
                            sums.add_row(&unfolded, &decoded, centre(outer)[2] as f32);
                        } else {
                            let only = |all: &[f32]| -> Vec<f32> {
                                all.iter().zip(&seen).filter(|(_, seen)| **seen).map(|(value, _)| *value).collect()
                            };
                            sums.add_row(&only(&unfolded), &only(&decoded), centre(outer)[2] as f32);
                        }
                        let albedo: f64 = (0..cells)
                            .map(|inner| f64::from(decoded[inner] - unfolded[inner]) * albedo_weight[inner])
                            .sum();
                        albedo_max = albedo_max.max(albedo.abs());
                        if directions.is_all() {
                            all_decoded.extend_from_slice(&decoded);
                        }
                        continue;
                    }
                    for inner in 0..cells {
                        let pair = grid.parameterisation.from_axes(centre(outer), centre(inner));
                        if pair.is_above_horizon() {
                            sums.add(f64::from(unfolded[inner]), f64::from(decoded[inner]), pair.incoming[2]);
                        }
                    }
                }
            }
            (sums, albedo_max, all_decoded)
        })
        .collect();

    let mut sums = NormSums::new(mean);
    let mut albedo_max: f64 = 0.0;
    for (part, albedo, _) in &parts {
        sums.merge(part);
        albedo_max = albedo_max.max(*albedo);
    }
    let mut error = GridError { norms: sums.norms(), ..GridError::default() };
    if tangent_pole {
        error.albedo_max_difference = albedo_max;
        if directions.is_all() {
            error.reciprocity = reciprocity(reference, &parts, mean);
        }
    }
    error
}

fn reciprocity(reference: &Table, parts: &[(NormSums, f64, Vec<f32>)], mean: f64) -> f64 {
    let (cells, channels, n) = (reference.grid.cells(), reference.channels(), reference.grid.n());
    let decoded = |outer: usize, channel: usize| {
        &parts[outer / CHUNK].2[((outer % CHUNK) * channels + channel) * cells..][..cells]
    };
    // Square tiles: the exchanged samples are in columns, which stay in the cache only for small tiles.
    let tiles: Vec<(usize, usize)> =
        (0..cells.div_ceil(TILE)).flat_map(|a| (0..=a).map(move |b| (a * TILE, b * TILE))).collect();
    let sums: Vec<Reciprocity> = tiles
        .par_iter()
        .map(|(first_outer, first_inner)| {
            let mut sum = Reciprocity::default();
            for outer in *first_outer..(first_outer + TILE).min(cells) {
                let (row, flip) = reference.fold.locate(outer);
                for channel in 0..channels {
                    let (samples, straight) = (reference.row(channel, row), decoded(outer, channel));
                    for inner in *first_inner..(first_inner + TILE).min(outer) {
                        let f = f64::from(samples[flip.cell(inner, n)]);
                        let (g, exchanged) = (straight[inner], decoded(inner, channel)[outer]);
                        sum.add(f, f64::from(g), f64::from(exchanged), mean);
                    }
                }
            }
            sum
        })
        .collect();
    let mut total = Reciprocity::default();
    sums.iter().for_each(|sum| total.merge(sum));
    total.mean()
}
