//! Uniform block with per-frame values, shared by all decoders.

use crate::arc_tangent::arc_tangent_wgsl;
use crate::cursor::block_bytes;
use crate::direction_mesh::DIRECTION_MESH_WGSL;
use crate::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};

/// Slot of the block.
pub const FRAME_SLOT: u32 = 0;

/// Declaration of the block, at the start of every decoder.
pub const FRAME_WGSL: &str = include_str!("frame.wgsl");

/// Parts of several decoders: the mesh of directions of flat BTFs and trees, their look-ups, and the relief of flat BTFs.
const SHARED_PARTS: [&str; 6] = [
    DIRECTION_MESH_WGSL,
    include_str!("../pwt/pwt.wgsl"),
    include_str!("../flat_btf/decoder.wgsl"),
    include_str!("../flat_btf/vdim.wgsl"),
    arc_tangent_wgsl!("flat_btf", "FLAT_BTF"),
    include_str!("../flat_btf/sight.wgsl"),
];

/// Concatenates several decoders into one source, with shared declarations only once: the frame block, and parts of flat BTFs and
/// trees, which one bind group holds for one of them.
pub fn combined_wgsl<'a>(decoders: impl IntoIterator<Item = &'a str>) -> String {
    let mut source = FRAME_WGSL.to_owned();
    for decoder in decoders {
        let mut own = decoder.strip_prefix(FRAME_WGSL).unwrap_or(decoder).to_owned();
        for part in SHARED_PARTS.into_iter().filter(|part| source.contains(part)) {
            own = own.replace(part, "");
        }
        source += &own;
        source.push('\n');
    }
    source
}

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
