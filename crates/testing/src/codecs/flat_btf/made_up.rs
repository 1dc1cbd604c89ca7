//! Made-up flat BTFs, and modifications of their files.

use crate::packs::{Numbers, sealed};
use brdfc_formats::FormatError;
use brdfc_formats::bindings::{PackFile, Resource, Texels};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_formats::flat_btf::factored::{
    Axis, BASE_LAYERS, BaseMaterial, BaseTable, BasisMap, ChromaRange, DIFFERENCE_ANGLES, FactoredErrors,
    FactoredFlatBtf, FactoredHeader, GROUP, HALF_ANGLES, LevelTable, ResidualMap, WeightMap, WeightRange,
};
use brdfc_formats::flat_btf::{
    BlendedDirection, CompactSamples, FlatBtfDecoder, FlatBtfFile, FlatBtfParts, LayerHeader, LayerMap, Relief,
    SeenPoint, ShadowMap, StoredReflectance, Vdim, VdimHeader, VdimSamples, ViewWeights,
};
use std::f32::consts::FRAC_PI_2;

/// Sizes of a made-up asset.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    /// Texels of the flat BTF per side.
    pub flat: u32,
    /// Texels of the layers per side.
    pub plane: u32,
    /// Number of sheets: 1 or 3.
    pub sheets: u32,
    pub views: u32,
    pub lights: u32,
}

pub const SMALL: Sizes = Sizes { flat: 4, plane: 8, sheets: 3, views: 3, lights: 5 };

pub fn directions(count: u32, seed: u64) -> Vec<[f32; 2]> {
    let mut numbers = Numbers::new(seed);
    (0..count).map(|_| [FRAC_PI_2 * numbers.unit() as f32, 6.2 * numbers.unit() as f32]).collect()
}

/// Header of layers with all mipmap levels, from a quarter of a tile below the reference plane to a quarter above it.
pub fn layer_header(sizes: Sizes) -> LayerHeader {
    let Sizes { plane: size, sheets, .. } = sizes;
    LayerHeader { size, sheets, levels: size.ilog2() + 1, heights: [-0.25, 0.25] }
}

/// Layers whose finest level has these texels: heights of base, top and underside as bytes, and displacements of the
/// three sheets in tiles. Coarser levels are means, and so are all levels of the displacements. With one sheet only the
/// base is stored.
pub fn relief(header: LayerHeader, texel: impl Fn([u32; 2]) -> ([u8; 3], [[f32; 2]; 3])) -> LayerMap {
    let (size, sheets) = (header.size, header.sheets as usize);
    let numbers = |at: u32| -> [f32; 9] {
        let (heights, moved) = texel([at % size, at / size]);
        std::array::from_fn(|k| if k < 3 { f32::from(heights[k]) } else { moved[(k - 3) / 2][(k - 3) % 2] })
    };
    let mut texels: Vec<[f32; 9]> = (0..size * size).map(numbers).collect();
    let (mut heights, mut displacements) = (Vec::new(), Vec::new());
    for level in 0..header.levels.max(2) {
        let [finer, side] = [level.saturating_sub(1), level].map(|level| (size >> level).max(1) as usize);
        if side < finer {
            let mean = |at: usize| -> [f32; 9] {
                let first = 2 * (at / side) * finer + 2 * (at % side);
                let four = [first, first + 1, first + finer, first + finer + 1];
                std::array::from_fn(|k| {
                    let mean = four.iter().map(|at| texels[*at][k]).sum::<f32>() / 4.0;
                    if k < 3 { mean.round() } else { mean }
                })
            };
            texels = (0..side * side).map(mean).collect();
        }
        if level < header.levels {
            for texel in &texels {
                heights.push(texel[0] as u8);
                if sheets > 1 {
                    heights.extend([texel[1] as u8, texel[2] as u8, 0]);
                }
            }
        }
        // Level 0 of the displacements has as many texels as level 1 of the heights.
        if level > 0 {
            for sheet in 0..sheets {
                displacements.extend(texels.iter().map(|texel| [texel[3 + 2 * sheet], texel[4 + 2 * sheet]]));
            }
        }
    }
    LayerMap::new(header, heights, displacements).unwrap()
}

