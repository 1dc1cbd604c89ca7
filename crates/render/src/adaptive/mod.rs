//! Adaptive shading: only where and as much as the predicted bandwidth asks for ("Interactive rendering of acquired
//! materials on dynamic geometry using bandwidth prediction", Bagher, Soler, Subr, Belcour and Holzschuch 2012, section 3).
//!
//! Light comes from the environment alone, without visibility. [`predict`] fills the bandwidth buffer, [`Pyramid`] makes
//! its levels, [`shade`] goes through them from coarse to fine; this file sequences them.

mod light;
mod lookups;
mod passes;
mod predict;
mod pyramid;
mod shading;
mod tile;
mod truth;
mod upsample;

pub use light::{DistantLight, LightLevel};
pub use lookups::Lookups;
pub use passes::{ShadedLevels, shade};
pub use predict::{ANY_LEVEL, Prediction, coarsest, coarsest_of, field_of_view, predict};
pub use pyramid::Pyramid;
pub use shading::{forward, shade_point};
pub use tile::MOST_DIRECTIONS;
pub use truth::{GroundTruth, Start, ground_truth};
pub use upsample::{Guide, LEAST_WEIGHT, parents, weight};

use super::gbuffer::GBuffer;
use super::scene::{Frame, Scene};
use super::shade::Reflectance;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_formats::importance::ImportancePack;
use brdfc_metrics::image::LinearImage;

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

/// A picture, and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptivePicture {
    /// The picture at the frame's size.
    pub image: LinearImage,
    /// What was predicted, at the resolution of the finest level.
    pub prediction: Prediction,
    /// What each level shaded, finest first.
    pub levels: Vec<LevelCount>,
}

/// What a level shaded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct LevelCount {
    /// Pixels of the level that show a surface and are not left to finer levels.
    pub pixels: u64,
    /// Of these, pixels that were shaded; the others took over what the coarser level has.
    pub shaded: u64,
    /// Samples of incident light.
    pub samples: u64,
}

impl AdaptivePicture {
    /// Samples of incident light over all levels.
    pub fn samples(&self) -> u64 {
        self.levels.iter().map(|level| level.samples).sum()
    }

    /// Shaded pixels over all levels.
    pub fn shaded(&self) -> u64 {
        self.levels.iter().map(|level| level.shaded).sum()
    }
}

/// Draws a scene: predicts, then shades from coarse to fine, and takes the mean over the samples of each pixel.
///
/// `buffer` is the scene's G-buffer with `1 << settings.antialiasing_levels` points per pixel and axis.
///
/// # Panics
/// If the buffer is of another size, or there are fewer materials than parts.
pub fn draw(scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, settings: &Settings) -> AdaptivePicture {
    let sub = 1usize << settings.antialiasing_levels;
    assert_eq!((buffer.width, buffer.height), (frame.width * sub, frame.height * sub), "the buffer of this frame");
    assert!(scene.materials.len() >= scene.scene.parts.len(), "one material for each part");
    let prediction = predict(scene, frame, buffer, settings);
    let ShadedLevels { radiance, levels } = shade(scene, buffer, &prediction, settings.most);
    let image = resolve(scene.scene, frame, buffer, &radiance, sub);
    AdaptivePicture { image, prediction, levels }
}

/// Means over the points of each pixel.
pub fn resolve(scene: &Scene, frame: Frame, buffer: &GBuffer, radiance: &[[f32; 3]], sub: usize) -> LinearImage {
    let (mut pixels, mut coverage) = (Vec::new(), Vec::new());
    for pixel in 0..frame.width * frame.height {
        let (x, y) = (pixel % frame.width * sub, pixel / frame.width * sub);
        let (mut sum, mut covered) = ([0.0f32; 3], 0usize);
        for at in (0..sub * sub).map(|k| (y + k / sub) * buffer.width + x + k % sub) {
            if buffer.part_at(at).is_some() {
                covered += 1;
                (0..3).for_each(|k| sum[k] += radiance[at][k]);
            }
        }
        let share = (sub * sub) as f32;
        pixels.push(sum.map(|s| s / share));
        coverage.push(covered as f32 / share);
    }
    LinearImage { width: frame.width, height: frame.height, pixels, coverage, background: scene.background }
}

#[cfg(test)]
mod tests;
