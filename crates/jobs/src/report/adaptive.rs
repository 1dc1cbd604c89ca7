//! What adaptive shading took, and how wrong it looks.

use super::render::PartMaterial;
use brdfc_gpu::AdapterDescription;
use brdfc_metrics::image::{LinearImage, PIXELS_PER_DEGREE, flip, signal_to_noise};
use brdfc_render::adaptive::{LevelCount, Settings};
use schemars::JsonSchema;
use serde::Serialize;

/// One rendering, drawn adaptively and by the forward renderer, against the ground truth.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct AdaptiveVerification {
    /// Which scene.
    pub scene: String,
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Points per pixel: 1, 4 or 16.
    pub points: usize,
    /// Points that show a surface.
    pub surface_points: u64,
    /// Factor from radiance to the display's range [0, 1], for renderings and comparisons.
    pub exposure: f64,
    /// What drew.
    pub adapter: AdapterDescription,
    /// Parts of the scene with their materials.
    pub parts: Vec<PartMaterial>,
    /// Width and height of the environment.
    pub environment: [usize; 2],
    /// What was asked for.
    pub settings: AdaptiveSettings,
    /// What adaptive shading took.
    pub adaptive: Shading,
    /// Seconds that the bandwidth buffer takes, run on its own before.
    pub bandwidth_seconds: f64,
    /// What each level of the pyramid shaded, finest first.
    pub levels: Vec<LevelCount>,
    /// What forward shading took, with the same number of samples for every point.
    pub forward: Shading,
    /// Samples per point of the ground truth.
    pub truth_samples: usize,
    /// PSNR that the spread of the ground truth's own samples amounts to, dB: an upper bound of its error, which runs of
    /// samples overstate. Absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth_psnr: Option<f64>,
    /// Seconds that the ground truth took, on the CPU.
    pub truth_seconds: f64,
}

/// How adaptive shading was asked to spend; see [`Settings`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct AdaptiveSettings {
    /// `n_b`, incident directions that bandwidth is averaged over.
    pub directions: u32,
    /// Mean samples of a surface point if all were shaded.
    pub budget: f32,
    /// Factor on predicted bandwidths.
    pub caution: f32,
    /// Fewest samples of a shaded pixel.
    pub fewest: u32,
    /// Most samples of a shaded pixel.
    pub most: u32,
}

impl From<&Settings> for AdaptiveSettings {
    fn from(settings: &Settings) -> Self {
        let Settings { directions, samples, caution, fewest, most, .. } = *settings;
        Self { directions, budget: samples, caution, fewest, most }
    }
}

/// Cost and error of a rendering.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Shading {
    /// Samples of incident light.
    pub samples: u64,
    /// The same per point that shows a surface.
    pub samples_per_point: f64,
    /// Shaded pixels of all levels.
    pub shaded: u64,
    /// Seconds to shade, without the G-buffer.
    pub seconds: f64,
    /// Pixels that hold no number, in the rendering or in the ground truth; they are left out of the PSNR.
    pub invalid_pixels: usize,
    /// dB of PSNR against the ground truth, as a display shows both; absent if there is no difference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Mean FLIP against the ground truth over pixels that show a surface, 0 to 1.
    pub flip: f64,
}

impl Shading {
    /// Of a rendering of so many points, by its samples and shaded pixels, against the ground truth.
    pub fn new(
        image: &LinearImage,
        [samples, shaded]: [u64; 2],
        points: u64,
        seconds: f64,
        (truth, exposure): (&LinearImage, f64),
    ) -> Self {
        let error = signal_to_noise(image, truth, exposure);
        Self {
            samples,
            samples_per_point: samples as f64 / points.max(1) as f64,
            shaded,
            seconds,
            invalid_pixels: error.invalid_pixels,
            psnr: error.psnr,
            flip: flip(image, truth, exposure, PIXELS_PER_DEGREE).mean_on_surfaces,
        }
    }
}
