//! Renderings of surfaces that a prefiltered environment lights, by the lobes of their BRDF, and by the integral over all
//! directions.

use super::environment_light::reflected;
use super::environment_sampler::{EnvironmentSampler, FramedEnvironmentSampler};
use super::lobe_sampler::{BalancedSampler, MeasuredLobe};
use super::sample_means::sample_means;
use super::scene::{Frame, Scene};
use super::shade::{SourceReflectance, mirror_share};
use super::shading_point::ShadingPoint;
use super::trace::trace;
use brdfc_core::Source;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentPack};
use brdfc_formats::lobes::LobesPack;
use brdfc_importance::{ImportanceRecipe, LobeDistributions};
use brdfc_metrics::image::{ImageDifference, LinearImage, auto_exposure, compare_images};
use brdfc_metrics::sampling;

/// Directions of an integral for each pixel.
pub const DIRECTIONS: usize = 256;
/// Most directions for each pixel of [`converged_integral`].
const MOST_DIRECTIONS: usize = 16 * DIRECTIONS;
/// Noise of a converged integral, as a share of the difference that is measured against it.
const SHARE_OF_NOISE: f64 = 0.2;

/// A prefiltered environment, ready for look-ups on the CPU.
#[derive(Debug, Clone)]
pub struct PrefilteredLight {
    pack: EnvironmentPack,
    decoder: EnvironmentDecoder,
}

impl PrefilteredLight {
    /// Unpacks an environment.
    pub fn new(pack: EnvironmentPack) -> Self {
        let decoder = EnvironmentDecoder::new(&pack);
        Self { pack, decoder }
    }

    /// The environment as engines load it.
    pub fn pack(&self) -> &EnvironmentPack {
        &self.pack
    }
}

/// A material for the integral over all directions.
pub struct IntegralMaterial<'a> {
    reflectance: SourceReflectance<'a>,
    distributions: LobeDistributions,
}

impl<'a> IntegralMaterial<'a> {
    /// Tabulates the densities of the samples.
    ///
    /// # Errors
    /// Returns an error if the lobes of the source cannot be tabulated.
    pub fn new(source: &'a dyn Source) -> Result<Self, FormatError> {
        let distributions = LobeDistributions::new(source, &ImportanceRecipe::default())?;
        Ok(Self { reflectance: SourceReflectance(source), distributions })
    }
}

/// Draws a scene by the lobes of each part, in the same steps as `lobes_scene.wgsl`. Parts without lobes are black. Point lights
/// are ignored, nothing throws shadows, and of parts with a mirror only what the mirror lets through is drawn.
///
/// # Panics
/// If there are fewer lobes than parts.
pub fn draw_on_cpu(scene: &Scene, frame: Frame, light: &PrefilteredLight, lobes: &[Option<&LobesPack>]) -> LinearImage {
    draw(scene, frame, |_, part, point| {
        let Some(lobes) = lobes[part] else { return [0.0; 3] };
        let axes = [point.tangent, point.bitangent, point.normal].map(|axis| axis.map(|c| c as f32));
        lobes.radiance(&light.decoder, axes, point.outgoing.map(|c| c as f32)).map(f64::from)
    })
}

/// An integral over all directions, estimated with random directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Integral {
    /// Mean of two renderings with independent errors.
    pub image: LinearImage,
    /// One of the two. It differs from the mean by half the difference of the two, which has the variance of the mean's error.
    pub half: LinearImage,
}

impl Integral {
    /// Difference that noise alone causes between the image and the exact integral.
    pub fn noise(&self, exposure: f64) -> ImageDifference {
        compare_images(&self.half, &self.image, exposure)
    }
}

/// Draws the same by the integral over the scene's environment, with `directions` for each pixel, rounded up to 32 for each sample:
/// half of them by the lobe of the material, half by the light of the environment (Veach and Guibas 1995).
///
/// # Panics
/// If there are fewer materials than parts.
pub fn draw_integral(
    scene: &Scene,
    frame: Frame,
    materials: &[Option<&IntegralMaterial<'_>>],
    directions: usize,
) -> Integral {
    let environment = EnvironmentSampler::new(&scene.environment);
    let samples = directions.div_ceil(2 * frame.samples_per_pixel());
    // Shifts of the halves are coordinates of one sequence in four dimensions, so that their errors are independent. Two runs
    // of a sequence in two dimensions would differ by the same shift at all points.
    let half = |first: usize| {
        draw(scene, frame, |number, part, point| {
            let Some(IntegralMaterial { reflectance, distributions }) = materials[part] else { return [0.0; 3] };
            let shifts = sampling::point(number as u32);
            let shift = [shifts[first], shifts[first + 1]];
            let lobe = MeasuredLobe { distributions, shift };
            let light = FramedEnvironmentSampler { environment: &environment, point, shift };
            let sampler = BalancedSampler { first: &lobe, second: &light };
            reflected(point, &scene.environment, reflectance, &sampler, samples).radiance
        })
    };
    let (half, mut image) = (half(0), half(2));
    for (mean, other) in image.pixels.iter_mut().zip(&half.pixels) {
        (0..3).for_each(|k| mean[k] = 0.5 * (mean[k] + other[k]));
    }
    Integral { image, half }
}

/// Draws the integral with 256 directions for each pixel or, where needed, with 1,024 or 4,096: until noise is at most a fifth of
/// the mean ΔE of `compared` against it.
///
/// # Panics
/// If there are fewer materials than parts.
pub fn converged_integral(
    scene: &Scene,
    frame: Frame,
    materials: &[Option<&IntegralMaterial<'_>>],
    compared: &LinearImage,
) -> Integral {
    let mut directions = DIRECTIONS;
    loop {
        let integral = draw_integral(scene, frame, materials, directions);
        let exposure = auto_exposure(&integral.image);
        let difference = compare_images(compared, &integral.image, exposure).delta_e.mean;
        if directions >= MOST_DIRECTIONS || integral.noise(exposure).delta_e.mean <= SHARE_OF_NOISE * difference {
            return integral;
        }
        directions *= 4;
    }
}

/// Draws a scene with the radiance of each visible point, given with the numbers of its sample and of its part.
fn draw(scene: &Scene, frame: Frame, radiance: impl Fn(usize, usize, &ShadingPoint) -> Vector + Sync) -> LinearImage {
    let hits = trace(scene, frame).0;
    sample_means(scene, frame, |pixel, sample| {
        let number = pixel * frame.samples_per_pixel() + sample;
        let hit = hits[number].as_ref()?;
        let part = hit.part as usize;
        let point = ShadingPoint::new(&scene.parts[part], hit, scene.camera.eye);
        let below_mirror = 1.0 - mirror_share(&scene.parts[part].surface, point.outgoing[2]);
        Some(radiance(number, part, &point).map(|c| below_mirror * c))
    })
}
