//! What decoders make of packs, as hashes: every stored value, and look-ups at fixed places.
//!
//! The places are found without mathematical functions, and all hashes but the `reflectances` of wavelet packs are of sums,
//! products, quotients and square roots alone, and of factored flat BTFs of sines that are rounded to single precision: they
//! hold on every machine.

use super::Hashes;
use crate::flat_btf::towards;
use brdfc_formats::FormatError;
use brdfc_formats::Pack;
use brdfc_formats::bandwidth::{BandwidthKind, BandwidthMap};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf::{FlatBtfFile, Indirection, ViewWeights};
use brdfc_formats::importance::ImportancePack;
use brdfc_formats::pwt::{PwtDecoder, PwtErrors, PwtPack};
use brdfc_formats::table::{TableDecoder, TablePack};
use brdfc_formats::wavelet::{Filter, RowScratch, WaveletDecoder, WaveletPack};

/// Collects numbers as little-endian words.
#[derive(Default)]
struct Numbers(blake3::Hasher);

impl Numbers {
    fn add(&mut self, values: impl IntoIterator<Item = f32>) {
        self.words(values.into_iter().map(f32::to_bits));
    }

    fn words(&mut self, words: impl IntoIterator<Item = u32>) {
        for word in words {
            self.0.update(&word.to_le_bytes());
        }
    }