/// Smooth random layers: a low base, an underside above it, and a top above the underside in part of the tile and below
/// it elsewhere; small random displacements.
pub fn layers(sizes: Sizes, seed: u64) -> LayerMap {
    let mut numbers = Numbers::new(seed);
    let [base, gap, thickness] = [(); 3].map(|()| smooth(sizes.plane, &mut numbers));
    let moved: Vec<[[f32; 2]; 3]> = (0..sizes.plane * sizes.plane)
        .map(|_| [(); 3].map(|()| [(); 2].map(|()| numbers.between(-0.04, 0.04) as f32)))
        .collect();
    relief(layer_header(sizes), |[column, row]| {
        let at = (row * sizes.plane + column) as usize;
        let underside = 120 + gap[at] / 4;
        let top = underside + 2 * (thickness[at] - 128);
        ([20 + 2 * base[at] / 5, top.clamp(0, 255), underside].map(|height| height as u8), moved[at])
    })
}

/// Random bytes, each the mean of itself and its eight neighbours with period `size`.
fn smooth(size: u32, numbers: &mut Numbers) -> Vec<i32> {
    let size = size as usize;
    let bytes: Vec<i32> = (0..size * size).map(|_| (numbers.bits() & 255) as i32).collect();
    let mean = |at: usize| {
        let of = |k: usize| [(at % size + k % 3) % size, (at / size + k / 3) % size];
        (0..9).map(of).map(|[column, row]| bytes[row * size + column]).sum::<i32>() / 9
    };
    (0..size * size).map(mean).collect()
}

/// Layers of one height and one displacement. The other sheets are closed: the underside is above the top.
pub fn flat_relief(sizes: Sizes) -> LayerMap {
    relief(layer_header(sizes), |_| ([100, 40, 200], [[0.0625, -0.03125]; 3]))
}

/// Random layers over a base alone.
pub fn parts(sizes: Sizes, seed: u64) -> FlatBtfParts {
    let factors = Factors { levels: sizes.flat.ilog2() + 1, ..BASE };
    FlatBtfParts::new(layers(sizes, seed), factored(sizes, factors, seed + 1))
}

/// An indirection map of 4 polar angles and 5 rows over `plane` texels, with all levels: displacements grow with the polar
/// angle, roughly along the view, and differ between texels.
pub fn indirections(sizes: Sizes, lights: u32, seed: u64) -> Vdim {
    let mut numbers = Numbers::new(seed);
    let of_level = |level: u32| {
        let size = sizes.plane >> level;
        let header =
            VdimHeader { size, block: 1, polar_angles: 4, azimuth_rows: 5, largest_angle: 1.25, levels: 1, lights };
        let texels: Vec<[f32; 4]> =
            (0..size * size).map(|_| std::array::from_fn(|_| numbers.between(-0.25, 0.25) as f32)).collect();
        let reference = texels.iter().map(|[x, y, ..]| [0.25 * x, 0.25 * y]).collect();
        let seen = |[i, j]: [u32; 2], k: u32, a: u32| {
            let [.., turn, height] = texels[(j * size + i) as usize];
            let (along, azimuth) = (k as f32 * (0.125 + 0.25 * height), a as f32 * FRAC_PI_2 + turn);
            SeenPoint { displacement: [along * azimuth.cos(), along * azimuth.sin()], height: height - 0.01 * k as f32 }
        };
        Vdim::of_views(header, reference, seen).unwrap()
    };
    Vdim::of_levels((0..=sizes.plane.trailing_zeros()).map(of_level).collect()).unwrap()
}

/// An indirection map of one reference and one displacement.
pub fn flat_indirections(sizes: Sizes, lights: u32) -> Vdim {
    let of_level = |level: u32| {
        let size = sizes.plane >> level;
        let header =
            VdimHeader { size, block: 1, polar_angles: 4, azimuth_rows: 5, largest_angle: 1.25, levels: 1, lights };
        let seen = |_, _, _| SeenPoint { displacement: [0.012, 0.016], height: 0.125 };
        Vdim::of_views(header, vec![[0.0625, -0.03125]; (size * size) as usize], seen).unwrap()
    };
    Vdim::of_levels((0..=sizes.plane.trailing_zeros()).map(of_level).collect()).unwrap()
}

