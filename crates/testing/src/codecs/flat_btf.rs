//! Flat BTFs.
//!
//! Cases with exact weights: a ray jumps where it passes an edge, or where it takes another number of steps, and
//! engines round differently. Queries whose values jump nearby are replaced.
//!
//! Texels of indirection maps have borders, too, where values jump.
//!
//! Bounds with the sampler filtering: a ray through filtered heights may jump to another sheet, so its error has no
//! bound by differences. The layers of these cases have one height and one displacement, and so have the indirection maps,
//! so that positions are exact up to rounding. Values are not sums of filtered values. The bound is three times the sum
//! of the changes of the value when the place and the level are each moved by the step: both mipmap levels are rounded
//! separately, and values bend between the steps.

mod made_up;

pub use made_up::*;

use crate::codec::{Files, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions as hemisphere, of_columns, points, single};
use crate::packs::{Numbers, unit_vector};
use crate::sampler::{ROUNDING, SAMPLED, STEP, SamplerCase};
use brdfc_formats::Pack;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::factored::{BaseAngles, FactoredFlatBtf};
use brdfc_formats::flat_btf::{
    FlatBtfDecoder, FlatBtfFile, FlatBtfParts, LayerMap, Relief, SampledDirections, ShadowMap, Vdim, VdimSamples,
    ViewWeights,
};

/// Makes layers of these sizes, and indirection maps of these sizes for a number of lights: of halves, and compact.
type MakeRelief = (fn(Sizes) -> LayerMap, [fn(Sizes, u32) -> Vdim; 2]);

/// Flat BTFs with each kind of values, of relief and of shadows.
fn some_flat_btfs((layers, [map, compact]): MakeRelief) -> [(&'static str, FlatBtfDecoder); 7] {
    let one_sheet = Sizes { sheets: 1, ..SMALL };
    let with_residual = Factors { groups: 3, wide_groups: 1, residual: 2, ..BASE };
    let without_residual = Factors { groups: 1, residual: 0, ..with_residual };
    [
        ("base alone", layers(one_sheet).into(), factored(SMALL, BASE, 4)),
        ("two materials", layers(SMALL).into(), factored(SMALL, MATERIALS, 7)),
        ("components with a residual", layers(SMALL).into(), factored(SMALL, with_residual, 5)),
        ("components", layers(SMALL).into(), factored(SMALL, without_residual, 6)),
        (
            "indirection map with shadows",
            sampled_relief(SMALL, true, |lights| map(SMALL, lights)),
            factored(SMALL, MATERIALS, 7),
        ),
        (
            "indirection map with components",
            sampled_relief(SMALL, false, |lights| map(SMALL, lights)),
            factored(SMALL, without_residual, 6),
        ),
        (
            "compact indirection map with shadows",
            sampled_relief(SMALL, true, |lights| compact(SMALL, lights)),
            factored(SMALL, MATERIALS, 7),
        ),
    ]
    .map(|(name, relief, reflectance): (_, Relief, _)| {
        (name, FlatBtfDecoder::new(FlatBtfParts::new(relief, reflectance)))
    })
}

fn directions_of(decoder: &FlatBtfDecoder) -> Option<SampledDirections> {
    SampledDirections::of(decoder.parts()).unwrap()
}

/// A place, a level, a view and a light.
pub(super) fn any_query(numbers: &mut Numbers, at: usize) -> Query {
    let [u, v] = [0; 2].map(|_| numbers.between(-1.0, 2.0) as f32);
    let [view, light] = [0; 2].map(|_| unit_vector(numbers)).map(|[x, y, z]| [x, y, z.abs(), 0.0]);
    [[u, v, (at % 9) as f32 / 4.0, 0.0], view, light]
}

/// Distance at which a value may not jump: several times the rounding errors of positions and slopes.
const HAIR: f32 = 2e-6;

/// Random queries, each with the value of the CPU decoder, which does not jump nearby.
pub(super) fn steady_queries(decoder: &FlatBtfDecoder) -> Vec<(Query, [f32; 3])> {
    let directions = directions_of(decoder);
    let value = |query: &Query| query_value(decoder, directions.as_ref(), query);
    let (mut numbers, mut steady) = (Numbers::new(14), Vec::new());
    while steady.len() < SIDE * SIDE {
        let query = any_query(&mut numbers, steady.len());
        let here = value(&query);
        let jumps = (0..12).any(|_| {
            let signs = numbers.bits();
            let mut moved = query;
            for (k, (vector, axis)) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)].into_iter().enumerate() {
                moved[vector][axis] += if (signs >> (8 + k)) & 1 == 0 { HAIR } else { -HAIR };
            }
            let there = value(&moved);
            (0..3).any(|k| (there[k] - here[k]).abs() > 3e-4 * (here[k] + 1e-2))
        });
        if !jumps {
            steady.push((query, here));
        }
    }
    steady
}

