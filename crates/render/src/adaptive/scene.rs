//! What adaptive shading is given: a scene with its look-ups, and how much may be spent on it.

use super::light::DistantLight;
use crate::scene::Scene;
use crate::shade::Reflectance;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_formats::importance::ImportancePack;

/// What a part is made of.
#[derive(Clone, Copy)]
pub struct AdaptiveMaterial<'a> {
    /// Its `f_r`.
    pub reflectance: &'a dyn Reflectance,
    /// Directions drawn in proportion to its lobe.
    pub samples: &'a ImportancePack,
    /// How fast its lobe varies.
    pub bandwidth: &'a BandwidthMap,
    /// Luminance of its albedo, roughly: how bright it is among the others.
    pub albedo: f32,
}

/// A scene with everything that adaptive shading looks up.
#[derive(Clone, Copy)]
pub struct AdaptiveScene<'a> {
    /// Parts, camera and environment; point lights and mirrors are not looked at.
    pub scene: &'a Scene,
    /// The environment, as predictions look it up.
    pub light: &'a DistantLight,
    /// One for each part.
    pub materials: &'a [AdaptiveMaterial<'a>],
}

/// How much is spent, and how carefully.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// `n_b`, incident directions that bandwidth is averaged over, rounded up to a multiple of 4. Points take a quarter of them
    /// each and share with up to 15 others, so that an average is over up to four times as many.
    pub directions: u32,
    /// Mean samples of a surface pixel before [`Settings::fewest`] and [`Settings::most`] hold.
    pub samples: f32,
    /// Fewest samples of a shaded pixel.
    pub fewest: u32,
    /// Most samples of a shaded pixel.
    pub most: u32,
    /// Radiance that the display shows as white.
    pub white: f32,
    /// Multiplies bandwidths before levels are chosen: 1 is Nyquist's rate for them, 2 twice as many pixels along each axis.
    /// Predicted bandwidths are mostly too high, by the maps (1.2 to 1.45 times those of waves, largest of three channels) and
    /// by the propagation (no signs, every direction in the plane of incidence), so less than 1 will do; weak detail on strong
    /// slow light is found too low.
    pub caution: f32,
    /// Levels finer than pixels: 0, 1 for 2 x 2 samples per pixel, 2 for 4 x 4.
    pub antialiasing_levels: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { directions: 16, samples: 64.0, fewest: 1, most: 1024, white: 1.0, caution: 0.5, antialiasing_levels: 0 }
    }
}
