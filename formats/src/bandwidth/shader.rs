//! Shader side of bandwidth maps: `formats/src/bandwidth/map.wgsl` and its bindings.

use super::map::{BandwidthKind, BandwidthMap};
use crate::arc_tangent::arc_tangent_wgsl;
use crate::bindings::{Binding, Bindings, Texels};
use crate::container::{Extent, TexelFormat};
use crate::cursor::block_bytes;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("bandwidth", 1);

/// WGSL look-ups. They declare a uniform block and a texture for each kind of map in bind group 1; see the file.
pub const BANDWIDTH_WGSL: &str = concat!(include_str!("map.wgsl"), arc_tangent_wgsl!("bandwidth", "BANDWIDTH"));

impl BandwidthKind {
    /// Slot and names of the uniform block and the texture; the texture has the next slot.
    fn bindings(self) -> (u32, [&'static str; 2]) {
        match self {
            Self::Brdf => (29, ["bandwidth_brdf_parameters", "bandwidth_brdf_map"]),
            Self::Environment => (31, ["bandwidth_environment_parameters", "bandwidth_environment_map"]),
            Self::Texture { .. } => (33, ["bandwidth_texture_parameters", "bandwidth_texture_map"]),
        }
    }
}

impl BandwidthMap {
    /// Size of the uniform block, bytes.
    pub const UNIFORM_SIZE: usize = 16;

    /// The uniform block `BandwidthParameters`: little-endian fields in order, padded with 8 zero bytes.
    pub fn uniform(&self) -> [u8; Self::UNIFORM_SIZE] {
        let tiles = matches!(self.header().kind, BandwidthKind::Texture { tiles: true, .. });
        block_bytes([self.scale().to_bits(), u32::from(tiles)])
    }

    /// Bindings of this map's shader. The kinds of maps do not share slots.
    pub fn bindings(&self) -> Bindings<'_> {
        let (slot, [parameters, map]) = self.header().kind.bindings();
        let texels = Texels::new(TexelFormat::R16Float, Extent::D2(self.size()), self.texel_bytes());
        let all = [
            Binding::uniform(slot, parameters, self.uniform().to_vec()),
            Binding::texture(slot + 1, map, texels.of_file()),
        ];
        Bindings::new(DECODER.0, DECODER.1, all)
    }
}