pub(super) fn query_value(
    decoder: &FlatBtfDecoder,
    directions: Option<&SampledDirections>,
    [a, b, c]: &Query,
) -> [f32; 3] {
    let [view, light] = [b, c].map(|v| [v[0], v[1], v[2]]);
    decoder.shaded(directions, [a[0], a[1]], a[2], view, light)
}

/// Error bound for a value of a flat BTF with layers of one height.
fn flat_bound(decoder: &FlatBtfDecoder, directions: Option<&SampledDirections>, query: &Query) -> [f64; 4] {
    let header = decoder.parts().reflectance.factors().unwrap().header();
    // Texels of the coarser of the two levels are larger, and cells of the residual are larger than texels.
    let coarser = (query[0][2].ceil() as u32).min(header.levels - 1);
    let finest = if header.residual > 0 { header.residual } else { header.size };
    let finer = (header.size / finest).ilog2();
    let step = STEP / (finest >> coarser.saturating_sub(finer)).max(1) as f32;
    let here = query_value(decoder, directions, query);
    let mut most = [0.0f32; 3];
    for (axis, step) in [step, step, STEP].into_iter().enumerate() {
        let there = [-step, step].map(|step| {
            let mut moved = *query;
            moved[0][axis] += step;
            query_value(decoder, directions, &moved)
        });
        for k in 0..3 {
            most[k] += 3.0 * there.map(|there| (there[k] - here[k]).abs()).into_iter().fold(0.0, f32::max);
        }
    }
    let of_tables = table_bound(decoder, query);
    let of = |k: usize| f64::from(most[k] + of_tables[k]) + ROUNDING * (f64::from(here[k]) + 1e-2);
    [of(0), of(1), of(2), 1e-6]
}

/// Error bound from filtering the tables of materials: positions are off by a step along each of three axes, and kept half
/// a step inside.
fn table_bound(decoder: &FlatBtfDecoder, [a, b, c]: &Query) -> [f32; 3] {
    let [view, light] = [b, c].map(|v| [v[0], v[1], v[2]]);
    let reflectance = decoder.parts().reflectance.factors().unwrap();
    let (_, parameters) = decoder.seen([a[0], a[1]], view, a[2]);
    let texel = reflectance.filtered(parameters, a[2]);
    let base = texel.base();
    let mut most = [0.0f32; 3];
    for material in reflectance.basis().materials() {
        let Some(angles) = BaseAngles::new(material.axis(), base.normal, view, light) else { continue };
        let levels = material.tables.iter().skip(base.tables.level).take(2);
        for (c, most) in most.iter_mut().enumerate() {
            let numbers = levels.clone().flat_map(|table| {
                let diffuse = material.diffuse[c] * angles.cosine;
                angles.taps.map(|(at, _)| angles.geometry * table.gloss.entries()[at][c] + diffuse * table.diffuse[at])
            });
            let range = numbers.clone().fold(0.0, f32::max) - numbers.fold(f32::MAX, f32::min);
            *most += 3.0 * 1.5 * STEP * base.diffuse[c] * range;
        }
    }
    most
}

pub(super) fn case(
    name: &str,
    decoder: &FlatBtfDecoder,
    frame: FrameBlock,
    files: Vec<Vec<u8>>,
    answers: Vec<(Query, [f32; 3])>,
) -> Case {
    let bindings = decoder.bindings(directions_of(decoder).as_ref()).into_owned();
    let (queries, values): (Vec<Query>, Vec<[f32; 3]>) = answers.into_iter().unzip();
    let expected = values.into_iter().map(|value| (four(value, 0.0), 1e-2)).collect();
    let kind = decoder.parts().reflectance.kind();
    Case { name: name.to_owned(), decoder: kind, bindings, frame, files, queries, expected }
}

/// The case of a flat BTF with layers of one height, or an indirection map of one displacement.
fn sampler_case(name: &str, decoder: &FlatBtfDecoder) -> SamplerCase {
    let (directions, mut numbers) = (directions_of(decoder), Numbers::new(14));
    let queries = (0..SIDE * SIDE).map(|at| any_query(&mut numbers, at));
    let answers = queries.map(|query| (query, query_value(decoder, directions.as_ref(), &query))).collect();
    let case = case(name, decoder, SAMPLED, Vec::new(), answers);
    let allowed = case.queries.iter().map(|query| flat_bound(decoder, directions.as_ref(), query)).collect();
    SamplerCase { case, allowed, is_filtered: true }
}

/// The tested codec.
pub struct FlatBtf;

