//! Made-up flat BTFs, and modifications of their files.

use crate::packs::{Numbers, sealed, unit_vector};
use brdfc_formats::FormatError;
use brdfc_formats::bindings::{PackFile, Resource, Texels};
use brdfc_formats::container::{Extent, TexelFormat, half, rgb9e5};
use brdfc_formats::flat_btf::factored::{
    BASE_LAYERS, BaseTable, BasisMap, ChromaRange, DIFFERENCE_ANGLES, FactoredErrors, FactoredFlatBtf, FactoredHeader,
    GROUP, HALF_ANGLES, ShadowFormat, ShadowMap, WeightMap, WeightRange,
};
use brdfc_formats::flat_btf::{
    BlendedDirection, DiffuseMap, DisplacementHeader, DisplacementMap, FlatBtfDecoder, FlatBtfFile, FlatBtfParts,
    FlatHeader, FlatValues, FlatView, Indirection, IndirectionHeader, IndirectionMap, MAX_COORDINATE, NormalMap,
    ReferenceMap, ViewWeights, VisibilityMask,
};
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

/// Displacements of random bytes between random bounds, with this number of blocks per side.
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
        chroma: ChromaRange([-20, 60, -30, 24]),
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

/// A factored asset whose numbers follow rules without mathematical functions: lightness mostly from component 0, more
/// under later lights and in later views. Odd terms are small.
pub fn factored_example() -> FactoredFlatBtf {
    let (size, levels, groups, wide_groups) = (4u32, 3, 2, 1);
    let (views, lights) = (vec![[0.0, 0.0], [0.5, 1.0], [1.25, 3.0]], vec![[0.0, 0.0], [0.75, 2.0], [1.0, 5.5]]);
    let errors =
        FactoredErrors { texels: 3, seen_mean: 0.5, seen_p95: 1.0, seen_max: 2.0, all_mean: 0.75, all_p95: 1.5 };
    let steps = [1.0, 0.5, 0.25].map(|colour| {
        (0..8u8).map(|k| colour * if k < 4 { 0.003_906_25 } else { 0.062_5 } * (1.0 + 0.125 * f32::from(k))).collect()
    });
    let (shadow, chroma) = (ShadowFormat::R8, ChromaRange([-20, 60, -30, 24]));
    let header = FactoredHeader { size, levels, groups, wide_groups, shadow, views, lights, chroma, steps, errors };
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

/// A file of small maps with a mask and these displacements and values.
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

/// Error of a reader for a file whose images or metadata were changed.
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

/// Replaces the word at an offset of an entry.
pub fn set_word(file: &mut PackFile, key: &str, offset: usize, word: u32) {
    let entry = file.entries.get_mut(key).expect("an entry of this name");
    entry[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
}

/// Reads a file with any checksum. If it is a flat BTF, decodes it at some points and checks that all values are
/// finite.
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

/// A table that falls with the half angle and grows with the difference angle: ratios of whole numbers.
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
