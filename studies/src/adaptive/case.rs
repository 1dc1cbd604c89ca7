//! One material on one shape in one environment, with its ground truth.

use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::environment_map;
use brdfc_core::Source;
use brdfc_formats::FormatError;
use brdfc_metrics::image::{LinearImage, auto_exposure, signal_to_noise};
use brdfc_render::adaptive::{AdaptiveScene, DistantLight, Lookups, Settings, Start, ground_truth};
use brdfc_render::gbuffer::GBuffer;
use brdfc_render::scene::{Environment, Frame, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::SourceReflectance;

/// A material to study.
pub struct StudyMaterial<'a> {
    /// Name in reports.
    pub name: String,
    /// Source to draw: the measured values, not a pack.
    pub source: &'a dyn Source,
    pub(super) lookups: Lookups,
}

impl<'a> StudyMaterial<'a> {
    /// Makes map and samples of a material.
    ///
    /// # Errors
    /// Returns the errors of [`Lookups::new`].
    pub fn new(name: String, source: &'a dyn Source) -> Result<Self, FormatError> {
        Ok(Self { name, source, lookups: Lookups::new(source)? })
    }
}

/// An environment and its bandwidth map.
pub struct Lighting {
    /// The environment.
    pub environment: Environment,
    pub(super) light: DistantLight,
}

impl Lighting {
    /// Makes the map of an environment.
    ///
    /// # Errors
    /// Returns an error if the layout of maps rejects the environment.
    pub fn new(environment: Environment) -> Result<Self, FormatError> {
        let map = environment_map(&environment.pixels, environment.width, DEFAULT_EPSILON)?;
        let light = DistantLight::new(&environment, map);
        Ok(Self { environment, light })
    }
}

/// A case with all data for drawing it.
pub struct Case<'a> {
    /// Scene to draw.
    pub adaptive: AdaptiveScene<'a>,
    /// Size of the rendering.
    pub frame: Frame,
    /// Surface points, one per pixel.
    pub buffer: &'a GBuffer,
    /// The converged rendering.
    pub truth: LinearImage,
    /// PSNR of the ground truth, from its own standard error, dB.
    pub truth_psnr: f64,
    /// Factor from radiance to the display's range, at which the brightest 1 % of the ground truth clip.
    pub exposure: f64,
    /// Pixels that show a surface.
    pub surface: usize,
}

impl Case<'_> {
    /// Draws the ground truth of a material on a shape, with this number of samples per pixel, and passes the case to
    /// `run`.
    pub fn with<T>(
        material: &StudyMaterial<'_>,
        shape: Builtin,
        lighting: &Lighting,
        frame: Frame,
        (samples, start): (usize, Start),
        run: impl FnOnce(&Case<'_>) -> T,
    ) -> T {
        let scene = Scene { environment: lighting.environment.clone(), ..shape.scene() };
        let reflectance = SourceReflectance(material.source);
        let materials = vec![material.lookups.material(&reflectance); scene.parts.len()];
        let adaptive = AdaptiveScene { scene: &scene, light: &lighting.light, materials: &materials };
        let buffer = GBuffer::new(&scene, frame);
        let distributions = vec![&material.lookups.distributions; scene.parts.len()];
        let truth = ground_truth(&adaptive, frame, &buffer, &distributions, samples, start);
        let exposure = auto_exposure(&truth.image);
        let truth_psnr = truth.psnr(exposure).unwrap_or(f64::INFINITY);
        let truth = truth.image;
        let surface = (0..buffer.part.len()).filter(|pixel| buffer.part_at(*pixel).is_some()).count();
        run(&Case { adaptive, frame, buffer: &buffer, truth, truth_psnr, exposure, surface })
    }

    /// PSNR of a rendering against the ground truth, dB; infinite without a difference.
    pub fn psnr(&self, image: &LinearImage) -> f64 {
        signal_to_noise(image, &self.truth, self.exposure).psnr.unwrap_or(f64::INFINITY)
    }

    /// The default settings for this exposure.
    pub fn settings(&self) -> Settings {
        Settings { white: (1.0 / self.exposure) as f32, ..Settings::default() }
    }
}
