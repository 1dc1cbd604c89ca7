//! The bandwidth buffer: for each pixel, the level of the pyramid at which it is shaded, and the number of samples
//! (sections 2.2, 2.3 and 3.1 of Bagher et al. 2012).

use super::scene::{AdaptiveScene, Settings};
use super::tile::{Estimates, estimates};
use crate::curvature::curvature;
use crate::gbuffer::GBuffer;
use crate::scene::{Camera, Frame};
use brdfc_formats::bandwidth::propagation::{
    largest_pixel_bandwidth, pixel_bandwidth, pyramid_level, sample_count, sample_scale,
};
use rayon::prelude::*;

/// Level of pixels that show no surface, which fit any level.
pub const ANY_LEVEL: i32 = i32::MAX;

/// Predictions for the pixels of a G-buffer, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Cycles per pixel of the rendering, equation 6; 0 without a surface.
    pub bandwidth: Vec<f32>,
    /// Visible standard deviation of a sample: the root of `V` of equation 7, see
    /// [`brdfc_formats::bandwidth::propagation::VarianceEstimate`], times the change of the display per relative error;
    /// 0 without a surface.
    pub deviation: Vec<f32>,
    /// Level of the pyramid, 0 the G-buffer's own resolution; [`ANY_LEVEL`] without a surface.
    pub level: Vec<i32>,
    /// Samples of the pixel if it is shaded; 0 without a surface.
    pub samples: Vec<u32>,
}

impl Prediction {
    /// Shades every surface pixel of a level of the pyramid with `samples` samples, and no others unless interpolation
    /// fails. Level 0 has all pixels, level 1 one of four.
    pub fn uniform(buffer: &GBuffer, level: i32, samples: u32) -> Self {
        let of = |pixel: usize| if buffer.part_at(pixel).is_some() { (level, samples) } else { (ANY_LEVEL, 0) };
        let (level, samples) = (0..buffer.part.len()).map(of).unzip();
        let zeros = vec![0.0; buffer.part.len()];
        Self { bandwidth: zeros.clone(), deviation: zeros, level, samples }
    }
}

/// Predicts every pixel of the buffer, which has `1 << antialiasing_levels` points per pixel and axis.
///
/// Each of `settings.directions` incident directions is drawn in proportion to the lobe, so that `L ρ cos θ` over the
/// density is proportional to `L`: neither the material nor the reflected light is evaluated. The tenth of the
/// directions that does not follow the lobe counts like the others. Neighbouring points share their results.
pub fn predict(scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, settings: &Settings) -> Prediction {
    let curvature = curvature(buffer);
    let Estimates { mean: angular, deviation, .. } = estimates(scene, buffer, &curvature, settings);
    let in_rendering = in_rendering(&scene.scene.camera, frame, settings);
    let is_surface = |pixel: &usize| buffer.part_at(*pixel).is_some();
    let covered = (0..deviation.len()).filter(is_surface).count();
    let sum: f64 = deviation.iter().map(|v| f64::from(*v)).sum();
    let scale = sample_scale((sum / covered.max(1) as f64) as f32, settings.samples);
    let coarsest = coarsest(buffer);
    let level = |pixel: usize| match is_surface(&pixel) {
        // Level 0 is the buffer's resolution, which with antialiasing is finer than the rendering's. Points with detail
        // beyond the pixel's limit still have the most, so the limit applies after the factor.
        true => (pyramid_level(in_rendering(settings.caution * angular[pixel]), coarsest)
            + settings.antialiasing_levels as i32)
            .clamp(0, coarsest),
        false => ANY_LEVEL,
    };
    let samples = |pixel: usize| match is_surface(&pixel) {
        true => sample_count(deviation[pixel], scale, settings.fewest, settings.most),
        false => 0,
    };
    let pixels = || (0..buffer.part.len()).into_par_iter();
    Prediction {
        level: pixels().map(level).collect(),
        samples: pixels().map(samples).collect(),
        bandwidth: angular.par_iter().map(|angular| in_rendering(*angular)).collect(),
        deviation,
    }
}

/// Maximum bandwidth of the directions of each pixel in cycles per pixel, instead of the mean of equation 5; 0 without a
/// surface. Figure 6 of Bagher et al. 2012 shows that it demands full resolution nearly everywhere.
pub fn maximum_bandwidth(scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, settings: &Settings) -> Vec<f32> {
    let maximum = estimates(scene, buffer, &curvature(buffer), settings).maximum;
    maximum.into_iter().map(in_rendering(&scene.scene.camera, frame, settings)).collect()
}

/// Equation 6: the bandwidth at a pixel of a rendering, from cycles per radian.
fn in_rendering(camera: &Camera, frame: Frame, settings: &Settings) -> impl Fn(f32) -> f32 + Sync + use<> {
    let field_of_view = field_of_view(camera, frame);
    let size = [frame.width as f32, frame.height as f32];
    let largest = largest_pixel_bandwidth(settings.antialiasing_levels);
    move |angular| pixel_bandwidth(angular, field_of_view, size, largest)
}

/// The coarsest level: log2 of the buffer's shorter side, rounded down.
pub fn coarsest(buffer: &GBuffer) -> i32 {
    coarsest_of(buffer.width, buffer.height)
}

/// The coarsest level of a buffer of this size.
pub fn coarsest_of(width: usize, height: usize) -> i32 {
    width.min(height).max(1).ilog2() as i32
}

/// Angles of view across and down, radians.
pub fn field_of_view(camera: &Camera, frame: Frame) -> [f32; 2] {
    camera.half_extent(frame.width, frame.height).map(|half| (2.0 * half.atan()) as f32)
}
