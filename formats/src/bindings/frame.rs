//! The block that changes with the frame, the same for all decoders.

use crate::cursor::block_bytes;
use crate::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};

/// Its slot.
pub const FRAME_SLOT: u32 = 0;

/// What declares the block; every decoder begins with it.
pub const FRAME_WGSL: &str = include_str!("frame.wgsl");

/// Several decoders as one source: what they all begin with stands once.
pub fn combined_wgsl<'a>(decoders: impl IntoIterator<Item = &'a str>) -> String {
    let mut source = FRAME_WGSL.to_owned();
    for decoder in decoders {
        source += decoder.strip_prefix(FRAME_WGSL).unwrap_or(decoder);
        source.push('\n');
    }
    source
}

/// The block `BrdfcFrame` of `frame.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameBlock {
    /// `α` of levels of detail, per unit of distance. Positive.
    pub distance_scale: f32,
    /// Whether samplers filter; else the shader does, with exact weights.
    pub sampler_filters: bool,
    /// Between which cells wavelet packs blend values.
    pub blend: Filter,
}

impl Default for FrameBlock {
    fn default() -> Self {
        Self { distance_scale: DEFAULT_DISTANCE_SCALE as f32, sampler_filters: true, blend: Filter::Bilinear }
    }
}

impl FrameBlock {
    /// Bytes of the block.
    pub const SIZE: usize = 16;

    /// The default with exact weights.
    pub fn exact() -> Self {
        Self { sampler_filters: false, ..Self::default() }
    }

    /// The block as shaders read it: little-endian, fields in order, 4 bytes of zero at the end.
    pub fn to_bytes(self) -> [u8; Self::SIZE] {
        let blend = match self.blend {
            Filter::Nearest => 0,
            Filter::Slices => 1,
            Filter::Bilinear => 2,
        };
        block_bytes([self.distance_scale.to_bits(), u32::from(self.sampler_filters), blend])
    }
}
