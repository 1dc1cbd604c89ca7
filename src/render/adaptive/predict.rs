//! The bandwidth buffer: for each pixel, at which level of the pyramid it is shaded and by how many samples (sections 2.2,
//! 2.3 and 3.1 of Bagher et al. 2012).

use super::{AdaptiveScene, Settings};
use crate::render::curvature::curvature;
use crate::render::gbuffer::GBuffer;
use crate::render::scene::{Camera, Frame};
use brdfc_formats::bandwidth_propagation::{
    Bandwidth, BandwidthAverage, Surface, VarianceEstimate, largest_pixel_bandwidth, pixel_bandwidth, pyramid_level,
    sample_count, sample_scale,
};
use rayon::prelude::*;

/// Rec. 709.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// The level of pixels that show no surface: any level will do.
pub const ANY_LEVEL: i32 = i32::MAX;

/// What is predicted of the pixels of a G-buffer, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Cycles per pixel of the picture, equation 6; 0 where no surface is.
    pub bandwidth: Vec<f32>,
    /// `V` of equation 7 relative to the squared mean, see [`VarianceEstimate`]; 0 where no surface is.
    pub variance: Vec<f32>,
    /// Level of the pyramid, 0 the G-buffer's own resolution; [`ANY_LEVEL`] where no surface is.
    pub level: Vec<i32>,
    /// Samples of the pixel if it is shaded; 0 where no surface is.
    pub samples: Vec<u32>,
}

/// Predicts every pixel of the buffer, whose points stand `1 << antialiasing_levels` to a pixel and axis.
///
/// Each of `settings.directions` incident directions is drawn in proportion to the lobe, so that `L ρ cos θ` over the
/// density is proportional to `L`: neither the material nor the reflected light is evaluated.
pub fn predict(scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, settings: &Settings) -> Prediction {
    let curvature = curvature(buffer);
    let field_of_view = field_of_view(&scene.scene.camera, frame);
    let size = [frame.width as f32, frame.height as f32];
    let largest = largest_pixel_bandwidth(settings.antialiasing_levels);
    let one = |pixel: usize| -> (f32, f32) {
        let Some(part) = buffer.part_at(pixel) else { return (0.0, 0.0) };
        let (bandwidth, variance) = at(scene, buffer, pixel, part, curvature[pixel], settings);
        (pixel_bandwidth(bandwidth.angular, field_of_view, size, largest), variance)
    };
    let (bandwidth, variance): (Vec<f32>, Vec<f32>) = (0..buffer.part.len()).into_par_iter().map(one).unzip();
    let is_surface = |pixel: &usize| buffer.part_at(*pixel).is_some();
    let covered = (0..variance.len()).filter(is_surface).count();
    let sum: f64 = variance.iter().map(|v| f64::from(*v)).sum();
    let scale = settings.scale.unwrap_or_else(|| sample_scale((sum / covered.max(1) as f64) as f32, settings.samples));
    let coarsest = coarsest(buffer);
    let level = |pixel: usize| match is_surface(&pixel) {
        // Level 0 is the buffer's resolution, which is finer than the picture's with antialiasing.
        true => (pyramid_level(settings.caution * bandwidth[pixel], coarsest) + settings.antialiasing_levels as i32)
            .clamp(0, coarsest),
        false => ANY_LEVEL,
    };
    let samples = |pixel: usize| match is_surface(&pixel) {
        true => sample_count(variance[pixel], scale, settings.fewest, settings.most),
        false => 0,
    };
    let pixels = 0..buffer.part.len();
    Prediction {
        level: pixels.clone().map(level).collect(),
        samples: pixels.map(samples).collect(),
        bandwidth,
        variance,
    }
}

/// Bandwidth and relative variance at a surface point.
fn at(
    scene: &AdaptiveScene<'_>,
    buffer: &GBuffer,
    pixel: usize,
    part: usize,
    curvature: f32,
    settings: &Settings,
) -> (Bandwidth, f32) {
    let frame = buffer.frame(pixel);
    let material = &scene.materials[part];
    let outgoing = frame.local(buffer.to_viewer[pixel]);
    let (mut average, mut variance) = (BandwidthAverage::default(), VarianceEstimate::default());
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
        let contribution = (0..3).map(|k| LUMINANCE[k] * radiance[k] as f32).sum::<f32>().max(0.0);
        let surface = Surface { cos_incoming: incoming[2], cos_outgoing: outgoing[2], curvature, lobe, texture: 0.0 };
        let arrives = Bandwidth::distant(light).one_bounce(0.0, surface, buffer.distance[pixel]);
        average = average.add(arrives, contribution);
        variance = variance.add(light, lobe, contribution);
    }
    (average.mean(), variance.relative(settings.darkest))
}

/// The level whose only pixel covers the buffer's shorter side.
pub fn coarsest(buffer: &GBuffer) -> i32 {
    buffer.width.min(buffer.height).max(1).ilog2() as i32
}

/// Angles of view across and down, radians.
fn field_of_view(camera: &Camera, frame: Frame) -> [f32; 2] {
    camera.half_extent(frame.width, frame.height).map(|half| (2.0 * half.atan()) as f32)
}
