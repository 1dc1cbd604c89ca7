//! What a shader needs besides the textures of a flat BTF: `formats/src/flat_btf/decoder.wgsl` and its uniform block.

use crate::flat_btf::FlatBtfDecoder;

/// The WGSL decoder. It declares a uniform block, five textures and a sampler in bind group 1; see the file.
pub const FLAT_BTF_WGSL: &str = include_str!("decoder.wgsl");

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
}

impl FlatBtfParameters {
    /// Bytes of the block.
    pub const SIZE: usize = 32;

    /// The parameters of an asset.
    pub fn new(decoder: &FlatBtfDecoder, filter: IndirectionFilter) -> Self {
        let header = decoder.parts().indirection.header();
        Self {
            size: decoder.parts().diffuse.size(),
            reference_size: header.size,
            zenith_samples: header.zenith_samples,
            azimuth_samples: header.azimuth_samples,
            largest_angle: header.largest_angle,
            atlas_columns: decoder.atlas().columns(),
            hardware: u32::from(filter == IndirectionFilter::Hardware),
        }
    }

    /// The block as the shader reads it: little-endian, fields in order, 4 bytes of zero at the end.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let words = [
            self.size,
            self.reference_size,
            self.zenith_samples,
            self.azimuth_samples,
            self.largest_angle.to_bits(),
            self.atlas_columns,
            self.hardware,
        ];
        let mut bytes = [0; Self::SIZE];
        for (target, word) in bytes.chunks_exact_mut(4).zip(words) {
            target.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}
