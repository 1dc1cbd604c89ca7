//! Shader side of flat BTFs: `formats/src/flat_btf/decoder.wgsl` and its uniform block.

use super::directions::SampledDirections;
use super::factored::FactoredFlatBtf;
use super::factored::shader::{FACTORED_WGSL, FactoredParameters};
use crate::arc_tangent::arc_tangent_wgsl;
use crate::bindings::{Binding, Bindings, Texels};
use crate::container::{Extent, TexelFormat};
use crate::cursor::block_bytes;
use crate::direction_mesh::DIRECTION_MESH_WGSL;
use crate::flat_btf::{FlatBtfDecoder, FlatValues, Indirection};

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("flat-btf", 2);

/// WGSL decoder. It declares a uniform block, six textures and a sampler in bind group 1; see the file.
pub const FLAT_BTF_WGSL: &str = concat!(
    include_str!("../bindings/frame.wgsl"),
    include_str!("decoder.wgsl"),
    arc_tangent_wgsl!("flat_btf", "FLAT_BTF")
);

/// WGSL for drawing a flat BTF of any form: [`FLAT_BTF_WGSL`], factored values, interpolation of views and lights, and
/// `flat_btf_value`, which combines them.
pub fn flat_btf_value_wgsl() -> String {
    [FLAT_BTF_WGSL, FACTORED_WGSL, DIRECTION_MESH_WGSL, include_str!("value.wgsl")].join("\n")
}

/// Maximum error of a sampler's blend of view samples against exact weights, along each of the two angles, in units of
/// the difference of neighbouring samples.
///
/// The shader keeps a distance of `1/512` from the border of a block; the rest allows for samplers with weights of 8
/// bits or fewer. Software drivers had a total error of `1/512`.
pub const FLAT_BTF_FILTER_PRECISION: f32 = 1.0 / 128.0;

/// Values of the uniform block `FlatBtfParameters`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfParameters {
    /// `T`, texels of the flat BTF per side.
    pub size: u32,
    /// `M`, texels of the reference plane per side.
    pub reference_size: u32,
    /// `Z`, number of polar-angle samples.
    pub zenith_samples: u32,
    /// `A`, number of azimuth samples.
    pub azimuth_samples: u32,
    /// `φ_max`, the largest polar angle of the view samples, radians.
    pub largest_angle: f32,
    /// Lights in a row of the atlas; 0 without views.
    pub atlas_columns: u32,
    /// `N`, blocks of displacements per side; 0 with an indirection map.
    pub blocks: u32,
    /// Tangent of the largest polar angle of displacements.
    pub largest_tangent: f32,
    /// Form of the values: 0 none, 1 uncompressed views, 2 factored.
    pub values: u32,
}

impl FlatBtfParameters {
    /// Size of the block, bytes.
    pub const SIZE: usize = 48;

    /// Parameters of an asset.
    pub fn new(decoder: &FlatBtfDecoder) -> Self {
        let header = decoder.parts().indirection.header();
        let (blocks, largest_tangent) = match &decoder.parts().indirection {
            Indirection::Samples(_) => (0, 0.0),
            Indirection::Compact(map) => (header.size, map.header().largest_tangent),
        };
        Self {
            size: decoder.parts().diffuse.size(),
            reference_size: decoder.parts().reference.size(),
            zenith_samples: header.zenith_samples,
            azimuth_samples: header.azimuth_samples,
            largest_angle: header.largest_angle,
            atlas_columns: decoder.atlas().columns(),
            blocks,
            largest_tangent,
            values: match decoder.parts().values {
                FlatValues::None => 0,
                FlatValues::Views(_) => 1,
                FlatValues::Factored(_) => 2,
            },
        }
    }

    /// The block as the shader reads it: little-endian fields in order, padded with zeros.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let words = [
            self.size,
            self.reference_size,
            self.zenith_samples,
            self.azimuth_samples,
            self.largest_angle.to_bits(),
            self.atlas_columns,
            0,
            self.blocks,
            self.largest_tangent.to_bits(),
            self.values,
        ];
        block_bytes(words)
    }
}

/// Slot of the uncompressed values, one layer per view. [`FlatBtfDecoder::bindings`] leaves it empty, because the
/// values may be too large to hold twice in memory.
pub const VALUES_SLOT: u32 = 21;

pub(super) const REFERENCE: &str = "flat_btf_reference";
pub(super) const PACKED: &str = "flat_btf_packed_indirection";
pub(super) const NORMAL: &str = "flat_btf_normal";
pub(super) const RANGES: &str = "flat_btf_ranges";
pub(super) const WEIGHTS: &str = "factored_weights";
pub(super) const SHADOW: &str = "factored_shadow";
pub(super) const BASIS: &str = "factored_basis";
pub(super) const DIRECTIONS: &str = "direction_mesh_words";
const SAMPLER: &str = "flat_btf_sampler";
const FACTORED_SAMPLER: &str = "factored_sampler";

