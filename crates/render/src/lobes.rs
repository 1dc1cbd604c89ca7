//! Renderings of surfaces that a prefiltered environment lights, by the lobes of their BRDF, and by the integral over all
//! directions.

use super::environment_light::reflected;
use super::environment_sampler::{EnvironmentSampler, FramedEnvironmentSampler};
use super::lobe_sampler::{BalancedSampler, MeasuredLobe, shift_of};
use super::sample_means::sample_means;
use super::scene::{Environment, Frame, Scene};
use super::shade::Reflectance;
use super::shading_point::ShadingPoint;
use super::trace::trace;
use brdfc_formats::direction::Vector;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentPack};
use brdfc_formats::lobes::LobesPack;
use brdfc_importance::LobeDistributions;
use brdfc_metrics::image::LinearImage;

/// A material in a prefiltered environment.
#[derive(Debug, Clone)]
pub struct LobesMaterial {
    lobes: LobesPack,
    environment: EnvironmentPack,
    decoder: EnvironmentDecoder,
}

impl LobesMaterial {
    /// A material of any number of lobes.
    pub fn new(lobes: LobesPack, environment: EnvironmentPack) -> Self {
        let decoder = EnvironmentDecoder::new(&environment);
        Self { lobes, environment, decoder }
    }

    /// The lobes.
    pub fn lobes(&self) -> &LobesPack {
        &self.lobes
    }

    /// The environment.
    pub fn environment(&self) -> &EnvironmentPack {
        &self.environment
    }

    fn radiance(&self, point: &ShadingPoint) -> Vector {
        let axes = [point.tangent, point.bitangent, point.normal].map(|axis| axis.map(|c| c as f32));
        self.lobes.radiance(&self.decoder, axes, point.outgoing.map(|c| c as f32)).map(f64::from)
    }
}

/// Latitude-longitude image of the unfiltered radiance of a prefiltered environment, four faces wide.
pub fn unfiltered(environment: &EnvironmentPack) -> Environment {
    let decoder = EnvironmentDecoder::new(environment);
    let header = environment.header();
    let (width, height) = (4 * header.side as usize, 2 * header.side as usize);
    let sharpest = header.sharpest() as f32;
    Environment::of(width, height, |direction| decoder.radiance(direction.map(|c| c as f32), sharpest))
}

/// Draws a scene whose parts all have one material, in the same steps as `lobes_scene.wgsl`. Point lights and mirrors are
/// ignored, and nothing throws shadows.
pub fn draw_on_cpu(scene: &Scene, frame: Frame, material: &LobesMaterial) -> LinearImage {
    draw(scene, frame, |_, point| material.radiance(point))
}

/// Draws the same by the integral over the scene's environment, with `samples` directions for each sample of a pixel: half
/// of them by the lobe of the material, half by the light of the environment (Veach and Guibas 1995).
pub fn draw_integral(
    scene: &Scene,
    frame: Frame,
    material: &dyn Reflectance,
    distributions: &LobeDistributions,
    samples: usize,
) -> LinearImage {
    let environment = EnvironmentSampler::new(&scene.environment);
    draw(scene, frame, |number, point| {
        let shift = shift_of(number);
        let lobe = MeasuredLobe { distributions, shift };
        let light = FramedEnvironmentSampler { environment: &environment, point, shift };
        let sampler = BalancedSampler { first: &lobe, second: &light };
        reflected(point, &scene.environment, material, &sampler, samples).radiance
    })
}

/// Draws with the radiance of each visible point, given with the number of its sample.
fn draw(scene: &Scene, frame: Frame, radiance: impl Fn(usize, &ShadingPoint) -> Vector + Sync) -> LinearImage {
    let hits = trace(scene, frame).0;
    sample_means(scene, frame, |pixel, sample| {
        let number = pixel * frame.samples_per_pixel() + sample;
        let hit = hits[number].as_ref()?;
        let point = ShadingPoint::new(&scene.parts[hit.part as usize], hit, scene.camera.eye);
        Some(radiance(number, &point))
    })
}
