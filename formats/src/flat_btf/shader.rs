//! What a shader needs besides the textures of a flat BTF: `formats/src/flat_btf/decoder.wgsl` and its uniform block.

use super::factored::shader::FACTORED_WGSL;
use crate::arc_tangent::arc_tangent_wgsl;
use crate::direction_mesh::DIRECTION_MESH_WGSL;
use crate::flat_btf::{FlatBtfDecoder, FlatValues, Indirection};

/// The WGSL decoder. It declares a uniform block, six textures and a sampler in bind group 1; see the file.
pub const FLAT_BTF_WGSL: &str = concat!(include_str!("decoder.wgsl"), arc_tangent_wgsl!("flat_btf", "FLAT_BTF"));

/// All that a flat BTF of any form is drawn by: [`FLAT_BTF_WGSL`], the factored values, the weights of views and lights, and
/// `flat_btf_value`, which puts them together.
pub fn flat_btf_value_wgsl() -> String {
    [FLAT_BTF_WGSL, FACTORED_WGSL, DIRECTION_MESH_WGSL, include_str!("value.wgsl")].join("\n")
}

/// How far a sampler's blend of view samples may be from exact weights, along each of the two angles, in units of the
/// difference of neighbouring samples.
///
/// `1/512` is the distance that the shader keeps from the border of a block; the rest is for samplers, whose weights have
/// 8 bits or fewer. Software drivers were measured at `1/512` in all.
pub const FLAT_BTF_FILTER_PRECISION: f32 = 1.0 / 128.0;

/// Who blends the view samples of the indirection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IndirectionFilter {
    /// The shader, with exact weights: the same bits as the CPU decoder where arithmetic is correctly rounded.
    Exact,
    /// The texture unit: one fetch.
    Hardware,
}

/// The uniform block `FlatBtfParameters` of the shader.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfParameters {
    /// `T`, texels of the flat BTF per side.
    pub size: u32,
    /// `M`, texels of the reference plane per side.
    pub reference_size: u32,
    /// `Z`, samples of the polar angle.
    pub zenith_samples: u32,
    /// `A`, samples of the azimuth.
    pub azimuth_samples: u32,
    /// `φ_max`, radians.
    pub largest_angle: f32,
    /// Lights in a row of the atlas; 0 without views.
    pub atlas_columns: u32,
    /// Who blends the indirection: 0 the shader, 1 the sampler.
    pub hardware: u32,
    /// `N`, blocks of displacements per side; 0 where there is an indirection map.
    pub blocks: u32,
    /// Tangent of the largest polar angle of displacements.
    pub largest_tangent: f32,
    /// What there is of views and lights: 0 nothing, 1 all values, 2 factored ones.
    pub values: u32,
}

impl FlatBtfParameters {
    /// Bytes of the block.
    pub const SIZE: usize = 48;

    /// The parameters of an asset.
    pub fn new(decoder: &FlatBtfDecoder, filter: IndirectionFilter) -> Self {
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
            hardware: u32::from(filter == IndirectionFilter::Hardware),
            blocks,
            largest_tangent,
            values: match decoder.parts().values {
                FlatValues::None => 0,
                FlatValues::Views(_) => 1,
                FlatValues::Factored(_) => 2,
            },
        }
    }

    /// The block as the shader reads it: little-endian, fields in order, 8 bytes of zero at the end.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let words = [
            self.size,
            self.reference_size,
            self.zenith_samples,
            self.azimuth_samples,
            self.largest_angle.to_bits(),
            self.atlas_columns,
            self.hardware,
            self.blocks,
            self.largest_tangent.to_bits(),
            self.values,
        ];
        let mut bytes = [0; Self::SIZE];
        for (target, word) in bytes.chunks_exact_mut(4).zip(words) {
            target.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}
