//! Flat BTFs.
//!
//! Where the sampler filters: they are no sum of what is filtered. The bound is twice what the value changes by when polar angle
//! and azimuth of the view, place and level are moved by the step, summed. Twice, as two mipmap levels are rounded each by itself.

use crate::codec::{Files, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions as hemisphere, of_columns, points, single};
use crate::packs::{Numbers, sealed, unit_vector};
use crate::sampler::{ROUNDING, SAMPLED, STEP, SamplerCase};
use brdfc_formats::bindings::{PackFile, Resource, Texels};
use brdfc_formats::container::{Extent, TexelFormat, half, rgb9e5};
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::flat_btf::factored::{
    BASE_LAYERS, BaseTable, BasisMap, DIFFERENCE_ANGLES, FactoredErrors, FactoredFlatBtf, FactoredHeader, GROUP,
    HALF_ANGLES, ShadowFormat, ShadowMap, WeightMap, WeightRange,
};
use brdfc_formats::flat_btf::{
    BlendedDirection, DiffuseMap, DisplacementHeader, DisplacementMap, FlatBtfDecoder, FlatBtfFile, FlatBtfParts,
    FlatHeader, FlatValues, FlatView, Indirection, IndirectionHeader, IndirectionMap, MAX_COORDINATE, NormalMap,
    ReferenceMap, SampledDirections, ViewWeights, VisibilityMask,
};
use brdfc_formats::{FormatError, Pack, PackKind};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Sizes of a made-up asset.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    pub flat: u32,
    pub reference: u32,
    pub zenith: u32,
    pub azimuth: u32,
    pub largest_angle: f32,
    pub views: u32,
    pub lights: u32,
}

pub const SMALL: Sizes =
    Sizes { flat: 4, reference: 2, zenith: 3, azimuth: 4, largest_angle: 1.3, views: 3, lights: 5 };

pub fn header(sizes: Sizes) -> IndirectionHeader {
    IndirectionHeader {
        size: sizes.reference,
        zenith_samples: sizes.zenith,
        azimuth_samples: sizes.azimuth,
        largest_angle: sizes.largest_angle,
    }
}

pub fn directions(count: u32, seed: u64) -> Vec<[f32; 2]> {
    let mut numbers = Numbers::new(seed);
    (0..count).map(|_| [FRAC_PI_2 * numbers.unit() as f32, 6.2 * numbers.unit() as f32]).collect()
}

pub fn flat_view(sizes: Sizes, view: u32, seed: u64) -> FlatView {
    let mut numbers = Numbers::new(seed + 977 * u64::from(view));
    let header =
        FlatHeader { size: sizes.flat, view, views: directions(sizes.views, 1), lights: directions(sizes.lights, 2) };
    let count = sizes.flat * sizes.flat * sizes.lights;
    let colour = |numbers: &mut Numbers| [0; 3].map(|_| numbers.between(0.0, 1.5) as f32);
    FlatView::new(header, (0..count).map(|_| rgb9e5::encode(colour(&mut numbers))).collect()).unwrap()
}

/// Random displacements: some of length 0, most roughly along the azimuth of the view.
pub fn indirection(sizes: Sizes, seed: u64) -> IndirectionMap {
    let mut numbers = Numbers::new(seed);
    IndirectionMap::from_displacements(header(sizes), |_, k, a| {
        let turn = TAU * a as f32 / sizes.azimuth as f32 + numbers.between(-0.7, 0.7) as f32;
        let length =
            if numbers.bits().is_multiple_of(9) { 0.0 } else { 0.1 * k as f32 * numbers.between(0.5, 1.5) as f32 };
        ([length * turn.cos(), length * turn.sin()], numbers.between(-0.3, 0.3) as f32)
    })
    .unwrap()
}

/// Displacements of random bytes between random bounds, of so many blocks per side.
pub fn displacements(sizes: Sizes, blocks: u32, seed: u64) -> DisplacementMap {
    let mut numbers = Numbers::new(seed);
    let header = DisplacementHeader::new(IndirectionHeader { size: blocks, ..header(sizes) });
    let [width, _] = header.blocks.extent();
    let mut texels: Vec<[u8; 2]> = Vec::new();
    for _ in 0..blocks {
        let first = texels.len();
        texels.extend((0..width * sizes.azimuth).map(|_| [0; 2].map(|_| numbers.bits() as u8)));
        texels.extend_from_within(first..first + width as usize);
    }
    let bounds = |_| [-0.1, 0.2, -0.1, 0.2].map(|scale| half::encode((scale * numbers.between(0.2, 1.0)) as f32));
    DisplacementMap::new(header, (0..blocks * blocks).map(bounds).collect(), texels).unwrap()
}

