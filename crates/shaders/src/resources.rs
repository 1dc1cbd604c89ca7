//! What to bind for a pack, as bytes: the same in every language and for every graphics interface.

use brdfc_formats::bandwidth::shader::BandwidthParameters;
use brdfc_formats::bandwidth::{BandwidthKind, BandwidthMap};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf::factored::shader::{FactoredFilter, FactoredParameters};
use brdfc_formats::flat_btf::shader::{FlatBtfParameters, IndirectionFilter};
use brdfc_formats::flat_btf::{FlatBtfDecoder, Indirection, SampledDirections};
use brdfc_formats::importance::ImportancePack;
use brdfc_formats::pwt::shader::{PwtFilter, PwtParameters};
use brdfc_formats::pwt::{MAX_TEXTURES, PwtPack};
use brdfc_formats::table::TablePack;
use brdfc_formats::table::shader::TableBrdfParameters;
use brdfc_formats::wavelet::shader::{WaveletBrdfParameters, index_texels};
use brdfc_formats::wavelet::{Filter, WaveletPack};

/// One binding of group 1 and what belongs there.
#[derive(Debug, Clone, PartialEq)]
pub struct Resource {
    /// Its number.
    pub binding: u32,
    /// What is bound.
    pub contents: Contents,
}

/// What is bound.
#[derive(Debug, Clone, PartialEq)]
pub enum Contents {
    /// A uniform block.
    Uniform(Vec<u8>),
    /// A texture.
    Texture(Texels),
    /// A sampler: linear, also between mipmap levels.
    Sampler {
        /// Whether coordinates repeat; else they are clamped to the edge.
        repeats: bool,
    },
}

/// A texture, ready to be uploaded.
#[derive(Debug, Clone, PartialEq)]
pub struct Texels {
    /// How a texel is stored.
    pub format: TexelFormat,
    /// 2D, 2D array or 3D, and the number of texels along each axis.
    pub extent: Extent,
    /// Mipmap levels.
    pub levels: u32,
    /// Texels, x fastest, then y, then z or the layer, then the level from the finest; little-endian.
    pub bytes: Vec<u8>,
}

fn texture(format: TexelFormat, extent: Extent, levels: u32, bytes: impl Into<Vec<u8>>) -> Contents {
    Contents::Texture(Texels { format, extent, levels, bytes: bytes.into() })
}

/// One empty texel, of an extent of ones, where there is nothing to be bound.
pub fn no_texture(extent: Extent) -> Contents {
    texture(TexelFormat::R8Unorm, extent, 1, [0])
}

fn numbered(contents: impl IntoIterator<Item = (u32, Contents)>) -> Vec<Resource> {
    let mut all: Vec<Resource> =
        contents.into_iter().map(|(binding, contents)| Resource { binding, contents }).collect();
    all.sort_by_key(|resource| resource.binding);
    all
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn floats(numbers: impl IntoIterator<Item = f32>) -> Vec<u8> {
    numbers.into_iter().flat_map(f32::to_le_bytes).collect()
}

impl Texels {
    /// Texels of 16-bit integers as 32-bit floats of four components: what has such integers only as a feature, or not at all,
    /// as WebGL 2, takes these. All others as they are.
    #[must_use]
    pub fn widened(self) -> Self {
        let channels = match self.format {
            TexelFormat::R16Unorm => 1,
            TexelFormat::Rgba16Unorm => 4,
            _ => return self,
        };
        let number = |two: &[u8]| f32::from(u16::from_le_bytes([two[0], two[1]])) * (1.0 / 65535.0);
        let numbers: Vec<f32> = self.bytes.chunks_exact(2).map(number).collect();
        let four = |texel: &[f32]| [0, 1, 2, 3].map(|k: usize| texel[k.min(channels - 1)]);
        let bytes = floats(numbers.chunks_exact(channels).flat_map(four));
        Self { format: TexelFormat::Rgba32Float, bytes, ..self }
    }
}

/// Columns, rows, and slices or layers: 1 of a 2D texture.
pub fn size_of(extent: Extent) -> [u32; 3] {
    match extent {
        Extent::D2([width, height]) => [width, height, 1],
        Extent::D2Array(size) | Extent::D3(size) => size,
    }
}

/// What WebGPU calls a dimension.
pub fn dimension_name(extent: Extent) -> &'static str {
    match extent {
        Extent::D2(_) => "2d",
        Extent::D2Array(_) => "2d-array",
        Extent::D3(_) => "3d",
    }
}

