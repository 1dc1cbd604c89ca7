//! The ground truth: converged in double precision, by the lobe and by the light (multiple importance sampling).

use super::{AdaptiveScene, resolve};
use crate::environment_light::reflected;
use crate::environment_sampler::{EnvironmentSampler, FramedEnvironmentSampler};
use crate::gbuffer::GBuffer;
use crate::lobe_sampler::{BalancedSampler, MeasuredLobe, shift_of};
use crate::scene::Frame;
use brdfc_importance::LobeDistributions;
use brdfc_metrics::image::{LinearImage, signal_to_noise};
use rayon::prelude::*;

/// Position of each point's first sample in the sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// A different position for each point, so that errors are noise.
    Scattered,
    /// As `Scattered`, but other positions for each number: renderings with different numbers have independent errors.
    Batch(usize),
    /// The same position for all points: errors vary no faster than the rendering, which keeps noise out of its
    /// spectrum.
    Shared,
}

/// A converged rendering, and its standard error.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundTruth {
    /// Rendering of the ground truth.
    pub image: LinearImage,
    /// Standard error of each channel, from the spread of 16 runs of each point's samples. It overestimates the error
    /// of scattered starts, whose runs fill each other's gaps, and the error of pixels with several points.
    pub error: LinearImage,
}

impl GroundTruth {
    /// PSNR of the rendering against itself with its standard error added, as a display shows both at this exposure,
    /// dB: a lower bound for the rendering. `None` if there is no error.
    pub fn psnr(&self, exposure: f64) -> Option<f64> {
        let mut other = self.image.clone();
        for (pixel, error) in other.pixels.iter_mut().zip(&self.error.pixels) {
            (0..3).for_each(|k| pixel[k] += error[k]);
        }
        signal_to_noise(&other, &self.image, exposure).psnr
    }
}

/// Renders with `samples` samples for each point of the buffer, half of them by the lobe of the material, half by the
/// light of the environment. There is one distribution for each part.
///
/// # Panics
/// If there are fewer distributions than parts.
pub fn ground_truth(
    scene: &AdaptiveScene<'_>,
    frame: Frame,
    buffer: &GBuffer,
    distributions: &[&LobeDistributions],
    samples: usize,
    start: Start,
) -> GroundTruth {
    let environment = EnvironmentSampler::new(&scene.scene.environment);
    let one = |pixel: usize| -> ([f32; 3], [f32; 3]) {
        let (Some(part), Some(point)) = (buffer.part_at(pixel), buffer.shading_point(pixel)) else {
            return Default::default();
        };
        let shift = shift_of(match start {
            Start::Scattered => pixel,
            Start::Batch(number) => pixel + number * buffer.part.len(),
            Start::Shared => 0,
        });
        let lobe = MeasuredLobe { distributions: distributions[part], shift };
        let light = FramedEnvironmentSampler { environment: &environment, point: &point, shift };
        let sampler = BalancedSampler { first: &lobe, second: &light };
        let material = scene.materials[part].reflectance;
        let estimate = reflected(&point, &scene.scene.environment, material, &sampler, samples);
        let texture = scene.texture_at(buffer, pixel);
        let tinted = |value: [f64; 3]| texture.tinted(value.map(|c| c as f32));
        (tinted(estimate.radiance), tinted(estimate.error))
    };
    let (radiance, error): (Vec<_>, Vec<_>) = (0..buffer.part.len()).into_par_iter().map(one).unzip();
    let image = |values: &[[f32; 3]]| resolve(scene.scene, frame, buffer, values, buffer.width / frame.width);
    GroundTruth { image: image(&radiance), error: image(&error) }
}
