//! The bandwidth buffer: for each pixel, at which level of the pyramid it is shaded and by how many samples (sections 2.2,
//! 2.3 and 3.1 of Bagher et al. 2012).

use super::{AdaptiveScene, Settings};
use crate::metrics::image::luminance;
use crate::render::curvature::curvature;
use crate::render::gbuffer::GBuffer;
use crate::render::scene::{Camera, Frame};
use brdfc_formats::bandwidth_propagation::{
    Bandwidth, BandwidthAverage, Surface, VarianceEstimate, largest_pixel_bandwidth, pixel_bandwidth, pyramid_level,
    sample_count, sample_scale,
};
use rayon::prelude::*;

/// The level of pixels that show no surface: any level will do.
pub const ANY_LEVEL: i32 = i32::MAX;

/// What is predicted of the pixels of a G-buffer, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Cycles per pixel of the picture, equation 6; 0 where no surface is.
    pub bandwidth: Vec<f32>,
    /// Standard deviation of a sample as it shows: the root of `V` of equation 7, see [`VarianceEstimate`], times how much a
    /// relative error changes the display; 0 where no surface is.
    pub deviation: Vec<f32>,
    /// Level of the pyramid, 0 the G-buffer's own resolution; [`ANY_LEVEL`] where no surface is.
    pub level: Vec<i32>,
    /// Samples of the pixel if it is shaded; 0 where no surface is.
    pub samples: Vec<u32>,
}

/// Predicts every pixel of the buffer, whose points stand `1 << antialiasing_levels` to a pixel and axis.
///
/// Each of `settings.directions` incident directions is drawn in proportion to the lobe, so that `L ρ cos θ` over the
/// density is proportional to `L`: neither the material nor the reflected light is evaluated. The tenth of the directions that
/// does not follow the lobe counts like the others.
pub fn predict(scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, settings: &Settings) -> Prediction {
    let curvature = curvature(buffer);
    let field_of_view = field_of_view(&scene.scene.camera, frame);
    let size = [frame.width as f32, frame.height as f32];
    let largest = largest_pixel_bandwidth(settings.antialiasing_levels);
    let one = |pixel: usize| -> (f32, f32) {
        let Some(part) = buffer.part_at(pixel) else { return (0.0, 0.0) };
        let (bandwidth, variance, radiance) = at(scene, buffer, pixel, part, curvature[pixel], settings);
        let deviation = visible_deviation(variance, radiance, settings.white);
        (bandwidth.angular, deviation)
    };
    let in_picture = |angular: f32| pixel_bandwidth(angular, field_of_view, size, largest);
    let (angular, deviation): (Vec<f32>, Vec<f32>) = (0..buffer.part.len()).into_par_iter().map(one).unzip();
    let is_surface = |pixel: &usize| buffer.part_at(*pixel).is_some();
    let covered = (0..deviation.len()).filter(is_surface).count();
    let sum: f64 = deviation.iter().map(|v| f64::from(*v)).sum();
    let scale = sample_scale((sum / covered.max(1) as f64) as f32, settings.samples);
    let coarsest = coarsest(buffer);
    let level = |pixel: usize| match is_surface(&pixel) {
        // Level 0 is the buffer's resolution, which is finer than the picture's with antialiasing.
        // What no pixel can show still has the most detail of all, so the limit comes after the factor.
        true => (pyramid_level(in_picture(settings.caution * angular[pixel]), coarsest)
            + settings.antialiasing_levels as i32)
            .clamp(0, coarsest),
        false => ANY_LEVEL,
    };
    let samples = |pixel: usize| match is_surface(&pixel) {
        true => sample_count(deviation[pixel], scale, settings.fewest, settings.most),
        false => 0,
    };
    let pixels = 0..buffer.part.len();
    Prediction {
        level: pixels.clone().map(level).collect(),
        samples: pixels.map(samples).collect(),
        bandwidth: angular.into_iter().map(in_picture).collect(),
        deviation,
    }
}

/// What an error of the estimate does to the picture: standard deviation of one sample in units of the display's codes.
///
/// For `N_i` samples of pixels that show as displayed codes `s(L)`, the sum of squared errors `Σ (σ_i s'(L_i))² / N_i` is
/// least for a given sum of `N_i` where `N_i` is in proportion to `σ_i s'(L_i)`. `V` is `σ²` relative to the squared mean,
/// and `s` is nearly the power 1/2.2 up to white, beyond which nothing shows.
fn visible_deviation(variance: f32, luminance: f32, white: f32) -> f32 {
    let shown = luminance / white;
    let response = if shown < 1.0 { shown.sqrt() } else { 1.0 / (shown * shown) };
    variance.sqrt() * response
}

/// Bandwidth, relative variance and luminance at a surface point.
fn at(
    scene: &AdaptiveScene<'_>,
    buffer: &GBuffer,
    pixel: usize,
    part: usize,
    curvature: f32,
    settings: &Settings,
) -> (Bandwidth, f32, f32) {
    let frame = buffer.frame(pixel);
    let material = &scene.materials[part];
    let outgoing = frame.local(buffer.to_viewer[pixel]);
    let (mut average, mut variance) = (BandwidthAverage::default(), VarianceEstimate::default());
    let mut light_sum = 0.0f32;
    for index in 0..settings.directions {
        let (incoming, inverse_density) = material.samples.sample(outgoing, index);
        if inverse_density <= 0.0 {
            variance = variance.add(0.0, 0.0, 0.0);
            continue;
        }
        let direction = frame.world(incoming);
        let light = scene.environment_bandwidth.environment(direction);
        let lobe = material.bandwidth.brdf(incoming, outgoing);
        let radiance = scene.scene.environment.at(direction.map(f64::from));
        let contribution = (luminance(radiance.map(|c| c as f32)) as f32).max(0.0);
        let surface = Surface { cos_incoming: incoming[2], cos_outgoing: outgoing[2], curvature, lobe, texture: 0.0 };
        let arrives = Bandwidth::distant(light).one_bounce(0.0, surface, buffer.distance[pixel]);
        light_sum += contribution;
        average = average.add(arrives, contribution);
        variance = variance.add(light, lobe, contribution);
    }
    let luminance = material.albedo * light_sum / settings.directions.max(1) as f32;
    (average.mean(), variance.relative(0.0), luminance)
}

/// The coarsest level: log2 of the buffer's shorter side, rounded down.
pub fn coarsest(buffer: &GBuffer) -> i32 {
    coarsest_of(buffer.width, buffer.height)
}

/// The same of a buffer of this size.
pub fn coarsest_of(width: usize, height: usize) -> i32 {
    width.min(height).max(1).ilog2() as i32
}

/// Angles of view across and down, radians.
pub fn field_of_view(camera: &Camera, frame: Frame) -> [f32; 2] {
    camera.half_extent(frame.width, frame.height).map(|half| (2.0 * half.atan()) as f32)
}