/// What WebGPU calls a format.
pub fn format_name(format: TexelFormat) -> &'static str {
    match format {
        TexelFormat::R8Unorm => "r8unorm",
        TexelFormat::Rg8Unorm => "rg8unorm",
        TexelFormat::Rgba8Unorm => "rgba8unorm",
        TexelFormat::R16Unorm => "r16unorm",
        TexelFormat::R16Float => "r16float",
        TexelFormat::Rgba16Unorm => "rgba16unorm",
        TexelFormat::Rgba16Float => "rgba16float",
        TexelFormat::Rg32Float => "rg32float",
        TexelFormat::Rgba32Float => "rgba32float",
        TexelFormat::R32Uint => "r32uint",
        TexelFormat::Rgba32Uint => "rgba32uint",
        TexelFormat::Rgb9E5 => "rgb9e5ufloat",
        TexelFormat::Rgb10A2Unorm => "rgb10a2unorm",
    }
}

/// For a table pack; `distance_scale` is `α` of the level of detail.
pub fn table(pack: &TablePack, distance_scale: f32) -> Vec<Resource> {
    let curve = pack.curve().map(|curve| {
        let extent = Extent::D2([curve.nodes() as u32, curve.levels() + 1]);
        texture(curve.texel_format(), extent, 1, curve.texels())
    });
    numbered([
        (0, Contents::Uniform(TableBrdfParameters::new(pack, distance_scale).to_bytes().to_vec())),
        (1, texture(pack.header().texel_format(), Extent::D3(pack.extent()), 1, pack.texels())),
        (2, Contents::Sampler { repeats: false }),
        (3, curve.unwrap_or_else(|| no_texture(Extent::D2([1; 2])))),
    ])
}

/// For a wavelet pack; `distance_scale` is `α` of the level of detail.
pub fn wavelet(pack: &WaveletPack, filter: Filter, distance_scale: f32) -> Vec<Resource> {
    let index = floats(index_texels(pack).into_iter().flatten());
    let grid = pack.header.grid() as u32;
    numbered([
        (0, Contents::Uniform(WaveletBrdfParameters::new(pack, filter, distance_scale).to_bytes().to_vec())),
        (1, texture(pack.header.texel_format(), Extent::D3(pack.extent()), 1, &pack.texels[..])),
        (2, texture(TexelFormat::Rgba32Float, Extent::D2([grid; 2]), 1, index)),
        (3, Contents::Sampler { repeats: false }),
    ])
}

/// For a polynomial wavelet tree.
pub fn pwt(pack: &PwtPack, filter: PwtFilter) -> Vec<Resource> {
    let header = pack.header();
    let layers = |index: usize| match header.textures.get(index) {
        Some(part) => {
            let [width, height] = header.texture_extent(index);
            let extent = Extent::D2Array([width, height, part.layers()]);
            texture(part.texel_format(), extent, pack.levels_of(index), pack.texels(index))
        }
        None => no_texture(Extent::D2Array([1; 3])),
    };
    let textures = (1..).zip((0..MAX_TEXTURES).map(layers));
    let last = 1 + MAX_TEXTURES as u32;
    numbered(textures.chain([
        (0, Contents::Uniform(PwtParameters::to_bytes(pack, filter))),
        (last, Contents::Sampler { repeats: header.repeats }),
    ]))
}

/// For up to one bandwidth map of each kind.
pub fn bandwidth(maps: &[&BandwidthMap]) -> Vec<Resource> {
    let of = |is_kind: fn(&BandwidthKind) -> bool| match maps.iter().find(|map| is_kind(&map.header().kind)) {
        Some(map) => texture(TexelFormat::R16Float, Extent::D2(map.size()), 1, map.texel_bytes()),
        None => no_texture(Extent::D2([1; 2])),
    };
    numbered([
        (0, Contents::Uniform(BandwidthParameters::new(maps.iter().copied()).to_bytes().to_vec())),
        (1, of(|kind| matches!(kind, BandwidthKind::Brdf))),
        (2, of(|kind| matches!(kind, BandwidthKind::Environment))),
        (3, of(|kind| matches!(kind, BandwidthKind::Texture { .. }))),
    ])
}

/// For importance samples.
pub fn importance(pack: &ImportancePack) -> Vec<Resource> {
    let header = pack.header();
    let extent = Extent::D2([header.samples, header.rows()]);
    numbered([
        (0, Contents::Uniform(header.uniform().to_vec())),
        (1, texture(TexelFormat::Rgba32Float, extent, 1, floats(pack.texels().iter().flatten().copied()))),
    ])
}

/// The binding of a flat BTF's values of views: a layer for each.
pub const FLAT_BTF_VIEWS: u32 = 6;