    fn hash(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

fn values(numbers: &Numbers) -> Hashes {
    Hashes::from([("values", numbers.hash())])
}

/// Unit vectors over the hemisphere and some below the horizon, by stereographic projection of a grid.
fn directions() -> impl Iterator<Item = [f64; 3]> + Clone {
    (-2..=2).flat_map(|row| {
        (-2..=2).map(move |column| {
            let [p, q] = [0.43 * f64::from(column) + 0.05, 0.41 * f64::from(row) - 0.03];
            let square = p * p + q * q;
            [2.0 * p, 2.0 * q, 1.0 - square].map(|c| c / (1.0 + square))
        })
    })
}

fn single(v: [f64; 3]) -> [f32; 3] {
    v.map(|c| c as f32)
}

/// Points of a plane that repeats, inside the tile and outside.
fn points() -> impl Iterator<Item = [f32; 2]> + Clone {
    (0..40).map(|k| [0.173 * k as f32 - 1.3, 0.311 * k as f32 - 4.2])
}

/// What the decoder of its kind makes of one file.
pub fn of_pack(bytes: &[u8]) -> Result<Hashes, FormatError> {
    Ok(match Pack::from_bytes(bytes)? {
        Pack::Wavelet(pack) => wavelet(&pack),
        Pack::Table(pack) => table(&pack),
        Pack::Bandwidth(map) => bandwidth(&map),
        Pack::Importance(pack) => importance(&pack),
        Pack::Pwt(pack) => pwt(pack),
        Pack::FlatBtf(file) => flat_btf(&file),
    })
}

/// A wavelet pack: `values` are log-encoded, all rows of the table and filtered ones; `reflectances` are what the
/// exponential makes of them; `errors` are those that the pack says of itself.
fn wavelet(pack: &WaveletPack) -> Hashes {
    let decoder = WaveletDecoder::new(pack);
    let (mut values, mut reflectances, mut errors) = (Numbers::default(), Numbers::default(), Numbers::default());
    let h = &pack.header;
    values.words([h.parameterisation.code(), h.levels, h.stored_levels, h.channels, h.bits, pack.slices() as u32]);
    values.add([h.mean, h.bias]);
    let (mut row, mut scratch) = (vec![0.0; h.cells()], RowScratch::default());
    for cell in 0..h.cells() {
        for channel in 0..h.channels as usize {
            decoder.decode_row(cell, channel, &mut row, &mut scratch);
            values.add(row.iter().copied());
        }
    }
    for pair in directions().flat_map(|i| directions().map(move |o| DirectionPair::new(i, o))) {
        for (level, filter) in [(9.0, Filter::Nearest), (1.25, Filter::Slices), (0.5, Filter::Bilinear)] {
            if pair.is_above_horizon() {
                values.add(decoder.log_value(pair, level, filter));
            }
            reflectances.add(decoder.eval(pair, level, filter));
        }
    }
    for e in [pack.on_grid, pack.off_grid] {
        errors.words([e.samples]);
        errors.add([e.rms, e.relative_mean, e.relative_p95, e.relative_p99, e.relative_max]);
        errors.add([e.log_rms, e.cosine_log_rms, e.albedo_max_difference, e.reciprocity]);
    }
    let columns = [("values", values), ("reflectances", reflectances), ("errors", errors)];
    columns.into_iter().map(|(name, numbers)| (name, numbers.hash())).collect()
}

/// A table pack: `values` are texels and filtered logarithms; `reflectances` are what the exponential makes of them;
/// `errors` are those that the pack says of itself.
fn table(pack: &TablePack) -> Hashes {
    let decoder = TableDecoder::new(pack);
    let (mut values, mut reflectances, mut errors) = (Numbers::default(), Numbers::default(), Numbers::default());
    let header = pack.header();
    let axes = header.axes;
    values.words([header.channels, header.symmetry.bits(), axes.half, axes.difference, axes.azimuth, axes.layers]);
    values.add([header.mean, header.bias, header.slope]);
    values.add(header.low.into_iter().chain(header.span).chain(header.knots));
    values.add(pack.values().into_iter().flatten());
    if let Some(curve) = pack.curve() {
        values.add(curve.values().into_iter().flatten());
    }
    for pair in directions().flat_map(|i| directions().map(move |o| DirectionPair::new(i, o))) {
        for level in 0..=decoder.levels() {
            if pair.is_above_horizon() {
                values.add(decoder.log_values(pair, level as f32).fine);
            }
            reflectances.add(decoder.eval_at(pair, level as f32));
        }
    }
    let e = pack.off_grid;
    errors.words([e.samples]);
    errors.add([e.rms, e.relative_mean, e.relative_p95, e.relative_p99, e.relative_max]);
    errors.add([e.log_rms, e.cosine_log_rms, e.albedo_max_difference, e.reciprocity]);
    errors.add([pack.picture.mean, pack.picture.p95, pack.picture.max]);
    let columns = [("values", values), ("reflectances", reflectances), ("errors", errors)];
    columns.into_iter().map(|(name, numbers)| (name, numbers.hash())).collect()
}

/// A bandwidth map of any kind: all its values, and what the look-up of its kind finds.
fn bandwidth(map: &BandwidthMap) -> Hashes {
    let mut numbers = Numbers::default();
    let header = map.header();
    numbers.words(header.transformed.into_iter().chain(map.size()));
    numbers.add([header.epsilon]);
    if let BandwidthKind::Texture { metres, tiles } = header.kind {
        numbers.add(metres);
        numbers.words([u32::from(tiles)]);
    }
    numbers.add(map.values());
    for incoming in directions().map(single) {
        numbers.add([map.environment(incoming)]);
        numbers.add(directions().map(single).map(|outgoing| map.brdf(incoming, outgoing)));
    }
    numbers.add(points().map(|uv| map.texture(uv)));
    values(&numbers)
}

/// An importance-sample pack: all half vectors with their densities, and samples of fixed directions.
fn importance(pack: &ImportancePack) -> Hashes {
    let mut numbers = Numbers::default();
    let header = pack.header();
    numbers.words([header.polar, header.azimuths, header.samples]);
    numbers.add(pack.texels().iter().flatten().copied());
    for outgoing in directions().map(single) {
        for index in 0..2 * header.samples.min(16) {
            let (incoming, inverse) = pack.sample(outgoing, index);
            numbers.add(incoming);
            numbers.add([inverse]);
        }
    }
    values(&numbers)
}

/// A polynomial wavelet tree: what it says of itself, all texels, weights of all terms, and look-ups at and between all
/// levels.
fn pwt(pack: PwtPack) -> Hashes {
    let mut numbers = Numbers::default();
    let header = pack.header().clone();
    let PwtErrors { lights, psnr, held_out_psnr, delta_e } = header.errors;
    numbers.words(header.size.into_iter().chain(header.extent));
    numbers.words([u32::from(header.repeats), header.levels, header.basis.degree, lights]);
    numbers.add([psnr, held_out_psnr, delta_e]);
    for texture in 0..header.textures.len() {
        numbers.words(pack.texels(texture).iter().map(|texel| u32::from(*texel)));
    }
    let decoder = PwtDecoder::new(pack);
    for light in directions().map(single) {
        let weights = header.weights(light);
        // Of those below the horizon, too: but for the pole, they are numbers.
        numbers.add(weights);
        for (k, uv) in points().enumerate().step_by(3) {
            let level = 0.3 * (k % 12) as f32;
            numbers.add(decoder.channels(uv, level, &weights));
            numbers.add(decoder.value(uv, level, light));
        }
    }
    values(&numbers)
}

/// A flat BTF: all values of its maps, its look-ups, the light form, and of a factored one the values of all texels in all views
/// under all lights, and look-ups at and between mipmap levels.
fn flat_btf(file: &FlatBtfFile) -> Hashes {
    let mut numbers = Numbers::default();
    let decoder = &file.decoder;
    let parts = decoder.parts();
    numbers.add(parts.normal.normals().iter().flatten().copied());
    numbers.add(parts.reference.parameters().iter().flatten().copied());
    numbers.add(parts.diffuse.texels().iter().flat_map(|texel| rgb9e5::decode(*texel)));
    match &parts.indirection {
        Indirection::Samples(map) => {
            let header = *map.header();
            numbers.words([header.size, header.zenith_samples, header.azimuth_samples]);
            numbers.add([header.largest_angle]);
            for k in 0..header.zenith_samples {
                for a in 0..=header.azimuth_samples {
                    let texels = (0..header.size * header.size).map(|t| [t % header.size, t / header.size]);
                    numbers.add(texels.flat_map(|texel| map.sample(texel, k, a)));
                }
            }
        }
        Indirection::Compact(map) => {
            let header = map.header();
            let blocks = header.blocks;
            numbers.words([blocks.size, blocks.zenith_samples, blocks.azimuth_samples]);
            numbers.add([blocks.largest_angle, header.largest_tangent]);
            numbers.words(map.range_bytes().iter().chain(map.texel_bytes()).map(|byte| u32::from(*byte)));
        }
    }
    if let Some(mask) = &file.mask {
        let size = mask.size();
        let texels = (0..mask.views() * size * size).map(|k| [k % size, k / size % size, k / size / size]);
        numbers.words([size, mask.views()]);
        numbers.words(texels.map(|[column, row, view]| u32::from(mask.is_seen(view, [column, row]))));
    }
    if let Some(directions) = &file.directions {
        numbers.words(directions.texels());
    }
    for view in directions().map(single) {
        for uv in points() {
            numbers.add(decoder.indirection(uv, view));
            numbers.add(decoder.light_form(uv, view, view));
        }
    }
    if let Some(asset) = parts.values.factored() {
        factored(asset, &mut numbers);
    }
    values(&numbers)
}

fn factored(asset: &FactoredFlatBtf, numbers: &mut Numbers) {
    let header = asset.header();
    let (views, lights) = (header.views.len() as u32, header.lights.len() as u32);
    numbers.words([header.size, header.levels, header.groups, header.wide_groups, header.shadow as u32]);
    numbers.add(header.views.iter().chain(&header.lights).flatten().copied());
    for at in 0..header.size * header.size {
        let texel = asset.texel([at % header.size, at / header.size]);
        for pair in 0..views * lights {
            numbers.add(texel.value(pair / lights, pair % lights));
        }
    }
    for (k, uv) in (0..).zip(points()) {
        let level = 0.3 * (k % 12) as f32 - 0.3;
        numbers.add(asset.value(uv, level, towards(weights(k, views)), towards(weights(k + 1, lights))));
    }
}

/// Three of `count` directions.
fn weights(k: u32, count: u32) -> ViewWeights {
    ViewWeights {
        indices: [k, k + 1, 2 * k + 1].map(|index| index % count),
        weights: if k.is_multiple_of(4) { [1.0, 0.0, 0.0] } else { [0.5, 0.375, 0.125] },
    }
}
