//! Uniform block with per-frame values, shared by all decoders.

use crate::cursor::block_bytes;
use crate::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};

/// Slot of the block.
pub const FRAME_SLOT: u32 = 0;

/// Declaration of the block, at the start of every decoder.
pub const FRAME_WGSL: &str = include_str!("frame.wgsl");

/// Values of the block `BrdfcFrame` of `frame.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameBlock {
    /// `α` of the level of detail, per unit of distance. Positive.
    pub distance_scale: f32,
    /// True if samplers filter; false if the shader filters with exact weights.
    pub sampler_filters: bool,
    /// Cells that wavelet packs blend.
    pub blend: Filter,
}

impl Default for FrameBlock {
    fn default() -> Self {
        Self { distance_scale: DEFAULT_DISTANCE_SCALE as f32, sampler_filters: true, blend: Filter::Bilinear }
    }
}

impl FrameBlock {
    /// Size of the block, bytes.
    pub const SIZE: usize = 16;

    /// Default values with exact weights.
    pub fn exact() -> Self {
        Self { sampler_filters: false, ..Self::default() }
    }

    /// The block as shaders read it: little-endian fields in order, padded with 4 zero bytes.
    pub fn to_bytes(self) -> [u8; Self::SIZE] {
        let blend = match self.blend {
            Filter::Nearest => 0,
            Filter::Slices => 1,
            Filter::Bilinear => 2,
        };
        block_bytes([self.distance_scale.to_bits(), u32::from(self.sampler_filters), blend])
    }
}
