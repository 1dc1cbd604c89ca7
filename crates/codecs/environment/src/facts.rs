//! Facts about prefiltered environments.

use brdfc_formats::environment::EnvironmentPack;

/// Facts about a prefiltered environment.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct EnvironmentFacts {
    /// Texels along each side of a face of the finest level.
    pub side: u32,
    /// Number of mipmap levels.
    pub levels: u32,
    /// Factor of texel values.
    pub scale: f32,
    /// Largest radiance of the finest level, W/(m² sr).
    pub largest: f32,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
}

impl EnvironmentFacts {
    /// Facts of a pack.
    pub fn new(pack: &EnvironmentPack) -> Self {
        let header = pack.header();
        let largest = pack.level(0).flatten().fold(0.0, f32::max);
        Self { side: header.side, levels: header.levels(), scale: header.scale, largest, gpu_bytes: pack.gpu_bytes() }
    }
}
