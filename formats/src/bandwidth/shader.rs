//! What a shader needs besides the textures of bandwidth maps: `formats/src/bandwidth/map.wgsl` and its uniform block.

use crate::arc_tangent::arc_tangent_wgsl;
use crate::bandwidth::{BandwidthKind, BandwidthMap};

/// The WGSL look-ups. It declares a uniform block and three textures in bind group 1; see the file.
pub const BANDWIDTH_WGSL: &str = concat!(include_str!("map.wgsl"), arc_tangent_wgsl!("bandwidth", "BANDWIDTH"));

/// The uniform block `BandwidthParameters` of the shader.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BandwidthParameters {
    /// What texels of the BRDF's map are multiplied by; 0 where there is none.
    pub brdf_scale: f32,
    /// The same of the environment.
    pub environment_scale: f32,
    /// The same of the texture.
    pub texture_scale: f32,
    /// Whether the texture repeats.
    pub texture_tiles: u32,
}

impl BandwidthParameters {
    /// Bytes of the block.
    pub const SIZE: usize = 16;

    /// The parameters of up to one map of each kind, in any order; of two maps of a kind the later one counts.
    pub fn new<'a>(maps: impl IntoIterator<Item = &'a BandwidthMap>) -> Self {
        let mut parameters = Self::default();
        for map in maps {
            match map.header().kind {
                BandwidthKind::Brdf => parameters.brdf_scale = map.scale(),
                BandwidthKind::Environment => parameters.environment_scale = map.scale(),
                BandwidthKind::Texture { tiles, .. } => {
                    parameters.texture_scale = map.scale();
                    parameters.texture_tiles = u32::from(tiles);
                }
            }
        }
        parameters
    }

    /// The block as the shader reads it: little-endian, fields in order.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let words = [
            self.brdf_scale.to_bits(),
            self.environment_scale.to_bits(),
            self.texture_scale.to_bits(),
            self.texture_tiles,
        ];
        let mut bytes = [0; Self::SIZE];
        for (target, word) in bytes.chunks_exact_mut(4).zip(words) {
            target.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}
