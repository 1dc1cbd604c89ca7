//! Shader side of flat BTFs: `formats/src/flat_btf/decoder.wgsl`, `vdim.wgsl` and others, and their uniform block.

use super::directions::SampledDirections;
use super::factored::shader::{FACTORED_WGSL, FactoredParameters};
use super::factored::{FactoredFlatBtf, RESIDUAL_FORMAT};
use super::layers::{LayerHeader, LayerMap};
use super::relief::{Relief, StoredReflectance};
use super::shadows::ShadowMap;
use super::vdim::{Vdim, VdimSamples};
use super::vdim_header::VdimHeader;
use crate::arc_tangent::arc_tangent_wgsl;
use crate::bindings::{Binding, Bindings, Texels};
use crate::container::{Extent, TexelFormat};
use crate::cursor::block_bytes;
use crate::direction_mesh::DIRECTION_MESH_WGSL;
use crate::flat_btf::FlatBtfDecoder;
use crate::flat_btf_trees::TREES_DECODER;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("flat-btf", 7);

/// WGSL of the rays through the layers of a relief. It declares a uniform block, two textures and a sampler in bind group 1;
/// see the file.
pub const FLAT_BTF_WGSL: &str = concat!(include_str!("../bindings/frame.wgsl"), include_str!("decoder.wgsl"));

/// WGSL of these rays alone, which follows the frame block.
pub(crate) const RELIEF_WGSL: &str = include_str!("decoder.wgsl");

/// WGSL of indirection maps.
pub(crate) const VDIM_WGSL: &str = concat!(include_str!("vdim.wgsl"), arc_tangent_wgsl!("flat_btf", "FLAT_BTF"));

/// WGSL of the point of the relief that a pixel shows.
pub(crate) const SIGHT_WGSL: &str = include_str!("sight.wgsl");

/// WGSL for drawing a flat BTF: [`FLAT_BTF_WGSL`], indirection maps, sampled shadows, factored values, interpolation of
/// views and lights, and `flat_btf_value`, which combines them.
pub fn flat_btf_value_wgsl() -> String {
    let (shadows, value) = (include_str!("shadows.wgsl"), include_str!("value.wgsl"));
    [FLAT_BTF_WGSL, VDIM_WGSL, SIGHT_WGSL, shadows, FACTORED_WGSL, DIRECTION_MESH_WGSL, value].join("\n")
}

/// The uniform block `FlatBtfParameters`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlatBtfParameters;

impl FlatBtfParameters {
    /// Size of the block, bytes.
    pub const SIZE: usize = 64;

    /// The block of an asset as the shader reads it: little-endian fields in order, padded with zeros.
    pub fn to_bytes(decoder: &FlatBtfDecoder) -> [u8; Self::SIZE] {
        let (steps, finer) = (decoder.steps(), decoder.finer().to_bits());
        match &decoder.parts().relief {
            Relief::Layers(layers) => {
                let header = layers.header();
                let [low, range] = [header.heights[0], header.range()].map(f32::to_bits);
                let LayerHeader { size, sheets, levels, .. } = *header;
                block_bytes([size, sheets, levels, steps.sight, steps.refine, steps.both, low, range, finer])
            }
            Relief::Vdim(map, _) => {
                let header = map.header();
                let VdimHeader { size, polar_angles, azimuth_rows, levels, lights, .. } = *header;
                let [angle, tangent] = [header.largest_angle, header.largest_tangent()].map(f32::to_bits);
                let (block, [low, high]) = match map.samples() {
                    VdimSamples::Halves(_) => (0, [0.0; 2]),
                    VdimSamples::Compact(samples) => (header.block, samples.range),
                };
                let [low, range] = [low, high - low].map(f32::to_bits);
                let views = [polar_angles, azimuth_rows, angle, lights, block, tangent];
                block_bytes([size, 0, levels, 0, 0, 0, low, range, finer].into_iter().chain(views))
            }
        }
    }
}

pub(super) const HEIGHTS: &str = "flat_btf_heights";
pub(super) const REFERENCE: &str = "flat_btf_reference";
pub(super) const INDIRECTION: &str = "flat_btf_vdim";
pub(super) const SHADOWS: &str = "flat_btf_shadows";
pub(super) const DISPLACEMENTS: &str = "flat_btf_displacements";
const WEIGHTS: &str = "factored_weights";
pub(super) const RESIDUAL: &str = "factored_residual";
pub(super) const BASIS: &str = "factored_basis";
pub(super) const TABLES: &str = "factored_tables";
pub(super) const DIRECTIONS: &str = "direction_mesh_words";
const SAMPLER: &str = "flat_btf_sampler";
const FACTORED_SAMPLER: &str = "factored_sampler";

impl FlatBtfDecoder {
    /// Bindings of the shader of its form of reflectance. Without `directions`, their texture is empty.
    pub fn bindings(&self, directions: Option<&SampledDirections>) -> Bindings<'_> {
        let parameters = FlatBtfParameters::to_bytes(self).to_vec();
        let mut all = vec![Binding::frame(), Binding::uniform(15, "flat_btf_parameters", parameters)];
        let (layers, map) = match &self.parts().relief {
            Relief::Layers(layers) => (layer_texels(layers), None),
            Relief::Vdim(map, _) => (compact_texels(map), Some(map)),
        };
        all.extend(layer_bindings(layers));
        all.extend(map_bindings(map));
        let (decoder, version) = match &self.parts().reflectance {
            StoredReflectance::Factors(factors) => {
                all.push(shadow_binding(self.parts().relief.shadows()));
                all.extend(factored_bindings(factors));
                all.push(direction_binding(directions));
                DECODER
            }
            StoredReflectance::Trees(trees) => {
                all.extend(trees.bindings());
                TREES_DECODER
            }
        };
        all.sort_by_key(|binding| binding.slot);
        Bindings::new(decoder, version, all)
    }
}