impl TestedCodec for FlatBtf {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        let layers = layers(Sizes { plane: 4, sheets: 1, ..SMALL }, 7);
        file(layers, factored(SMALL, BASE, 8)).to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let case = |(name, decoder): (&str, FlatBtfDecoder)| {
            let file = FlatBtfFile::new(decoder.clone()).unwrap().to_bytes(true);
            case(name, &decoder, EXACT, vec![file], steady_queries(&decoder))
        };
        let maps: [fn(Sizes, u32) -> Vdim; 2] =
            [|sizes, lights| indirections(sizes, lights, 8), |sizes, lights| compact_indirections(sizes, lights, 8)];
        some_flat_btfs((|sizes| layers(sizes, 4), maps)).into_iter().map(case).collect()
    }

    fn sampler_cases(&self) -> Vec<SamplerCase> {
        some_flat_btfs((flat_relief, [flat_indirections, flat_compact_indirections]))
            .iter()
            .map(|(name, decoder)| sampler_case(name, decoder))
            .collect()
    }

    fn committed(&self) -> Files {
        let factors = Factors { groups: 3, wide_groups: 1, residual: 2, ..BASE };
        let files = [
            ("base", base_file()),
            ("materials", materials_file()),
            ("factored", file(layers(SMALL, 13), factored(SMALL, factors, 5))),
            ("vdim", vdim_file()),
            ("vdim-compact", compact_vdim_file()),
            // Its numbers follow simple rules, for which a decoder in another language was written.
            ("example", file(example_layers(), factored_example())),
        ];
        let mut packs: Files = Vec::new();
        for (name, file) in files {
            let bytes = file.to_bytes(false);
            packs.extend(foreign_forms(name, &bytes));
            packs.push((name.to_owned(), bytes));
        }
        packs
    }

    /// Hashes layers, meshes of directions, ends of rays of sight with their parameters, values behind them, and of the
    /// finest level the base of all texels in all views under all lights.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::FlatBtf(file) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
        let decoder = &file.decoder;
        let FlatBtfParts { relief, reflectance } = decoder.parts();
        let reflectance = reflectance.factors().expect("a file of this kind");
        relief_values(relief, &mut numbers);
        if let Some(directions) = &file.directions {
            numbers.words(directions.texels());
        }
        for view in hemisphere().map(single) {
            for (k, uv) in (0..).zip(points()) {
                let level = level_of(k);
                let (point, parameters) = decoder.seen(uv, view, level);
                numbers.add([point.at[0], point.at[1], point.height]);
                numbers.words([point.sheet as u32]);
                numbers.add(parameters);
            }
        }
        factored_values(reflectance, &mut numbers);
        let [views, lights] = [&reflectance.header().views, &reflectance.header().lights].map(|all| all.len() as u32);
        for (k, uv) in (0..).zip(points()) {
            let (view, light) = (towards(three_of(k, views)), towards(three_of(k + 1, lights)));
            numbers.add(decoder.value(uv, level_of(k), view, light));
        }
        of_columns([("values", numbers)])
    }
}

pub(super) fn relief_values(relief: &Relief, numbers: &mut Values) {
    let bytes = match relief {
        Relief::Layers(layers) => {
            let header = layers.header();
            numbers.words([header.size, header.sheets, header.levels]);
            numbers.add(header.heights);
            [layers.height_bytes(), &layers.displacement_bytes()].concat()
        }
        Relief::Vdim(map, shadows) => {
            let shadows = shadows.as_ref().map_or(&[][..], ShadowMap::texels);
            let compact = match map.samples() {
                VdimSamples::Compact(samples) => [&samples.heights[..], &samples.range_bytes()].concat(),
                VdimSamples::Halves(_) => Vec::new(),
            };
            [&map.reference_bytes(), &map.packed_bytes()[..], &compact, shadows].concat()
        }
    };
    numbers.words(bytes.into_iter().map(u32::from));
}

/// A level of detail for a point, at and between mipmap levels, some beyond them.
pub(super) fn level_of(point: u32) -> f32 {
    0.3 * (point % 12) as f32 - 0.3
}

fn factored_values(asset: &FactoredFlatBtf, numbers: &mut Values) {
    let header = asset.header();
    let (views, lights) = (header.views.len() as u32, header.lights.len() as u32);
    numbers.words([header.size, header.levels, header.groups, header.wide_groups, header.residual]);
    numbers.words([header.materials, header.axes]);
    numbers.add(header.views.iter().chain(&header.lights).flatten().copied());
    for at in 0..header.size * header.size {
        let texel = asset.texel([at % header.size, at / header.size]);
        numbers.add(texel.base().diffuse.into_iter().chain([texel.base().gloss]).chain(texel.base().normal));
        for pair in 0..views * lights {
            numbers.add(texel.value(pair / lights, pair % lights));
        }
    }
    for (k, uv) in (0..).zip(points()) {
        let (view, light) = (towards(three_of(k, views)), towards(three_of(k + 1, lights)));
        let texel = asset.filtered(uv, level_of(k));
        let value = texel.blended(view, light);
        numbers.add(value.into_iter().chain(texel.shadowed(value, light.samples, 0.25)));
    }
}

/// Three of `count` directions; without any, no weights.
fn three_of(k: u32, count: u32) -> ViewWeights {
    if count == 0 {
        return nothing(k);
    }
    ViewWeights {
        indices: [k, k + 1, 2 * k + 1].map(|index| index % count),
        weights: if k.is_multiple_of(4) { [1.0, 0.0, 0.0] } else { [0.5, 0.375, 0.125] },
    }
}
