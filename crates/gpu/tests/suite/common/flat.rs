//! Flat BTFs of procedural structures, encoded in memory.

use brdfc_core::address::parse_synth;
use brdfc_flat_btf::encode::{
    FlatBtfEncoded, FlatInput, FlattenRecipe, MemoryScratch, Reflectance, ReliefForm, ValueSource, encode,
};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::Appearance;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::factored::{BasisMap, FactoredFlatBtf, FactoredHeader, WeightMap};
use brdfc_formats::flat_btf::{FlatBtfParts, LayerHeader, LayerMap};
use brdfc_testing::codecs::flat_btf::layers_of;

/// The appearance of a structure such as `button?resolution=48`: its own materials, or another one.
pub fn appearance(address: &str, material: Option<&str>) -> Appearance {
    let structure = Structure::parse(address).unwrap();
    let materials = material.map_or(structure.default_materials().to_vec(), |material| vec![material]);
    let sources = materials.into_iter().map(|address| parse_synth(address).unwrap()).collect();
    Appearance { sources, ..Default::default() }
}

/// A flat BTF of a structure. `texels` per side, of the layers and of the flat BTF, must be a power of 2. Values contain
/// shadows if there are `bounces`; otherwise rays of light determine shadows.
pub fn flattened(
    address: &str,
    appearance: &Appearance,
    texels: usize,
    directions: &DirectionSet,
    (reflectance, bounces): (Reflectance, usize),
) -> FlatBtfEncoded {
    let recipe = FlattenRecipe {
        relief: ReliefForm::Layers,
        texels: texels as u32,
        flat_texels: texels,
        views: directions.clone(),
        lights: directions.clone(),
        fill: FillMethod::PushPull,
        bounces,
        reflectance,
        target: FactoredTarget::Components { components: 24, residual: if bounces > 0 { 16 } else { 0 } },
    };
    let mesh = Structure::parse(address).unwrap().mesh();
    let input = FlatInput { mesh, repairs: None, values: ValueSource::Computed(appearance) };
    encode(input, &recipe, &MemoryScratch::default(), &()).unwrap()
}

/// The same parts with all heights scaled by `factor`, above 0. Near 0 every view sees the points of the view along the
/// normal, and there are no shadows.
pub fn with_heights(parts: &FlatBtfParts, factor: f32) -> FlatBtfParts {
    let layers = layers_of(parts);
    let header = layers.header();
    let header = LayerHeader { heights: header.heights.map(|height| factor * height), ..*header };
    FlatBtfParts { relief: finest(layers, header).into(), ..parts.clone() }
}

/// The same parts without mipmaps.
pub fn without_mipmaps(parts: &FlatBtfParts) -> FlatBtfParts {
    let (layers, reflectance) = (layers_of(parts), parts.reflectance.factors().unwrap());
    let header = FactoredHeader { levels: 1, ..reflectance.header().clone() };
    let (size, texels) = (header.size, (header.size * header.size) as usize);
    let weights = reflectance.weights();
    let bytes = weights.texels()[..4 * weights.layers() as usize * texels].to_vec();
    let weights = WeightMap::new(size, 1, weights.ranges().to_vec(), bytes).unwrap();
    let mut materials = reflectance.basis().materials().to_vec();
    materials.iter_mut().for_each(|material| material.tables.truncate(1));
    let basis = match materials[..] {
        [] => BasisMap::new(header, reflectance.basis().words().to_vec(), reflectance.basis().table_texels().to_vec()),
        _ => BasisMap::of_materials(header, &materials),
    };
    let basis = basis.unwrap();
    let layers = finest(layers, LayerHeader { levels: 1, ..*layers.header() });
    FlatBtfParts::new(layers, FactoredFlatBtf::new(basis, weights, reflectance.residual().cloned()).unwrap())
}

/// The first levels of layers, with another header.
fn finest(layers: &LayerMap, header: LayerHeader) -> LayerMap {
    let texels = header.height_extent().texels_of_levels(header.levels) as usize;
    let heights = layers.height_bytes()[..texels * header.height_format().texel_bytes()].to_vec();
    let halves = layers.displacement_bytes();
    let half = |bytes: &[u8; 2]| brdfc_formats::container::half::decode(u16::from_le_bytes(*bytes));
    let displacements = header.displacement_extent().texels_of_levels(header.displacement_levels()) as usize;
    let numbers = halves.as_chunks::<2>().0.as_chunks::<2>().0[..displacements].iter();
    LayerMap::new(header, heights, numbers.map(|pair| pair.each_ref().map(half)).collect()).unwrap()
}
