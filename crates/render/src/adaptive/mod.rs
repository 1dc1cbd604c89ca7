//! Adaptive shading: samples only where and as densely as the predicted bandwidth requires ("Interactive rendering of
//! acquired materials on dynamic geometry using bandwidth prediction", Bagher, Soler, Subr, Belcour and Holzschuch
//! 2012, section 3).
//!
//! Light comes from the environment alone, without visibility. [`predict`] fills the bandwidth buffer, [`Pyramid`]
//! makes its levels, and [`shade`] processes them from coarse to fine. This file calls them in order.

mod filtered;
mod light;
mod lookups;
mod passes;
mod predict;
mod pyramid;
mod rates;
pub(crate) mod repeats;
mod resolve;
mod scene;
mod shading;
mod texture;
mod tile;
mod truth;
mod upsample;

pub use filtered::{FilteredLight, shade_point_filtered};
pub use light::{DistantLight, LightLevel};
pub use lookups::Lookups;
pub use passes::{LevelCount, ShadedLevels, shade, shade_with};
pub use predict::{ANY_LEVEL, Prediction, coarsest, coarsest_of, field_of_view, maximum_bandwidth, predict};
pub use pyramid::Pyramid;
pub use rates::{RATE_TILES, RateCount, RateImage};
pub use repeats::repeats;
pub use resolve::resolve;
pub use scene::{AdaptiveMaterial, AdaptiveScene, Settings};
pub use shading::{PointShader, forward, shade_point};
pub use texture::{PartTexture, TexturePoint};
pub use tile::MAX_DIRECTIONS;
pub use truth::{GroundTruth, Start, ground_truth};
pub use upsample::{MIN_WEIGHT, UpsamplingGuide, parents, weight};

use super::gbuffer::GBuffer;
use super::scene::Frame;
use brdfc_metrics::image::LinearImage;

/// A rendering, and its cost.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptiveRendering {
    /// The rendering at the frame's size.
    pub image: LinearImage,
    /// The prediction, at the resolution of the finest level.
    pub prediction: Prediction,
    /// Counts of each level, finest first.
    pub levels: Vec<LevelCount>,
}

impl AdaptiveRendering {
    /// Samples of incident light over all levels.
    pub fn samples(&self) -> u64 {
        self.levels.iter().map(|level| level.samples).sum()
    }

    /// Shaded pixels over all levels.
    pub fn shaded(&self) -> u64 {
        self.levels.iter().map(|level| level.shaded).sum()
    }
}

/// Draws a scene: predicts, shades from coarse to fine, and takes the mean over the samples of each pixel.
///
/// `buffer` is the scene's G-buffer with `1 << settings.antialiasing_levels` points per pixel and axis.
///
/// # Panics
/// If the buffer has another size, or if there are fewer materials than parts.
pub fn draw(scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, settings: &Settings) -> AdaptiveRendering {
    draw_with(scene, frame, buffer, settings, &|point, count| shade_point(scene, buffer, point, count))
}

/// Draws as [`draw`], but shades points by another function.
///
/// # Panics
/// As [`draw`].
pub fn draw_with(
    scene: &AdaptiveScene<'_>,
    frame: Frame,
    buffer: &GBuffer,
    settings: &Settings,
    shade_point: &PointShader<'_>,
) -> AdaptiveRendering {
    let sub = 1usize << settings.antialiasing_levels;
    assert_eq!((buffer.width, buffer.height), (frame.width * sub, frame.height * sub), "the buffer of this frame");
    assert!(scene.materials.len() >= scene.scene.parts.len(), "one material for each part");
    let prediction = predict(scene, frame, buffer, settings);
    let ShadedLevels { radiance, levels } = shade_with(buffer, &prediction, settings.most, shade_point);
    let image = resolve(scene.scene, frame, buffer, &radiance, sub);
    AdaptiveRendering { image, prediction, levels }
}

#[cfg(test)]
mod tests;
