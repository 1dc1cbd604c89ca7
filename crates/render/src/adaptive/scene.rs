//! Input of adaptive shading: a scene with its look-ups, and the settings of cost and quality.

use super::light::DistantLight;
use super::texture::{PartTexture, TexturePoint};
use crate::gbuffer::GBuffer;
use crate::scene::Scene;
use crate::shade::Reflectance;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_formats::importance::ImportancePack;

/// Material of a part.
#[derive(Clone, Copy)]
pub struct AdaptiveMaterial<'a> {
    /// BRDF of the material.
    pub reflectance: &'a dyn Reflectance,
    /// Directions drawn in proportion to its lobe.
    pub samples: &'a ImportancePack,
    /// Bandwidth of its lobe.
    pub bandwidth: &'a BandwidthMap,
    /// Approximate luminance of its albedo: its brightness compared with the other materials.
    pub albedo: f32,
    /// Texture by which its values are multiplied.
    pub texture: Option<PartTexture<'a>>,
}

/// A scene with all look-ups of adaptive shading.
#[derive(Clone, Copy)]
pub struct AdaptiveScene<'a> {
    /// Parts, camera and environment. Point lights and mirrors are ignored.
    pub scene: &'a Scene,
    /// The environment, as predictions look it up.
    pub light: &'a DistantLight,
    /// One material for each part.
    pub materials: &'a [AdaptiveMaterial<'a>],
}

impl AdaptiveScene<'_> {
    /// The texture at a point of the buffer; of one colour, white, if its part has none.
    pub fn texture_at(&self, buffer: &GBuffer, point: usize) -> TexturePoint {
        let texture = buffer.part_at(point).and_then(|part| self.materials[part].texture);
        texture.map_or(TexturePoint::PLAIN, |texture| texture.point(buffer, point))
    }
}

/// Cost and quality of adaptive shading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// `n_b`, the number of incident directions that bandwidth is averaged over, rounded up to a multiple of 4. Each
    /// point takes a quarter of them and shares with up to 15 others, so that an average is over up to four times as
    /// many.
    pub directions: u32,
    /// Mean samples of a surface pixel, before the limits [`Settings::fewest`] and [`Settings::most`] apply.
    pub samples: f32,
    /// Minimum number of samples of a shaded pixel.
    pub fewest: u32,
    /// Maximum number of samples of a shaded pixel.
    pub most: u32,
    /// Radiance that the display shows as white.
    pub white: f32,
    /// Factor on bandwidths before levels are chosen: 1 is their Nyquist rate, 2 twice as many pixels along each axis.
    /// Predicted bandwidths are mostly too high, because of the maps (1.2 to 1.45 times the bandwidths of waves, largest of
    /// three channels) and of the propagation (no signs, every direction in the plane of incidence), so less than 1 is
    /// sufficient. They are too low for weak detail on strong slow light.
    pub caution: f32,
    /// Levels finer than pixels: 0, 1 for 2 x 2 samples per pixel, 2 for 4 x 4.
    pub antialiasing_levels: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { directions: 16, samples: 64.0, fewest: 1, most: 1024, white: 1.0, caution: 0.5, antialiasing_levels: 0 }
    }
}
