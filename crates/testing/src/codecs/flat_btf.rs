//! Flat BTFs.
//!
//! Bounds with the sampler filtering: values are not sums of filtered values. The bound is twice the sum of the changes
//! of the value when the polar angle and azimuth of the view, the place and the level are each moved by the step. The
//! factor is two because both mipmap levels are rounded separately.

mod made_up;

pub use made_up::*;

use crate::codec::{Files, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions as hemisphere, of_columns, points, single};
use crate::packs::{Numbers, unit_vector};
use crate::sampler::{ROUNDING, SAMPLED, STEP, SamplerCase};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::flat_btf::factored::{FactoredFlatBtf, ShadowFormat};
use brdfc_formats::flat_btf::{
    BlendedDirection, DiffuseMap, FlatBtfDecoder, FlatBtfFile, FlatBtfParts, FlatValues, Indirection,
    SampledDirections, ViewWeights,
};
use brdfc_formats::{Pack, PackKind};
use std::f32::consts::TAU;

/// Flat BTFs with each kind of values that files can have.
fn some_flat_btfs() -> [(&'static str, FlatBtfDecoder); 2] {
    let whole = parts(SMALL, 4);
    let compact = displacements(SMALL, 1, 4).into();
    let factors = Factors { levels: 3, groups: 3, wide_groups: 1, shadow: ShadowFormat::R8 };
    let factored = FlatValues::Factored(Box::new(factored(SMALL, factors, 5)));
    [
        ("light form", FlatBtfParts { values: FlatValues::None, ..whole.clone() }),
        ("factored, displacements", FlatBtfParts { values: factored, indirection: compact, ..whole }),
    ]
    .map(|(name, parts)| (name, FlatBtfDecoder::new(parts).unwrap()))
}

/// Places, levels, views and lights.
fn flat_queries() -> Vec<Query> {
    let mut numbers = Numbers::new(14);
    let query = |k: usize| {
        let [u, v] = [0; 2].map(|_| numbers.between(-1.0, 2.0) as f32);
        let [view, light] = [0; 2].map(|_| unit_vector(&mut numbers)).map(|[x, y, z]| [x, y, z.abs(), 0.0]);
        [[u, v, (k % 9) as f32 / 4.0, 0.0], view, light]
    };
    (0..SIDE * SIDE).map(query).collect()
}

/// Equals `FlatMaterial::value` of the renderer.
fn flat_value(
    decoder: &FlatBtfDecoder,
    directions: Option<&SampledDirections>,
    uv: [f32; 2],
    level: f32,
    [view, light]: [[f32; 3]; 2],
) -> [f32; 3] {
    let Some(directions) = directions else {
        return decoder.light_form(uv, view, light);
    };
    let ([views, lights], dimmed) = blends(directions, [view, light]);
    decoder.value(uv, level, views, lights).map(|value| value * dimmed)
}

/// Weights of view and light among the sampled directions, and the remaining factor for a light below all of these.
fn blends(
    SampledDirections { views, lights, lowest_light }: &SampledDirections,
    [view, light]: [[f32; 3]; 2],
) -> ([BlendedDirection; 2], f32) {
    let blended = |mesh: &DirectionMesh, direction| {
        let (indices, weights) = mesh.weights(direction);
        BlendedDirection { direction, samples: ViewWeights { indices, weights } }
    };
    ([blended(views, view), blended(lights, light)], (light[2] / lowest_light).min(1.0))
}

/// A view whose position among the views of the indirection is moved by this number of views, polar angle first.
fn moved_view(decoder: &FlatBtfDecoder, [x, y, z]: [f32; 3], [polar, azimuth]: [f32; 2]) -> [f32; 3] {
    let header = decoder.parts().indirection.header();
    let steps = [header.largest_angle / (header.zenith_samples - 1) as f32, TAU / header.azimuth_samples as f32];
    let theta = (x.hypot(y).atan2(z).min(header.largest_angle) + polar * steps[0]).clamp(0.0, header.largest_angle);
    let phi = y.atan2(x) + azimuth * steps[1];
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// A value of a flat BTF with the indirection of another view, and with the filtered look-ups behind it moved, in
/// parameters and levels.
fn moved_value(
    decoder: &FlatBtfDecoder,
    directions: Option<&SampledDirections>,
    [a, b, c]: &Query,
    seen_from: [f32; 3],
    [u, v, level]: [f32; 3],
) -> [f32; 3] {
    let ([view, light], uv) = ([b, c].map(|v| [v[0], v[1], v[2]]), [a[0], a[1]]);
    let Some(directions) = directions else { return decoder.light_form(uv, seen_from, light) };
    let ([views, lights], dimmed) = blends(directions, [view, light]);
    let value = match decoder.parts().values.factored() {
        Some(asset) => {
            let found = decoder.indirection(uv, seen_from);
            asset.value([found[0] + u, found[1] + v], a[2] + level, views, lights)
        }
        None => decoder.full(uv, seen_from, views.samples, lights.samples),
    };
    value.map(|channel| channel * dimmed)
}

/// Error bound for a value of a flat BTF.
fn flat_bound(decoder: &FlatBtfDecoder, directions: Option<&SampledDirections>, query: &Query) -> [f64; 4] {
    let [a, b, _] = query;
    let view = [b[0], b[1], b[2]];
    let here = moved_value(decoder, directions, query, view, [0.0; 3]);
    let asset = decoder.parts().values.factored();
    let steps = asset.map_or([0.0; 2], |asset| {
        // Texels of the coarser of the two levels are larger.
        let (size, last) = (asset.header().size, asset.header().levels - 1);
        let coarser = (a[2].ceil() as u32).min(last);
        [STEP / (size >> coarser).max(1) as f32, STEP]
    });
    // The shader stays half a step more away from the borders of blocks.
    let turn = 1.5 * STEP;
    let axes = [
        [turn, 0.0, 0.0, 0.0, 0.0],
        [0.0, turn, 0.0, 0.0, 0.0],
        [0.0, 0.0, steps[0], 0.0, 0.0],
        [0.0, 0.0, 0.0, steps[0], 0.0],
        [0.0, 0.0, 0.0, 0.0, steps[1]],
    ];
    let mut most = [0.0f32; 3];
    for axis in &axes[..if asset.is_some() { 5 } else { 2 }] {
        let there = [-1.0, 1.0].map(|sign| {
            let [polar, azimuth, u, v, level] = axis.map(|step| sign * step);
            moved_value(decoder, directions, query, moved_view(decoder, view, [polar, azimuth]), [u, v, level])
        });
        for k in 0..3 {
            most[k] += 2.0 * there.map(|there| (there[k] - here[k]).abs()).into_iter().fold(0.0, f32::max);
        }
    }
    let of = |k: usize| f64::from(most[k]) + ROUNDING * (f64::from(here[k]) + 1e-2);
    [of(0), of(1), of(2), 1e-6]
}

/// The case of a flat BTF.
fn sampler_case(name: &str, decoder: &FlatBtfDecoder) -> SamplerCase {
    let directions = SampledDirections::of(&decoder.parts().values).unwrap();
    let bindings = decoder.bindings(true, directions.as_ref()).into_owned();
    let queries = flat_queries();
    let answer = |query: &Query| {
        let view = [query[1][0], query[1][1], query[1][2]];
        (four(moved_value(decoder, directions.as_ref(), query, view, [0.0; 3]), 0.0), 1e-2)
    };
    let expected = queries.iter().map(answer).collect();
    let allowed = queries.iter().map(|query| flat_bound(decoder, directions.as_ref(), query)).collect();
    let (name, files) = (name.to_owned(), Vec::new());
    let case = Case { name, decoder: PackKind::FlatBtf, bindings, frame: SAMPLED, files, queries, expected };
    SamplerCase { case, allowed, is_filtered: true }
}

/// The tested codec.
pub struct FlatBtf;

impl TestedCodec for FlatBtf {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        let parts = FlatBtfParts { values: FlatValues::None, ..parts(SMALL, 7) };
        FlatBtfFile::new(FlatBtfDecoder::new(parts).unwrap(), None).unwrap().to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let queries = flat_queries();
        let case = |(name, decoder): (&str, FlatBtfDecoder)| {
            let directions = SampledDirections::of(&decoder.parts().values).unwrap();
            let bindings = decoder.bindings(true, directions.as_ref()).into_owned();
            let answer = |[a, b, c]: &Query| {
                let [view, light] = [b, c].map(|v| [v[0], v[1], v[2]]);
                (four(flat_value(&decoder, directions.as_ref(), [a[0], a[1]], a[2], [view, light]), 0.0), 1e-2)
            };
            let expected = queries.iter().map(answer).collect();
            let (name, queries) = (name.to_owned(), queries.clone());
            let files = vec![FlatBtfFile::new(decoder, None).unwrap().to_bytes(true)];
            Case { name, decoder: PackKind::FlatBtf, bindings, frame: EXACT, files, queries, expected }
        };
        some_flat_btfs().into_iter().map(case).collect()
    }

    fn sampler_cases(&self) -> Vec<SamplerCase> {
        some_flat_btfs().iter().map(|(name, decoder)| sampler_case(name, decoder)).collect()
    }

    fn committed(&self) -> Files {
        let mut numbers = Numbers::new(5);
        let made = parts(SMALL, 7);
        // A writer uses the smallest sufficient exponent; a reader accepts any word.
        let texels = (0..SMALL.flat * SMALL.flat).map(|_| numbers.bits()).collect();
        let diffuse = DiffuseMap::new(SMALL.flat, texels).expect("any words");
        let light = FlatBtfParts { diffuse, values: FlatValues::None, ..made.clone() };
        let factors = Factors { levels: 3, groups: 3, wide_groups: 1, shadow: ShadowFormat::R8 };
        let values = FlatValues::Factored(Box::new(factored(SMALL, factors, 5)));
        // Two blocks along each side, for a reference of four texels.
        let Sizes { reference, .. } = SMALL;
        let fine = parts(Sizes { reference: 2 * reference, ..SMALL }, 13);
        let indirection = displacements(SMALL, reference, 17).into();
        let compact = FlatBtfParts { indirection, values, ..fine };
        // Its values follow simple rules, for which a decoder in another language was written.
        let example = FlatBtfParts { values: FlatValues::Factored(Box::new(factored_example())), ..made };
        let file = |parts: FlatBtfParts, mask| {
            FlatBtfFile::new(FlatBtfDecoder::new(parts).expect("parts of one asset"), mask).expect("what a file has")
        };
        let files = [
            ("any-texels", file(light, Some(mask(SMALL, 11)))),
            ("factored", file(compact, Some(mask(SMALL, 11)))),
            ("example", file(example, None)),
        ];
        let mut packs: Files = Vec::new();
        for (name, file) in files {
            let bytes = file.to_bytes(false);
            packs.extend(foreign_forms(name, &bytes));
            packs.push((name.to_owned(), bytes));
        }
        packs
    }

    /// Hashes all values of its maps, its look-ups and the light form, and of a factored one the values of all texels
    /// in all views under all lights, and look-ups at and between mipmap levels.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::FlatBtf(file) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
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
        for view in hemisphere().map(single) {
            for uv in points() {
                numbers.add(decoder.indirection(uv, view));
                numbers.add(decoder.light_form(uv, view, view));
            }
        }
        if let Some(asset) = parts.values.factored() {
            factored_values(asset, &mut numbers);
        }
        of_columns([("values", numbers)])
    }
}

fn factored_values(asset: &FactoredFlatBtf, numbers: &mut Values) {
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
        numbers.add(asset.value(uv, level, towards(three_of(k, views)), towards(three_of(k + 1, lights))));
    }
}

/// Three of `count` directions.
fn three_of(k: u32, count: u32) -> ViewWeights {
    ViewWeights {
        indices: [k, k + 1, 2 * k + 1].map(|index| index % count),
        weights: if k.is_multiple_of(4) { [1.0, 0.0, 0.0] } else { [0.5, 0.375, 0.125] },
    }
}