impl FlatBtfDecoder {
    /// Bindings of the shader. Without `values`, factored textures are empty, and without `directions`, meshes are; the
    /// light form needs neither.
    pub fn bindings(&self, values: bool, directions: Option<&SampledDirections>) -> Bindings<'_> {
        let parts = self.parts();
        let square = |size: u32| Extent::D2([size; 2]);
        let packed = Extent::D2(parts.indirection.header().extent());
        let empty = |format| Texels::empty(format, square(1));
        let (packed, ranges) = match &parts.indirection {
            Indirection::Samples(map) => {
                (Texels::new(TexelFormat::Rgba16Float, packed, map.texel_bytes()), empty(TexelFormat::Rgba16Float))
            }
            Indirection::Compact(map) => (
                Texels::new(TexelFormat::Rg8Unorm, packed, map.texel_bytes()),
                Texels::new(TexelFormat::Rgba16Float, square(map.header().blocks.size), map.range_bytes()),
            ),
        };
        let reference: Vec<u8> = parts.reference.parameters().iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        let reference = Texels::new(TexelFormat::Rg32Float, square(parts.reference.size()), reference);
        let normal = Texels::new(TexelFormat::Rgba16Float, square(parts.normal.size()), parts.normal.texel_bytes());
        let diffuse = Texels::new(TexelFormat::Rgb9E5, square(parts.diffuse.size()), bytes(parts.diffuse.texels()));
        let first = [
            Binding::frame(),
            Binding::uniform(15, "flat_btf_parameters", FlatBtfParameters::new(self).to_bytes().to_vec()),
            Binding::texture(16, REFERENCE, reference),
            Binding::texture(17, PACKED, packed.sampled(SAMPLER)),
            Binding::sampler(18, SAMPLER, false),
            Binding::texture(19, NORMAL, normal),
            Binding::texture(20, "flat_btf_diffuse", diffuse.of_file()),
            Binding::texture(
                VALUES_SLOT,
                "flat_btf_values",
                Texels::empty(TexelFormat::Rgb9E5, Extent::D2Array([1; 3])),
            ),
            Binding::texture(22, RANGES, ranges),
        ];
        let factored = parts.values.factored().filter(|_| values);
        let directions = match directions {
            Some(some) => Texels::new(TexelFormat::R32Uint, Extent::D2(some.extent()), bytes(&some.texels())),
            None => empty(TexelFormat::R32Uint),
        };
        let last = Binding::texture(28, DIRECTIONS, directions);
        Bindings::new(DECODER.0, DECODER.1, first.into_iter().chain(factored_bindings(factored)).chain([last]))
    }
}

/// Additional bindings for factored values. Without an asset, textures have one texel.
pub fn factored_bindings(asset: Option<&FactoredFlatBtf>) -> [Binding<'_>; 5] {
    let no_layers = |format| Texels::empty(format, Extent::D2Array([1; 3]));
    let (parameters, weights, shadow, basis) = match asset {
        Some(asset) => {
            let (header, weights) = (asset.header(), asset.weights());
            let layers = Extent::D2Array([header.size, header.size, weights.layers()]);
            let shadow = asset.shadow().map(|map| {
                let extent = Extent::D2Array([map.size(), map.size(), map.lights()]);
                Texels::new(TexelFormat::R8Unorm, extent, map.texels()).with_levels(map.levels())
            });
            (
                FactoredParameters::to_bytes(asset),
                Texels::new(TexelFormat::Rgba8Unorm, layers, weights.texels()).with_levels(weights.levels()),
                shadow.unwrap_or_else(|| no_layers(TexelFormat::R8Unorm)),
                Texels::new(TexelFormat::Rgba32Uint, Extent::D2(header.basis_extent()), bytes(asset.basis().words())),
            )
        }
        None => (
            vec![0; FactoredParameters::SIZE],
            no_layers(TexelFormat::Rgba8Unorm),
            no_layers(TexelFormat::R8Unorm),
            Texels::empty(TexelFormat::Rgba32Uint, Extent::D2([1; 2])),
        ),
    };
    [
        Binding::uniform(23, "factored_parameters", parameters),
        Binding::texture(24, WEIGHTS, weights.sampled(FACTORED_SAMPLER)),
        Binding::texture(25, SHADOW, shadow.sampled(FACTORED_SAMPLER)),
        Binding::texture(26, BASIS, basis),
        Binding::sampler(27, FACTORED_SAMPLER, true),
    ]
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