/// A map of compact samples with blocks of 2 x 2 texels, with all levels: random displacements and heights.
pub fn compact_indirections(sizes: Sizes, lights: u32, seed: u64) -> Vdim {
    compact(sizes, lights, |numbers, low, high| numbers.between(low, high), seed)
}

/// A map of compact samples of one reference, one displacement in the frames of views and one height.
pub fn flat_compact_indirections(sizes: Sizes, lights: u32) -> Vdim {
    compact(sizes, lights, |_, low, high| low + 0.25 * (high - low), 1)
}

fn compact(sizes: Sizes, lights: u32, number: impl Fn(&mut Numbers, f64, f64) -> f64, seed: u64) -> Vdim {
    let mut numbers = Numbers::new(seed);
    let mut number = |low, high| number(&mut numbers, low, high) as f32;
    let of_level = |level: u32| {
        let (size, block) = (sizes.plane >> level, 2);
        let header =
            VdimHeader { size, block, polar_angles: 4, azimuth_rows: 5, largest_angle: 1.25, levels: 1, lights };
        let blocks = (size / block) as usize;
        let mut texels = |count: usize, low, high| -> Vec<[f32; 2]> {
            (0..count).map(|_| [(); 2].map(|()| number(low, high))).collect()
        };
        let reference = texels((size * size) as usize, -0.0625, 0.0625);
        let ranges = [texels(blocks * blocks, -0.125, 0.0), texels(blocks * blocks, 0.0, 0.125)].concat();
        let width = blocks * 4;
        let packed = (0..blocks).flat_map(|_| {
            let rows = texels(width * 4, 0.0, 255.0);
            let last = rows[..width].to_vec();
            rows.into_iter().chain(last)
        });
        let packed = packed.map(|texel| texel.map(|byte| byte as u8)).collect();
        let heights = (0..size * size).map(|_| number(0.0, 255.0) as u8).collect();
        let samples = CompactSamples { range: [-0.25, 0.25], ranges, packed, heights };
        Vdim::new(header, reference, VdimSamples::Compact(samples)).unwrap()
    };
    Vdim::of_levels((0..sizes.plane.trailing_zeros()).map(of_level).collect()).unwrap()
}

/// Sampled shadows of random shares.
pub fn sampled_shadows(sizes: Sizes, levels: u32, seed: u64) -> ShadowMap {
    let mut numbers = Numbers::new(seed);
    let texels: u32 = (0..levels).map(|level| (sizes.flat >> level).max(1).pow(2)).sum();
    let bytes = (0..texels * sizes.lights).map(|_| numbers.bits() as u8).collect();
    ShadowMap::new(directions(sizes.lights, 2), sizes.flat, levels, bytes).unwrap()
}

/// A map that `map` makes for a number of lights, with or without sampled shadows.
pub fn sampled_relief(sizes: Sizes, with_shadows: bool, map: impl Fn(u32) -> Vdim) -> Relief {
    let shadows = with_shadows.then(|| sampled_shadows(sizes, BASE.levels, 12));
    Relief::sampled(map(if with_shadows { sizes.lights } else { 0 }), shadows).unwrap()
}

/// A file of two materials behind an indirection map with sampled shadows.
pub fn vdim_file() -> FlatBtfFile {
    file_of_map(indirections)
}

/// The same with compact samples.
pub fn compact_vdim_file() -> FlatBtfFile {
    file_of_map(compact_indirections)
}

fn file_of_map(map: impl Fn(Sizes, u32, u64) -> Vdim) -> FlatBtfFile {
    let relief = sampled_relief(SMALL, true, |lights| map(SMALL, lights, 11));
    FlatBtfFile::new(FlatBtfDecoder::new(FlatBtfParts::new(relief, factored(SMALL, MATERIALS, 6)))).unwrap()
}

/// Layers of parts that have them.
pub fn layers_of(parts: &FlatBtfParts) -> &LayerMap {
    parts.relief.layers().expect("layers")
}