/// For a flat BTF. The sampler filters where `hardware`, else the shader; `directions` is what blends its views and lights, which
/// only the light form can do without.
pub fn flat_btf(decoder: &FlatBtfDecoder, directions: Option<&SampledDirections>, hardware: bool) -> Vec<Resource> {
    let values = &decoder.parts().values;
    let views = values.views();
    let contents = if views.is_empty() {
        no_texture(Extent::D2Array([1; 3]))
    } else {
        let [width, height] = decoder.atlas().extent();
        let texels: Vec<u8> = views.iter().flat_map(|view| words(&decoder.atlas().layer(view))).collect();
        texture(TexelFormat::Rgb9E5, Extent::D2Array([width, height, views.len() as u32]), 1, texels)
    };
    let mut all = flat_btf_without_views(decoder, values.factored(), directions, hardware);
    all.insert(FLAT_BTF_VIEWS as usize, Resource { binding: FLAT_BTF_VIEWS, contents });
    all
}

/// All but [`FLAT_BTF_VIEWS`], which may be too large to be in memory twice. Of values there is what is `factored`, none for the
/// light form alone.
pub fn flat_btf_without_views(
    decoder: &FlatBtfDecoder,
    factored: Option<&FactoredFlatBtf>,
    directions: Option<&SampledDirections>,
    hardware: bool,
) -> Vec<Resource> {
    let parts = decoder.parts();
    let square = |size: u32| Extent::D2([size; 2]);
    let filter = if hardware { IndirectionFilter::Hardware } else { IndirectionFilter::Exact };
    let packed = Extent::D2(parts.indirection.header().extent());
    let (packed, ranges) = match &parts.indirection {
        Indirection::Samples(map) => {
            (texture(TexelFormat::Rgba16Float, packed, 1, map.texel_bytes()), no_texture(square(1)))
        }
        Indirection::Compact(map) => (
            texture(TexelFormat::Rg8Unorm, packed, 1, map.texel_bytes()),
            texture(TexelFormat::Rgba16Float, square(map.header().blocks.size), 1, map.range_bytes()),
        ),
    };
    let reference = floats(parts.reference.parameters().iter().flatten().copied());
    let directions = match directions {
        Some(some) => texture(TexelFormat::R32Uint, Extent::D2(some.extent()), 1, words(&some.texels())),
        None => texture(TexelFormat::R32Uint, square(1), 1, [0; 4]),
    };
    let mut all = numbered([
        (0, Contents::Uniform(FlatBtfParameters::new(decoder, filter).to_bytes().to_vec())),
        (1, texture(TexelFormat::Rg32Float, square(parts.reference.size()), 1, reference)),
        (2, packed),
        (3, Contents::Sampler { repeats: false }),
        (4, texture(TexelFormat::Rgba16Float, square(parts.normal.size()), 1, parts.normal.texel_bytes())),
        (5, texture(TexelFormat::Rgb9E5, square(parts.diffuse.size()), 1, words(parts.diffuse.texels()))),
        (7, ranges),
    ]);
    all.extend(flat_btf_factors(factored, hardware));
    all.push(Resource { binding: 13, contents: directions });
    all
}

/// Bindings 8 to 12 of a flat BTF: what is factored of it.
pub fn flat_btf_factors(asset: Option<&FactoredFlatBtf>, hardware: bool) -> Vec<Resource> {
    let filter = if hardware { FactoredFilter::Hardware } else { FactoredFilter::Exact };
    let no_layers = || no_texture(Extent::D2Array([1; 3]));
    let own = match asset {
        Some(asset) => {
            let (header, weights) = (asset.header(), asset.weights());
            let layers = Extent::D2Array([header.size, header.size, weights.layers()]);
            let shadow = asset.shadow().map(|map| {
                let extent = Extent::D2Array([map.size(), map.size(), map.lights()]);
                texture(TexelFormat::R8Unorm, extent, map.levels(), map.texels())
            });
            let basis = Extent::D2(header.basis_extent());
            [
                (8, Contents::Uniform(FactoredParameters::to_bytes(asset, filter))),
                (9, texture(TexelFormat::Rgba8Unorm, layers, weights.levels(), weights.texels())),
                (10, shadow.unwrap_or_else(no_layers)),
                (11, texture(TexelFormat::Rgba32Uint, basis, 1, words(asset.basis().words()))),
            ]
        }
        None => [
            (8, Contents::Uniform(vec![0; FactoredParameters::SIZE])),
            (9, no_layers()),
            (10, no_layers()),
            (11, texture(TexelFormat::Rgba32Uint, Extent::D2([1; 2]), 1, [0; 16])),
        ],
    };
    numbered(own.into_iter().chain([(12, Contents::Sampler { repeats: true })]))
}