pub fn parts(sizes: Sizes, seed: u64) -> FlatBtfParts {
    let mut numbers = Numbers::new(seed);
    let texels = sizes.flat * sizes.flat;
    let reference: Vec<[f32; 2]> =
        (0..sizes.reference * sizes.reference).map(|_| [0; 2].map(|_| numbers.between(-0.5, 1.5) as f32)).collect();
    let normals = (0..texels).map(|_| unit_vector(&mut numbers)).collect();
    let colours: Vec<[f32; 3]> = (0..texels).map(|_| [0; 3].map(|_| numbers.unit() as f32)).collect();
    FlatBtfParts {
        reference: ReferenceMap::new(sizes.reference, reference).unwrap(),
        indirection: indirection(sizes, seed + 1).into(),
        normal: NormalMap::new(sizes.flat, normals).unwrap(),
        diffuse: DiffuseMap::from_colours(sizes.flat, &colours).unwrap(),
        values: FlatValues::Views((0..sizes.views).map(|view| flat_view(sizes, view, seed + 2)).collect()),
    }
}

pub fn mask(sizes: Sizes, seed: u64) -> VisibilityMask {
    let mut numbers = Numbers::new(seed);
    let texels = (0..sizes.flat * sizes.flat * sizes.views).map(|_| if numbers.bits() & 1 == 0 { 0 } else { 255 });
    VisibilityMask::new(sizes.flat, sizes.views, texels.collect()).unwrap()
}

/// Shape of a made-up factored asset, besides its sizes.
#[derive(Debug, Clone, Copy)]
pub struct Factors {
    pub levels: u32,
    pub groups: u32,
    pub wide_groups: u32,
    pub shadow: ShadowFormat,
}

/// A factored asset of random texels.
pub fn factored(sizes: Sizes, factors: Factors, seed: u64) -> FactoredFlatBtf {
    let mut numbers = Numbers::new(seed);
    let Factors { levels, groups, wide_groups, shadow } = factors;
    let components = groups as usize * GROUP;
    let steps = [2e-3, 1e-3, 1e-3].map(|scale| {
        (0..components)
            .map(|k| {
                let most = if k < wide_groups as usize * GROUP { 1.0 / 256.0 } else { 1.0 };
                scale * most * numbers.between(0.5, 1.5) as f32
            })
            .collect()
    });
    let header = FactoredHeader {
        size: sizes.flat,
        levels,
        groups,
        wide_groups,
        shadow,
        views: directions(sizes.views, 1),
        lights: directions(sizes.lights, 2),
        steps,
        errors: FactoredErrors {
            texels: 3,
            seen_mean: 0.5,
            seen_p95: 1.0,
            seen_max: 2.0,
            all_mean: 0.75,
            all_p95: 1.5,
        },
    };
    let texels = |layers: u32| {
        (0..levels).map(|level| (sizes.flat >> level).max(1).pow(2) as usize).sum::<usize>() * layers as usize
    };
    let mut bytes = |count: usize| (0..count).map(|_| numbers.bits() as u8).collect::<Vec<u8>>();
    let weights = bytes(GROUP * texels(BASE_LAYERS + groups));
    let shadows = bytes(texels(sizes.lights));
    let range =
        |k: usize| WeightRange { scale: if k == 0 { 200.0 } else { 60.0 }, low: if k == 0 { 1.0 } else { -25.0 } };
    let ranges = base_ranges().into_iter().chain((0..components).map(range)).collect();
    let basis = BasisMap::from_steps(header, &base_table(), |_, _, colour, component| {
        let most = if component < wide_groups as usize * GROUP { 32767.0 } else { 127.0 };
        // Lightness is mostly positive.
        let low = if colour == 0 && component == 0 { 0.2 } else { -1.0 };
        (most * numbers.between(low, 1.0)) as i32
    });
    let weights = WeightMap::new(sizes.flat, levels, ranges, weights).unwrap();
    let shadow =
        (shadow != ShadowFormat::None).then(|| ShadowMap::new(sizes.flat, levels, sizes.lights, shadows).unwrap());
    FactoredFlatBtf::new(basis.unwrap(), weights, shadow).unwrap()
}

