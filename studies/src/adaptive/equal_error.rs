//! Number of samples that adaptive and forward shading need for the same error (section 5 of Bagher et al. 2012).

use super::case::{Case, Lighting, StudyMaterial};
use super::curve::{Point, needed};
use brdfc_metrics::image::{PIXELS_PER_DEGREE, flip};
use brdfc_render::adaptive::{AdaptiveRendering, Settings, Start, draw, forward, predict};
use brdfc_render::scene::Frame;
use brdfc_render::scenes::Builtin;
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Values of [`Settings::caution`] to try, in addition to the default.
pub const CAUTIONS: [f32; 3] = [0.25, 0.35, 1.0];
/// Maximum number of samples per pixel of forward shading, and maximum budget of adaptive shading.
const MAX_SAMPLES: u32 = 512;

/// One material on one shape.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EqualErrorRow {
    /// The input.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// Pixels that show a surface.
    pub surface_pixels: usize,
    /// Samples per pixel of the ground truth.
    pub truth_samples: usize,
    /// PSNR that corresponds to the spread of the ground truth's own samples, dB, an upper bound of its error; null if
    /// there is none.
    pub truth_psnr: Option<f64>,
    /// Target PSNR of both against the ground truth, dB.
    pub psnr: f64,
    /// Samples per pixel that forward shading needs; absent if no number from 1 to 512 has exactly this error.
    pub forward_samples: Option<f64>,
    /// Seconds of forward shading with this number of samples.
    pub forward_seconds: Option<f64>,
    /// Adaptive shading with the default caution; absent if no budget from 1 to 512 has exactly this error.
    pub adaptive: Option<AdaptivePoint>,
    /// Adaptive shading with the caution that needs the fewest samples.
    pub best: Option<AdaptivePoint>,
    /// Seconds for the bandwidth buffer.
    pub bandwidth_seconds: f64,
}

/// Adaptive shading at the target error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct AdaptivePoint {
    /// Factor on predicted bandwidths.
    pub caution: f32,
    /// Samples per surface pixel.
    pub samples: f64,
    /// Shaded pixels per surface pixel.
    pub shaded_share: f64,
    /// PSNR of the rendering drawn with this budget, dB.
    pub psnr: f64,
    /// Mean FLIP of the rendering on surfaces.
    pub flip: f64,
    /// Seconds to shade, including the bandwidth buffer.
    pub seconds: f64,
}

impl EqualErrorRow {
    /// Ratio of the numbers of samples of forward and adaptive shading.
    pub fn gain(&self, point: Option<AdaptivePoint>) -> Option<f64> {
        Some(self.forward_samples? / point?.samples)
    }

    /// Time of the bandwidth buffer as a share of the time of forward shading.
    pub fn bandwidth_share(&self) -> Option<f64> {
        Some(self.bandwidth_seconds / self.forward_seconds?)
    }
}

/// Returns one row for each target PSNR.
pub fn equal_error(
    material: &StudyMaterial<'_>,
    shape: Builtin,
    lighting: &Lighting,
    frame: Frame,
    truth_samples: usize,
    targets: &[f64],
) -> Vec<EqualErrorRow> {
    Case::with(material, shape, lighting, frame, (truth_samples, Start::Scattered), |case| {
        let highest = targets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let forward = forward_curve(case, highest);
        let default = Settings::default().caution;
        let cautions: Vec<f32> = std::iter::once(default).chain(CAUTIONS).collect();
        let curves: Vec<Vec<Point>> = cautions.iter().map(|c| adaptive_curve(case, *c, highest)).collect();
        let started = Instant::now();
        let _ = predict(&case.adaptive, case.frame, case.buffer, &case.settings());
        let bandwidth_seconds = started.elapsed().as_secs_f64();
        let row = |psnr: &f64| {
            let reference = needed(&forward, *psnr);
            let at = |index: usize| Some((cautions[index], needed(&curves[index], *psnr)?));
            let best = (0..cautions.len()).filter_map(at).min_by(|a, b| a.1.samples.total_cmp(&b.1.samples));
            EqualErrorRow {
                material: material.name.clone(),
                shape: shape.name().to_owned(),
                surface_pixels: case.surface,
                truth_samples,
                truth_psnr: Some(case.truth_psnr).filter(|psnr| psnr.is_finite()),
                psnr: *psnr,
                forward_samples: reference.map(|point| point.samples),
                forward_seconds: reference.map(|point| point.seconds),
                adaptive: at(0).map(|(caution, point)| adaptive_point(case, caution, point.asked)),
                best: best.map(|(caution, point)| adaptive_point(case, caution, point.asked)),
                bandwidth_seconds,
            }
        };
        targets.iter().map(row).collect()
    })
}

fn forward_curve(case: &Case<'_>, highest: f64) -> Vec<Point> {
    let mut curve = Vec::new();
    for count in (0..).map(|k| 1u32 << k).take_while(|count| *count <= MAX_SAMPLES) {
        let started = Instant::now();
        let image = forward(&case.adaptive, case.frame, case.buffer, count);
        let seconds = started.elapsed().as_secs_f64();
        let samples = f64::from(count);
        curve.push(Point { asked: samples, samples, psnr: case.psnr(&image), seconds });
        if curve.last().is_some_and(|point: &Point| point.psnr > highest) {
            break;
        }
    }
    curve
}

fn adaptive_curve(case: &Case<'_>, caution: f32, highest: f64) -> Vec<Point> {
    let mut curve: Vec<Point> = Vec::new();
    for asked in (0..).map(|k| 1u32 << k).take_while(|count| *count <= MAX_SAMPLES).map(f64::from) {
        let (_, point) = attempt(case, caution, asked);
        let last = curve.last().map_or(f64::NEG_INFINITY, |last| last.psnr);
        curve.push(point);
        // Errors that more samples do not reduce are missing detail.
        if point.psnr > highest || point.psnr < last + 0.1 {
            break;
        }
    }
    curve
}

/// A rendering with this budget, and its cost.
fn attempt(case: &Case<'_>, caution: f32, asked: f64) -> (AdaptiveRendering, Point) {
    let settings = Settings { samples: asked as f32, caution, ..case.settings() };
    let started = Instant::now();
    let rendering = draw(&case.adaptive, case.frame, case.buffer, &settings);
    let seconds = started.elapsed().as_secs_f64();
    let samples = rendering.samples() as f64 / case.surface.max(1) as f64;
    let point = Point { asked, samples, psnr: case.psnr(&rendering.image), seconds };
    (rendering, point)
}

fn adaptive_point(case: &Case<'_>, caution: f32, asked: f64) -> AdaptivePoint {
    let (rendering, Point { samples, psnr, seconds, .. }) = attempt(case, caution, asked);
    let shaded_share = rendering.shaded() as f64 / case.surface.max(1) as f64;
    let flip = flip(&rendering.image, &case.truth, case.exposure, PIXELS_PER_DEGREE).mean_on_surfaces;
    AdaptivePoint { caution, samples, shaded_share, psnr, flip, seconds }
}
