//! One material on one shape in one environment, with its ground truth.

use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::environment_map;
use brdfc_core::Source;
use brdfc_formats::FormatError;
use brdfc_metrics::image::{LinearImage, PIXELS_PER_DEGREE, auto_exposure, flip, signal_to_noise};
use brdfc_render::adaptive::{AdaptiveScene, DistantLight, Lookups, Settings, Start, ground_truth};
use brdfc_render::gbuffer::GBuffer;
use brdfc_render::scene::{Environment, Frame, Scene};
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
    /// Samples per pixel of the ground truth.
    pub truth_samples: usize,
    /// PSNR of the ground truth, from half the difference of its halves, or else from the spread of its samples, dB.
    pub truth_psnr: f64,
    /// Mean FLIP of a rendering with half of its samples; 0 for a fixed number of samples.
    pub truth_flip: f64,
    /// Factor from radiance to the display's range, at which the brightest 1 % of the ground truth clip.
    pub exposure: f64,
    /// Pixels that show a surface.
    pub surface: usize,
}

/// Samples per pixel of a ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TruthSamples {
    /// This many.
    Fixed(usize, Start),
    /// This many, in two halves whose difference gives the error; without a number 256, and four times as many if that
    /// PSNR is below 40 dB.
    Halves(Option<usize>),
}

/// Samples per pixel of a ground truth.
const FIRST: usize = 256;
/// PSNR of a ground truth below which it gets more samples, dB: a tenth of the squared error at 30 dB.
const ENOUGH: f64 = 40.0;
/// Factor of the number of samples then. Samples fill space evenly, so the error falls nearly as fast.
const MORE: usize = 4;
/// dB from the difference of two halves of a ground truth to the error of their mean, which is half as large.
const OF_MEAN: f64 = 6.02;

/// Mean of two ground truths with independent errors, with its PSNR and the FLIP of one of them. The error of the mean is
/// half their difference.
fn converged(halves: [LinearImage; 2]) -> (LinearImage, f64, f64) {
    let truth = mean(&halves[0], &halves[1]);
    let exposure = auto_exposure(&truth);
    let psnr = signal_to_noise(&halves[0], &halves[1], exposure).psnr.map_or(f64::INFINITY, |psnr| psnr + OF_MEAN);
    let flip = flip(&halves[0], &truth, exposure, PIXELS_PER_DEGREE).mean_on_surfaces;
    (truth, psnr, flip)
}

fn mean(a: &LinearImage, b: &LinearImage) -> LinearImage {
    let pixel = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
    LinearImage { pixels: a.pixels.iter().zip(&b.pixels).map(pixel).collect(), ..a.clone() }
}

impl Case<'_> {
    /// Draws the ground truth of a material on a shape and passes the case to `run`. The environment replaces the
    /// scene's.
    pub fn with<T>(
        material: &StudyMaterial<'_>,
        scene: &Scene,
        lighting: &Lighting,
        frame: Frame,
        samples: TruthSamples,
        run: impl FnOnce(&Case<'_>) -> T,
    ) -> T {
        let scene = Scene { environment: lighting.environment.clone(), ..scene.clone() };
        let reflectance = SourceReflectance(material.source);
        let materials = vec![material.lookups.material(&reflectance); scene.parts.len()];
        let adaptive = AdaptiveScene { scene: &scene, light: &lighting.light, materials: &materials };
        let buffer = GBuffer::new(&scene, frame);
        let distributions = vec![&material.lookups.distributions; scene.parts.len()];
        let truth =
            |samples: usize, start: Start| ground_truth(&adaptive, frame, &buffer, &distributions, samples, start);
        let (truth, truth_samples, truth_psnr, truth_flip) = match samples {
            TruthSamples::Fixed(samples, start) => {
                let truth = truth(samples, start);
                let psnr = truth.psnr(auto_exposure(&truth.image)).unwrap_or(f64::INFINITY);
                (truth.image, samples, psnr, 0.0)
            }
            TruthSamples::Halves(samples) => {
                let of = |samples: usize| {
                    let half = samples.div_ceil(2);
                    let (image, psnr, flip) = converged([0, 1].map(|number| truth(half, Start::Batch(number)).image));
                    (image, 2 * half, psnr, flip)
                };
                match samples {
                    Some(samples) => of(samples),
                    None => Some(of(FIRST)).filter(|first| first.2 >= ENOUGH).unwrap_or_else(|| of(MORE * FIRST)),
                }
            }
        };
        let exposure = auto_exposure(&truth);
        let surface = (0..buffer.part.len()).filter(|pixel| buffer.part_at(*pixel).is_some()).count();
        let buffer = &buffer;
        run(&Case { adaptive, frame, buffer, truth, truth_samples, truth_psnr, truth_flip, exposure, surface })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two halves with opposite errors have a mean without error, and one half has the reported error of a mean: half the
    /// difference of both.
    #[test]
    fn the_error_of_a_ground_truth_is_half_the_difference_of_its_halves() {
        let image = |error: f32| {
            let sign = |at: usize| if at.is_multiple_of(2) { 1.0 } else { -1.0 };
            // A few bright pixels, which determine the exposure.
            let pixel = |at: usize| if at < 8 { [1.0; 3] } else { [0.5 + sign(at) * error, 0.4, 0.3] };
            let pixels = (0..256).map(pixel).collect();
            LinearImage { pixels, coverage: vec![1.0; 256], ..LinearImage::black(16, 16) }
        };
        let (truth, psnr, flip) = converged([image(0.01), image(-0.01)]);
        assert!(truth.pixels[8..].iter().all(|pixel| (pixel[0] - 0.5).abs() < 1e-6));
        let of_half = signal_to_noise(&image(0.01), &truth, auto_exposure(&truth)).psnr.unwrap();
        assert!((psnr - of_half).abs() < 0.2 && flip > 0.0, "{psnr} {of_half} {flip}");
        // The control: halves that differ less have a smaller error.
        assert!(converged([image(0.001), image(-0.001)]).1 > psnr + 15.0);
    }
}