/// A factored asset whose numbers follow rules, none of which is a mathematical function: lightness mostly from component 0,
/// more under later lights and in later views; what is odd is small.
pub fn factored_example() -> FactoredFlatBtf {
    let (size, levels, groups, wide_groups) = (4u32, 3, 2, 1);
    let (views, lights) = (vec![[0.0, 0.0], [0.5, 1.0], [1.25, 3.0]], vec![[0.0, 0.0], [0.75, 2.0], [1.0, 5.5]]);
    let errors =
        FactoredErrors { texels: 3, seen_mean: 0.5, seen_p95: 1.0, seen_max: 2.0, all_mean: 0.75, all_p95: 1.5 };
    let steps = [1.0, 0.5, 0.25].map(|colour| {
        (0..8u8).map(|k| colour * if k < 4 { 0.003_906_25 } else { 0.062_5 } * (1.0 + 0.125 * f32::from(k))).collect()
    });
    let shadow = ShadowFormat::R8;
    let header = FactoredHeader { size, levels, groups, wide_groups, shadow, views, lights, steps, errors };
    let basis = BasisMap::from_steps(header, &base_table(), |view, light, colour, component| {
        let at = (((view * 3 + light) * 3 + colour) * 8 + component) as i32;
        match component {
            0 if colour == 0 => 256 * (40 + 10 * view as i32 + 5 * light as i32),
            0..4 => at * 3701 % 2561 - 1280,
            _ => at * 29 % 255 - 127,
        }
    });
    let texels = (0..levels).map(|level| (size >> level).pow(2)).sum::<u32>();
    let weights = (0..16 * texels).map(|k| (k * 83 + 17) as u8).collect();
    let shadows = (0..3 * texels).map(|k| (k * 101 + 5).min(255 * (k % 7)) as u8).collect();
    let range = |k| if k == 0 { WeightRange { scale: 1.0, low: 0.5 } } else { WeightRange { scale: 2.0, low: -1.0 } };
    let ranges = base_ranges().into_iter().chain((0..8).map(range)).collect();
    let weights = WeightMap::new(size, levels, ranges, weights);
    let shadow = ShadowMap::new(size, levels, 3, shadows);
    FactoredFlatBtf::new(basis.unwrap(), weights.unwrap(), Some(shadow.unwrap())).unwrap()
}

/// A file of small maps with a mask, and with these displacements and values.
pub fn file(indirection: impl Into<Indirection>, values: FlatValues) -> FlatBtfFile {
    let parts = FlatBtfParts { indirection: indirection.into(), values, ..parts(SMALL, 8) };
    FlatBtfFile::new(FlatBtfDecoder::new(parts).unwrap(), Some(mask(SMALL, 1))).unwrap()
}

/// A file of [`factored_example`] with displacements of bytes.
pub fn factored_file() -> FlatBtfFile {
    file(displacements(SMALL, 2, 3), FlatValues::Factored(Box::new(factored_example())))
}

/// A file of the light form, with directions and distances of displacements.
pub fn light_file() -> FlatBtfFile {
    file(indirection(SMALL, 9), FlatValues::None)
}

/// What a reader says of a file whose images or entries were changed.
pub fn refusal(file: &FlatBtfFile, change: impl FnOnce(&mut PackFile)) -> FormatError {
    let mut file = PackFile::from_bytes(&file.to_bytes(false)).expect("our own file");
    change(&mut file);
    FlatBtfFile::from_file(file).expect_err("a broken rule")
}

/// The image of a binding.
pub fn image<'f>(file: &'f mut PackFile, name: &str) -> &'f mut Texels<'static> {
    match file.bindings.all.iter_mut().find(|binding| binding.name == name).map(|binding| &mut binding.resource) {
        Some(Resource::Texture(texels)) => texels,
        other => panic!("{name}: {other:?}"),
    }
}

/// Replaces a texel of an image.
pub fn set_texel(file: &mut PackFile, name: &str, at: usize, texel: &[u8]) {
    image(file, name).bytes.to_mut()[at * texel.len()..][..texel.len()].copy_from_slice(texel);
}

/// Gives an image another shape.
pub fn reshape(file: &mut PackFile, name: &str, format: TexelFormat, extent: Extent, levels: u32) {
    let image = image(file, name);
    (image.format, image.extent, image.levels) = (format, extent, levels);
    image.bytes.to_mut().resize(extent.texels_of_levels(levels) as usize * format.texel_bytes(), 7);
}