/// Shape of a made-up factored asset, besides its sizes.
#[derive(Debug, Clone, Copy)]
pub struct Factors {
    pub levels: u32,
    pub groups: u32,
    pub wide_groups: u32,
    /// Cells per side of the residual of shadows.
    pub residual: u32,
    pub materials: u32,
}

/// A base alone, for small sizes.
pub const BASE: Factors = Factors { levels: 3, groups: 0, wide_groups: 0, residual: 0, materials: 0 };
/// Two materials, for small sizes.
pub const MATERIALS: Factors = Factors { materials: 2, ..BASE };

/// A factored asset of random texels. Without groups it has no views and lights.
pub fn factored(sizes: Sizes, factors: Factors, seed: u64) -> FactoredFlatBtf {
    let mut numbers = Numbers::new(seed);
    let Factors { levels, groups, wide_groups, residual, materials } = factors;
    let [views, lights] = [sizes.views, sizes.lights].map(|count| if groups == 0 { 0 } else { count });
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
        residual,
        views: directions(views, 1),
        lights: directions(lights, 2),
        chroma: ChromaRange([-20, 60, -30, 24]),
        materials: 0,
        axes: 0,
        table_levels: 1,
        albedos: [[0.0; 3]; 2],
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
    let cells: u32 = (0..4).map_while(|level| (residual >> level > 0).then_some((residual >> level).pow(2))).sum();
    let shares = bytes(2 * (cells * lights) as usize);
    let range =
        |k: usize| WeightRange { scale: if k == 0 { 200.0 } else { 60.0 }, low: if k == 0 { 1.0 } else { -25.0 } };
    let ranges = base_ranges().into_iter().chain((0..components).map(range)).collect();
    let basis = if materials > 0 {
        let mut made = two_materials();
        // A pack without mipmaps has one level of tables.
        made.iter_mut().for_each(|material| material.tables.truncate(levels as usize));
        BasisMap::of_materials(header, &made[..materials as usize])
    } else {
        BasisMap::from_steps(header, &base_table(), |_, _, colour, component| {
            let most = if component < wide_groups as usize * GROUP { 32767.0 } else { 127.0 };
            // Lightness is mostly positive.
            let low = if colour == 0 && component == 0 { 0.2 } else { -1.0 };
            (most * numbers.between(low, 1.0)) as i32
        })
    };
    let weights = WeightMap::new(sizes.flat, levels, ranges, weights).unwrap();
    let residual = (residual > 0).then(|| ResidualMap::new(residual, lights, shares).unwrap());
    FactoredFlatBtf::new(basis.unwrap(), weights, residual).unwrap()
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
    let (residual, chroma) = (2, ChromaRange([-20, 60, -30, 24]));
    let (materials, axes, table_levels) = (0, 0, 1);
    let header = FactoredHeader {
        size,
        levels,
        groups,
        wide_groups,
        residual,
        views,
        lights,
        chroma,
        materials,
        axes,
        table_levels,
        albedos: [[0.0; 3]; 2],
        steps,
        errors,
    };
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
    // 2 x 2 cells and one, of two numbers for three lights.
    let shares = (0..30).map(|k| (k * 101 + 5).min(255 * (k % 7)) as u8).collect();
    let range = |k| if k == 0 { WeightRange { scale: 1.0, low: 0.5 } } else { WeightRange { scale: 2.0, low: -1.0 } };
    let ranges = base_ranges().into_iter().chain((0..8).map(range)).collect();
    let weights = WeightMap::new(size, levels, ranges, weights);
    let residual = ResidualMap::new(residual, 3, shares).unwrap();
    FactoredFlatBtf::new(basis.unwrap(), weights.unwrap(), Some(residual)).unwrap()
}

/// Layers whose heights follow rules without mathematical functions: an arch along the rows over a base that falls.
pub fn example_layers() -> LayerMap {
    let header = LayerHeader { size: 8, sheets: 3, levels: 4, heights: [-0.25, 0.25] };
    relief(header, |[column, row]| {
        let top = [240, 232, 216, 150, 64, 64, 96, 200][row as usize];
        let moved = |sheet: u32| [0.015_625 * (column + sheet) as f32 - 0.0625, 0.007_812_5 * (row + 2 * sheet) as f32];
        ([(64 - 8 * column) as u8, top, 160], [0, 1, 2].map(moved))
    })
}

