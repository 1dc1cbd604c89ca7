//! Shader side of wavelet packs: `formats/src/wavelet/decode.wgsl`, its uniform block and its index map.

use crate::arc_tangent::arc_tangent_wgsl;
use crate::crop::Window;
use crate::cursor::block_bytes;
use crate::wavelet::WaveletPack;

/// WGSL decoder. It declares a uniform block, two textures and a sampler in bind group 1; see the file.
pub const WAVELET_BRDF_WGSL: &str = concat!(
    include_str!("../bindings/frame.wgsl"),
    include_str!("decode.wgsl"),
    arc_tangent_wgsl!("wavelet_brdf", "WAVELET_BRDF")
);

/// Maximum error of hardware filtering of 8-bit slices against exact weights, in units of a texel's range [0, 1].
///
/// Samplers use weights of 8 bits or fewer; Vulkan requires at least 4. Software drivers had a maximum error of 6.7e-3.
pub const FILTER_PRECISION_8_BIT: f32 = 1.0 / 128.0;

/// Maximum error for 16-bit slices on drivers that filter them in 32-bit floats, as software drivers do.
pub const FILTER_PRECISION_16_BIT: f32 = 2e-6;

/// Values of the uniform block `WaveletBrdfParameters`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveletBrdfParameters {
    /// `N`: each hemisphere has `2^N x 2^N` cells.
    pub levels: u32,
    /// 0 tangent-pole, 1 half-difference.
    pub parameterisation: u32,
    /// 1 grey, 3 RGB.
    pub channels: u32,
    /// `μ` of the logarithm `ln(f / μ + ε)`, 1/sr.
    pub mean: f32,
    /// Bias `ε` of the logarithm `ln(f / μ + ε)`.
    pub bias: f32,
    /// Scale of slice 1, the scaling coefficient.
    pub scaling_scale: f32,
    /// Offset of slice 1.
    pub scaling_offset: f32,
    /// Depth of the texture, including the zero slice.
    pub slices: f32,
    /// Number of levels of detail with trees of their own.
    pub trees: u32,
    /// Rectangle of outer cells that the pack stores.
    pub window: Window,
}

impl WaveletBrdfParameters {
    /// Size of the block, bytes.
    pub const SIZE: usize = 48;

    /// Parameters of a pack.
    pub fn new(pack: &WaveletPack) -> Self {
        let header = &pack.header;
        Self {
            levels: header.levels,
            parameterisation: header.parameterisation.code(),
            channels: header.channels,
            mean: header.mean,
            bias: header.bias,
            scaling_scale: pack.scales[1].scale,
            scaling_offset: pack.scales[1].offset,
            slices: pack.slices() as f32,
            trees: header.trees(),
            window: pack.window(),
        }
    }

    /// The block as the shader reads it: little-endian fields in order, padded with zeros.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let Window { first: [column, row], size: [columns, rows] } = self.window;
        let window = column | row << 8 | columns << 16 | rows << 24;
        let words = [
            self.levels,
            self.parameterisation,
            0,
            self.channels,
            self.mean.to_bits(),
            self.bias.to_bits(),
            self.scaling_scale.to_bits(),
            self.scaling_offset.to_bits(),
            self.slices.to_bits(),
            0,
            self.trees,
            window,
        ];
        block_bytes(words)
    }
}

/// Index map as texels of four 32-bit floats, [`Header::index_extent`] of them. Coefficient `k` at `(k mod 2^N, k / 2^N)`
/// has its slice, scale and offset, and 0; texels after the last coefficient are 0.
///
/// [`Header::index_extent`]: super::Header::index_extent
pub(super) fn index_texels(pack: &WaveletPack) -> Vec<[f32; 4]> {
    let entry = |slice: &u16| {
        let scale = pack.scales[usize::from(*slice)];
        [f32::from(*slice), scale.scale, scale.offset, 0.0]
    };
    let [columns, rows] = pack.header.index_extent();
    let rest = (columns * rows) as usize - pack.index.len();
    pack.index.iter().map(entry).chain(std::iter::repeat_n([0.0; 4], rest)).collect()
}
