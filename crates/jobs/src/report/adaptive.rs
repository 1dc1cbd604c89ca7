//! Cost and error of adaptive shading.

use super::render::PartMaterial;
use brdfc_gpu::AdapterDescription;
use brdfc_metrics::image::{LinearImage, PIXELS_PER_DEGREE, flip, signal_to_noise};
use brdfc_render::adaptive::{LevelCount, RateCount, RateImage, Settings};
use schemars::JsonSchema;
use serde::Serialize;

/// One rendering, shaded adaptively and forward, compared with the ground truth.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct AdaptiveVerification {
    /// Name of the scene.
    pub scene: String,
    /// Pixels per row.
    pub width: usize,
    /// Number of rows of pixels.
    pub height: usize,
    /// Points per pixel: 1, 4 or 16.
    pub points: usize,
    /// Points that show a surface.
    pub surface_points: u64,
    /// Factor from radiance to the display's range [0, 1], for renderings and comparisons.
    pub exposure: f64,
    /// Graphics adapter that ran the shaders.
    pub adapter: AdapterDescription,
    /// Parts of the scene with their materials.
    pub parts: Vec<PartMaterial>,
    /// Width and height of the environment.
    pub environment: [usize; 2],
    /// Settings of adaptive shading.
    pub settings: AdaptiveSettings,
    /// Cost and error of adaptive shading.
    pub adaptive: Shading,
    /// Seconds of the bandwidth buffer, measured in a separate run.
    pub bandwidth_seconds: f64,
    /// Counts of each level of the pyramid, finest first.
    pub levels: Vec<LevelCount>,
    /// Rates for variable rate shading; absent without `--rates`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rates: Option<AdaptiveRates>,
    /// Textures of parts.
    pub textures: Vec<PartTextureReport>,
    /// Cost and error of adaptive shading as if textures had no bandwidth, with the same settings; absent without textures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_texture_bandwidth: Option<Shading>,
    /// Cost and error of forward shading with the same number of samples for every point.
    pub forward: Shading,
    /// Samples per point of the ground truth.
    pub truth_samples: usize,
    /// PSNR of the ground truth, dB: a lower bound from the spread between runs of its samples, which overstates the error.
    /// Absent if there is no error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth_psnr: Option<f64>,
    /// Seconds of the ground truth, on the CPU.
    pub truth_seconds: f64,
}

/// Settings of adaptive shading; see [`Settings`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct AdaptiveSettings {
    /// `n_b`, number of incident directions over which bandwidth is averaged.
    pub directions: u32,
    /// Mean samples of a surface point if all were shaded.
    pub budget: f32,
    /// Factor on predicted bandwidths.
    pub caution: f32,
    /// Minimum samples of a shaded pixel.
    pub fewest: u32,
    /// Maximum samples of a shaded pixel.
    pub most: u32,
}

impl From<&Settings> for AdaptiveSettings {
    fn from(settings: &Settings) -> Self {
        let Settings { directions, samples, caution, fewest, most, .. } = *settings;
        Self { directions, budget: samples, caution, fewest, most }
    }
}

/// The texture of a part.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PartTextureReport {
    /// Name of the part.
    pub part: String,
    /// Path of the image.
    pub texture: String,
    /// Width and height of the texture, metres.
    pub metres: [f32; 2],
    /// Repetitions per unit of u and v of the part.
    pub repeats: [f32; 2],
}

/// A rate image; see [`RateImage`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct AdaptiveRates {
    /// Pixels per side of a tile.
    pub tile: u32,
    /// Tiles per row.
    pub width: usize,
    /// Rows of tiles.
    pub height: usize,
    /// Counts of the rates 1 x 1, 2 x 2 and 4 x 4.
    pub counts: [RateCount; 3],
    /// PSNR of the ground truth with these rates against itself, dB, if each coarse pixel has the mean of its pixels: an upper
    /// bound for shaders, which run at the centre of a coarse pixel.
    /// Absent if there is no difference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
}

impl AdaptiveRates {
    /// Measures a rate image by the ground truth.
    pub fn new(image: &RateImage, truth: &LinearImage, exposure: f64) -> Self {
        let psnr = signal_to_noise(&image.coarse(truth), truth, exposure).psnr;
        Self { tile: image.tile, width: image.width, height: image.height, counts: image.counts, psnr }
    }

    /// Coarse pixels that show a surface over pixels that show one, 0 to 1.
    pub fn shaded_share(&self) -> f64 {
        let sum = |of: fn(&RateCount) -> u64| self.counts.iter().map(of).sum::<u64>();
        sum(|count| count.shaded) as f64 / sum(|count| count.pixels).max(1) as f64
    }
}

/// Cost and error of a rendering.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Shading {
    /// Samples of incident light.
    pub samples: u64,
    /// Samples of incident light per point that shows a surface.
    pub samples_per_point: f64,
    /// Shaded pixels of all levels.
    pub shaded: u64,
    /// Seconds to shade, without the G-buffer.
    pub seconds: f64,
    /// Pixels with NaN or infinite values in the rendering or in the ground truth; the PSNR excludes them.
    pub invalid_pixels: usize,
    /// PSNR of the displayed colours against the ground truth, dB; absent if there is no difference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Mean FLIP against the ground truth over pixels that show a surface, 0 to 1.
    pub flip: f64,
}

impl Shading {
    /// Measures a rendering against the ground truth. `points` is the number of points that show a surface.
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