/// A file of these parts.
pub fn file(layers: LayerMap, reflectance: impl Into<StoredReflectance>) -> FlatBtfFile {
    FlatBtfFile::new(FlatBtfDecoder::new(FlatBtfParts::new(layers, reflectance))).unwrap()
}

/// A file of [`factored_example`] over three sheets.
pub fn factored_file() -> FlatBtfFile {
    file(layers(SMALL, 3), factored_example())
}

/// A file of two materials over three sheets.
pub fn materials_file() -> FlatBtfFile {
    file(layers(SMALL, 5), factored(SMALL, MATERIALS, 6))
}

/// A file of a base alone over one sheet.
pub fn base_file() -> FlatBtfFile {
    file(layers(Sizes { sheets: 1, ..SMALL }, 9), factored(SMALL, BASE, 8))
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
    let asset = match &decoder.parts().reflectance {
        StoredReflectance::Factors(asset) => asset,
        StoredReflectance::Trees(_) => return survives_of_trees(decoder),
    };
    let (views, lights) = (asset.header().views.len() as u32, asset.header().lights.len() as u32);
    for (k, (uv, detail)) in (0..).zip([([0.1, 0.9], 0.0), ([1.3, -0.2], 0.6), ([0.5, 0.5], 7.0)]) {
        let (point, parameters) = decoder.seen(uv, TOWARDS[k as usize], detail);
        let is_near = point.at.iter().all(|c| c.abs() < 2048.0);
        assert!(is_near && (0.0..=1.0).contains(&point.height), "{point:?}");
        assert!(parameters.iter().all(|c| (0.0..1.0).contains(c)), "{parameters:?}");
        let texel = asset.texel([k % asset.header().size, 0]);
        let mut values = Vec::new();
        if views > 0 {
            values.extend(texel.value(k % views, k % lights));
            values.extend(decoder.value(uv, detail, towards(only(k % views)), towards(only(k % lights))));
        } else {
            values.extend(decoder.value(uv, detail, towards(nothing(k)), towards(nothing(k + 1))));
        }
        assert!(values.iter().all(|c| (0.0..3e5).contains(c)), "{values:?}");
    }
    true
}

/// [`survives`] of trees.
fn survives_of_trees(decoder: &FlatBtfDecoder) -> bool {
    for (uv, detail) in [([0.1, 0.9], 0.0), ([1.3, -0.2], 0.6), ([0.5, 0.5], 7.0)] {
        for (view, light) in TOWARDS.into_iter().zip(TOWARDS.into_iter().rev()) {
            let value = decoder.shaded(None, uv, detail, view, light);
            assert!(value.iter().all(|c| (0.0..3e5).contains(c)), "{value:?}");
        }
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

/// Materials with tables over half angles and over mirror angles.
pub fn two_materials() -> [BaseMaterial; 2] {
    let table = base_table();
    let scaled = |axis: Axis, factor: f32| {
        let entries = table.entries().iter().map(|entry| entry.map(|c| factor * c)).collect();
        BaseTable::new(entries).unwrap().over(axis)
    };
    // Two levels: from afar there is half the gloss, and less diffuse light for larger difference angles.
    let tables = |axis: Axis, factor: f32| {
        let less = |at: usize| 1.0 - 0.0625 * (at % DIFFERENCE_ANGLES) as f32;
        let diffuse = (0..HALF_ANGLES * DIFFERENCE_ANGLES).map(less).collect();
        let far = LevelTable::new(scaled(axis, 0.5 * factor), diffuse).unwrap();
        vec![LevelTable::close_up(scaled(axis, factor)), far]
    };
    [
        BaseMaterial { diffuse: [0.75, 0.5, 0.25], tables: tables(Axis::Half, 1.0) },
        BaseMaterial { diffuse: [0.125, 0.25, 0.0], tables: tables(Axis::Mirror, 0.5) },
    ]
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

/// Weights of 0, for a base alone. The index varies [`towards`].
pub fn nothing(index: u32) -> ViewWeights {
    ViewWeights { indices: [index; 3], weights: [0.0; 3] }
}
