//! Pixels that must be shaded for an error if shaded pixels have no error of their own: the quality of levels alone.

use super::case::Case;
use brdfc_formats::bandwidth::propagation::{largest_pixel_bandwidth, pyramid_level};
use brdfc_render::adaptive::{ANY_LEVEL, Prediction, coarsest, resolve, shade_with};

/// Factors on bandwidths to try, each this many times the one before.
const STEP: f32 = 1.25;
/// Number of factors, from 1/100 on.
const STEPS: i32 = 40;

/// Share of surface pixels that are shaded, with the least factor on the bandwidths (cycles per pixel) that gives a PSNR of at
/// least `psnr` dB; interpolated between two factors. `None` if no factor does.
pub fn shaded_share(case: &Case<'_>, bandwidth: &[f32], psnr: f64) -> Option<f64> {
    let mut last: Option<(f64, f64)> = None;
    for step in 0..STEPS {
        let (share, found) = with_factor(case, bandwidth, 0.01 * STEP.powi(step));
        if found >= psnr {
            let between = |(before, low): (f64, f64)| {
                let t = if found.is_finite() { (psnr - low) / (found - low) } else { 1.0 };
                before * (share / before).powf(t)
            };
            return Some(last.map_or(share, between));
        }
        last = Some((share, found));
    }
    None
}

/// Share of shaded pixels, and PSNR.
fn with_factor(case: &Case<'_>, bandwidth: &[f32], factor: f32) -> (f64, f64) {
    let (buffer, coarsest) = (case.buffer, coarsest(case.buffer));
    let level = |pixel: usize| match buffer.part_at(pixel) {
        Some(_) => pyramid_level((factor * bandwidth[pixel]).min(largest_pixel_bandwidth(0)), coarsest),
        None => ANY_LEVEL,
    };
    let levels = (0..bandwidth.len()).map(level).collect();
    let prediction = Prediction { level: levels, ..Prediction::uniform(buffer, 0, 1) };
    let shaded = shade_with(buffer, &prediction, 1, &|pixel, _| case.truth.pixels[pixel]);
    let image = resolve(case.adaptive.scene, case.frame, buffer, &shaded.radiance, 1);
    let count: u64 = shaded.levels.iter().map(|level| level.shaded).sum();
    (count as f64 / case.surface.max(1) as f64, case.psnr(&image))
}