/// Replaces the word at a byte of an entry.
pub fn set_word(file: &mut PackFile, key: &str, offset: usize, word: u32) {
    let entry = file.entries.get_mut(key).expect("an entry of this name");
    entry[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
}

/// Reads a file, whatever its checksum is, and where it is a flat BTF decodes it here and there: its values are numbers,
/// whatever it holds.
pub fn survives(bytes: &[u8]) -> bool {
    let Ok(file) = FlatBtfFile::from_bytes(&sealed(bytes.to_vec())) else { return false };
    let decoder = &file.decoder;
    for (k, (uv, detail)) in (0..).zip([([0.1, 0.9], 0.0), ([1.3, -0.2], 0.6), ([0.5, 0.5], 7.0)]) {
        let direction = TOWARDS[k as usize];
        let seen = decoder.indirection(uv, direction);
        assert!(seen.iter().all(|c| c.abs() <= MAX_COORDINATE), "{seen:?}");
        let mut values = decoder.light_form(uv, direction, direction).to_vec();
        if let Some(asset) = decoder.parts().values.factored() {
            let (views, lights) = (asset.header().views.len() as u32, asset.header().lights.len() as u32);
            values.extend(asset.texel([k % asset.header().size, 0]).value(k % views, k % lights));
            values.extend(asset.value(uv, detail, towards(only(k % views)), towards(only(k % lights))));
        }
        assert!(values.iter().all(|c| (0.0..3e5).contains(c)), "{values:?}");
    }
    true
}

/// Three of `count` directions with weights, some of them 0.
pub fn weights(numbers: &mut Numbers, count: u32) -> ViewWeights {
    let indices = [0; 3].map(|_| numbers.bits() % count);
    let mut weights = [0; 3].map(|_| numbers.unit() as f32);
    if numbers.bits().is_multiple_of(4) {
        weights[numbers.bits() as usize % 3] = 0.0;
    }
    let sum: f32 = weights.iter().sum();
    ViewWeights { indices, weights: weights.map(|w| w / sum) }
}

/// A table that falls with the half angle and grows with the difference angle: whole numbers over whole numbers.
pub fn base_table() -> BaseTable {
    let entry = |at: usize| {
        let (i, j) = ((at / DIFFERENCE_ANGLES) as f32, (at % DIFFERENCE_ANGLES) as f32);
        [8.0, 6.0, 4.0].map(|peak| (peak + j) / (1.0 + i))
    };
    BaseTable::new((0..HALF_ANGLES * DIFFERENCE_ANGLES).map(entry).collect()).unwrap()
}

/// Albedos of 0 to 1, normals that lean by less than a right angle.
pub fn base_ranges() -> [WeightRange; 8] {
    let albedo = WeightRange { scale: 1.0, low: 0.0 };
    let [high, low] = [WeightRange { scale: 1.0, low: -0.5 }, WeightRange { scale: 0.003_906_25, low: 0.0 }];
    [albedo, albedo, albedo, albedo, high, low, high, low]
}

/// Directions above the surface.
const TOWARDS: [[f32; 3]; 5] =
    [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -0.8, 0.6], [-0.48, 0.64, 0.6], [0.0, 0.96, 0.28]];

/// A direction for these samples, which need not be near them.
pub fn towards(samples: ViewWeights) -> BlendedDirection {
    let [a, b, _] = samples.indices;
    BlendedDirection { direction: TOWARDS[(a as usize + 2 * b as usize) % TOWARDS.len()], samples }
}

/// One whole weight.
pub fn only(index: u32) -> ViewWeights {
    ViewWeights { indices: [index; 3], weights: [1.0, 0.0, 0.0] }
}

/// The indirection whose entry and texels are in `formats/src/flat_btf/spec.md`.
pub fn example_indirection() -> IndirectionMap {
    let header = IndirectionHeader { size: 1, zenith_samples: 2, azimuth_samples: 3, largest_angle: 1.0 };
    let displacements = [[0.25, 0.0], [-0.125, 0.216_506], [-0.125, -0.216_506]];
    IndirectionMap::from_displacements(header, |_, k, a| (displacements[a as usize], 0.5 * k as f32)).unwrap()
}

/// Flat BTFs of every kind of values that files have.
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

/// As `FlatMaterial::value` of the renderer.
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

/// View and light among the sampled ones, and what is left of a light below all of these.
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

/// A view whose place among the views of the indirection is moved by so many of them, polar angle first.
fn moved_view(decoder: &FlatBtfDecoder, [x, y, z]: [f32; 3], [polar, azimuth]: [f32; 2]) -> [f32; 3] {
    let header = decoder.parts().indirection.header();
    let steps = [header.largest_angle / (header.zenith_samples - 1) as f32, TAU / header.azimuth_samples as f32];
    let theta = (x.hypot(y).atan2(z).min(header.largest_angle) + polar * steps[0]).clamp(0.0, header.largest_angle);
    let phi = y.atan2(x) + azimuth * steps[1];
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// A value of a flat BTF with the indirection of another view, and with what is filtered behind it moved, in parameters and
/// levels.
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

/// What a value of a flat BTF may be off by.
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
    // The shader keeps off the borders of blocks by half a step more.
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
        // A writer makes the least exponent that does; a reader takes any word.
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
        // Its values follow rules that a decoder in another language was written for.
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

    /// All values of its maps, its look-ups, the light form, and of a factored one the values of all texels in all views
    /// under all lights, and look-ups at and between mipmap levels.
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
