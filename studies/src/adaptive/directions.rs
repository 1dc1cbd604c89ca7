//! Number of incident directions that bandwidth is averaged over (figure 13 of Bagher et al. 2012).

use super::case::Case;
use brdfc_render::adaptive::{Settings, draw, predict};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Numbers of directions in the paper.
pub const DIRECTIONS: [u32; 4] = [16, 64, 256, 1024];

/// Result for one number of directions.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DirectionsRow {
    /// `n_b`.
    pub directions: u32,
    /// PSNR against the ground truth, dB; null without a difference.
    pub psnr: Option<f64>,
    /// Samples per surface pixel.
    pub samples: f64,
    /// Seconds of the bandwidth buffer.
    pub bandwidth_seconds: f64,
    /// Seconds of the whole rendering.
    pub seconds: f64,
}

/// Draws with each number of [`DIRECTIONS`], with as many samples as the first rendering.
///
/// Adjusts the budget until the numbers of samples agree within 1 %. Fewer directions estimate another mean variance,
/// which changes the number of samples for a budget, but not the quality for a number of samples.
pub fn directions_study(case: &Case<'_>, budget: f32) -> Vec<DirectionsRow> {
    let surface = case.surface.max(1) as f64;
    let mut first_samples = None;
    let mut one = |directions: u32| {
        let settings = Settings { directions, samples: budget, ..case.settings() };
        let started = Instant::now();
        let _ = predict(&case.adaptive, case.frame, case.buffer, &settings);
        let bandwidth_seconds = started.elapsed().as_secs_f64();
        let mut asked = f64::from(budget);
        let mut row = DirectionsRow { directions, psnr: None, samples: 0.0, bandwidth_seconds, seconds: 0.0 };
        for _ in 0..6 {
            let started = Instant::now();
            let settings = Settings { samples: asked as f32, ..settings };
            let rendering = draw(&case.adaptive, case.frame, case.buffer, &settings);
            row.seconds = started.elapsed().as_secs_f64();
            row.samples = rendering.samples() as f64 / surface;
            row.psnr = Some(case.psnr(&rendering.image)).filter(|psnr| psnr.is_finite());
            let target = *first_samples.get_or_insert(row.samples);
            if (row.samples / target - 1.0).abs() < 0.01 {
                break;
            }
            asked *= target / row.samples;
        }
        row
    };
    DIRECTIONS.iter().map(|directions| one(*directions)).collect()
}

/// Numbers of directions for one material.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct DirectionsStudy {
    /// The input.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// One row for each number.
    pub rows: Vec<DirectionsRow>,
}