/// Heights and displacements of layers.
fn layer_texels(layers: &LayerMap) -> [Texels<'_>; 2] {
    let header = layers.header();
    let heights = Texels::new(header.height_format(), header.height_extent(), layers.height_bytes());
    let displacements = Texels::new(TexelFormat::Rg16Float, header.displacement_extent(), layers.displacement_bytes());
    [heights.with_levels(header.levels), displacements.with_levels(header.displacement_levels())]
}

/// Heights over the parameters and ranges of displacements of compact samples; empty for others.
fn compact_texels(map: &Vdim) -> [Texels<'_>; 2] {
    let header = map.header();
    match map.samples() {
        VdimSamples::Compact(samples) => {
            let heights = Texels::new(TexelFormat::R8Unorm, header.reference_extent(), &samples.heights[..]);
            let ranges = Texels::new(TexelFormat::Rg16Float, header.ranges_extent(), samples.range_bytes());
            [heights, ranges].map(|texels| texels.with_levels(header.levels))
        }
        VdimSamples::Halves(_) => [
            Texels::empty(TexelFormat::R8Unorm, Extent::D2([1; 2])),
            Texels::empty(TexelFormat::Rg16Float, Extent::D2Array([1; 3])),
        ],
    }
}

/// Bindings of heights and displacements.
fn layer_bindings([heights, displacements]: [Texels<'_>; 2]) -> [Binding<'_>; 3] {
    [
        Binding::texture(16, HEIGHTS, heights.sampled(SAMPLER)),
        Binding::texture(17, DISPLACEMENTS, displacements.sampled(SAMPLER)),
        Binding::sampler(18, SAMPLER, true),
    ]
}

/// Bindings of an indirection map.
fn map_bindings(map: Option<&Vdim>) -> [Binding<'_>; 2] {
    let (reference, packed) = match map {
        Some(map) => {
            let header = map.header();
            let reference = Texels::new(TexelFormat::Rg16Float, header.reference_extent(), map.reference_bytes());
            let format = match map.samples() {
                VdimSamples::Halves(_) => TexelFormat::Rgba16Float,
                VdimSamples::Compact(_) => TexelFormat::Rg8Unorm,
            };
            let packed = Texels::new(format, header.packed_extent(), map.packed_bytes());
            (reference.with_levels(header.levels), packed.with_levels(header.levels))
        }
        None => {
            let empty = |format| Texels::empty(format, Extent::D2([1; 2]));
            (empty(TexelFormat::Rg16Float), empty(TexelFormat::Rgba16Float))
        }
    };
    [Binding::texture(19, REFERENCE, reference), Binding::texture(20, INDIRECTION, packed.sampled(SAMPLER))]
}

/// Binding of sampled shadows.
fn shadow_binding(shadows: Option<&ShadowMap>) -> Binding<'_> {
    let texels = match shadows {
        Some(shadows) => {
            let extent = Extent::D2Array([shadows.size(), shadows.size(), shadows.lights().len() as u32]);
            Texels::new(TexelFormat::R8Unorm, extent, shadows.texels()).with_levels(shadows.levels())
        }
        None => Texels::empty(TexelFormat::R8Unorm, Extent::D2Array([1; 3])),
    };
    Binding::texture(21, SHADOWS, texels.sampled(SAMPLER))
}

/// Binding of the meshes of views and lights.
fn direction_binding(directions: Option<&SampledDirections>) -> Binding<'static> {
    let texels = match directions {
        Some(some) => Texels::new(TexelFormat::R32Uint, Extent::D2(some.extent()), bytes(&some.texels())),
        None => Texels::empty(TexelFormat::R32Uint, Extent::D2([1; 2])),
    };
    Binding::texture(28, DIRECTIONS, texels)
}

/// Additional bindings for factored values.
pub fn factored_bindings(asset: &FactoredFlatBtf) -> [Binding<'_>; 6] {
    let (header, weights) = (asset.header(), asset.weights());
    let layers = Extent::D2Array([header.size, header.size, weights.layers()]);
    let residual = match (asset.residual(), header.residual_extent()) {
        (Some(map), Some(extent)) => Texels::new(RESIDUAL_FORMAT, extent, map.texels()).with_levels(map.levels()),
        _ => Texels::empty(RESIDUAL_FORMAT, Extent::D2Array([1; 3])),
    };
    let weights = Texels::new(TexelFormat::Rgba8Unorm, layers, weights.texels()).with_levels(weights.levels());
    let basis = match header.groups {
        0 => Texels::empty(TexelFormat::Rgba32Uint, Extent::D2([1; 2])),
        _ => Texels::new(TexelFormat::Rgba32Uint, Extent::D2(header.basis_extent()), bytes(asset.basis().words())),
    };
    let tables = Texels::new(TexelFormat::Rgba16Float, header.tables_extent(), asset.basis().table_texels());
    [
        Binding::texture(22, TABLES, tables.sampled(FACTORED_SAMPLER)),
        Binding::uniform(23, "factored_parameters", FactoredParameters::to_bytes(asset)),
        Binding::texture(24, WEIGHTS, weights.sampled(FACTORED_SAMPLER).of_file()),
        Binding::texture(25, RESIDUAL, residual.sampled(FACTORED_SAMPLER)),
        Binding::texture(26, BASIS, basis),
        Binding::sampler(27, FACTORED_SAMPLER, true),
    ]
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
