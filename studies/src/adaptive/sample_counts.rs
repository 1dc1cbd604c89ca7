//! Numbers of samples that follow the predicted spread of samples, or the spread of the first samples of neighbours, compared with
//! numbers that follow the measured spread.

use super::case::Case;
use brdfc_formats::direction::DirectionPair;
use brdfc_metrics::image::luminance;
use brdfc_render::adaptive::Prediction;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// Samples of each pixel for the measured spread.
const SAMPLES: u32 = 64;
/// First samples of each pixel, whose spread neighbours use.
const FIRST: u32 = 4;
/// Pixels around a pixel in each direction that are its neighbours.
const AROUND: usize = 2;
/// Spread below which a pixel counts as having this much.
const MIN_SPREAD: f32 = 1e-4;

/// Quality of numbers of samples in proportion to an estimate of the spread: the share of samples that would give the same
/// sum of squared errors if the numbers were in proportion to the measured spread; 0 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct SampleCounts {
    /// The same number of samples for each pixel.
    pub uniform: f64,
    /// Predicted spread.
    pub prediction: f64,
    /// Spread of the first four samples of neighbours. A pixel's own first samples would correlate with its value.
    pub first_samples: f64,
    /// Geometric mean of the predicted spread and that of first samples.
    pub both: f64,
}

/// Measures a case. The spread is the standard deviation of one sample in the display's encoded values.
pub(super) fn sample_counts(case: &Case<'_>, prediction: &Prediction) -> SampleCounts {
    let pixels: Vec<usize> = (0..case.buffer.part.len()).filter(|at| case.buffer.part_at(*at).is_some()).collect();
    let white = case.settings().white;
    let measured: Vec<f32> =
        pixels.par_iter().map(|at| spread(moments(case, *at, FIRST..FIRST + SAMPLES), white)).collect();
    let first: Vec<[f32; 2]> =
        (0..case.buffer.part.len()).into_par_iter().map(|at| moments(case, at, 0..FIRST)).collect();
    let near: Vec<f32> = pixels.iter().map(|at| spread(around(case, &first, *at), white)).collect();
    let predicted: Vec<f32> = pixels.iter().map(|at| prediction.deviation[*at]).collect();
    let both: Vec<f32> =
        near.iter().zip(&predicted).map(|(a, b)| (a.max(MIN_SPREAD) * b.max(MIN_SPREAD)).sqrt()).collect();
    SampleCounts {
        uniform: efficiency(&vec![1.0; pixels.len()], &measured),
        prediction: efficiency(&predicted, &measured),
        first_samples: efficiency(&near, &measured),
        both: efficiency(&both, &measured),
    }
}

/// `Σ σ² / N` is `(Σ σ)² / ΣN` for `N` in proportion to `σ`, and `Σd Σ(σ² / d) / ΣN` in proportion to `d`.
fn efficiency(estimate: &[f32], measured: &[f32]) -> f64 {
    let (mut sum, mut of_estimate, mut errors) = (0.0, 0.0, 0.0);
    for (estimate, measured) in estimate.iter().zip(measured) {
        let (estimate, measured) = (f64::from(estimate.max(MIN_SPREAD)), f64::from(*measured));
        sum += measured;
        of_estimate += estimate;
        errors += measured * measured / estimate;
    }
    if errors > 0.0 { sum * sum / (of_estimate * errors) } else { 1.0 }
}

/// Visible deviation of a sample, given mean and variance of its luminance.
fn spread([mean, variance]: [f32; 2], white: f32) -> f32 {
    let shown = mean / white;
    let response = if shown < 1.0 { shown.max(0.0).sqrt() } else { 1.0 / (shown * shown) };
    if mean > 0.0 { variance.sqrt() / mean * response } else { 0.0 }
}

/// Mean and variance of the luminance of some of a pixel's samples; 0 without a surface.
fn moments(case: &Case<'_>, at: usize, samples: std::ops::Range<u32>) -> [f32; 2] {
    let Some(part) = case.buffer.part_at(at) else { return [0.0; 2] };
    let material = &case.adaptive.materials[part];
    let frame = case.buffer.frame(at);
    let outgoing = frame.local(case.buffer.to_viewer[at]);
    let start = (at as u32).wrapping_mul(0x9e37_79b9);
    let (count, mut sum, mut squares) = (f64::from(samples.end - samples.start), 0.0, 0.0);
    for index in samples {
        let (incoming, inverse_density) = material.samples.sample(outgoing, start.wrapping_add(index));
        if inverse_density <= 0.0 {
            continue;
        }
        let pair = DirectionPair::new(incoming.map(f64::from), outgoing.map(f64::from));
        let f_r = material.reflectance.eval(pair, f64::from(case.buffer.distance[at]));
        let light = case.adaptive.scene.environment.at(frame.world(incoming).map(f64::from));
        let weight = f64::from(incoming[2] * inverse_density);
        let value = luminance([0, 1, 2].map(|k| (weight * f_r[k] * light[k]) as f32));
        sum += value;
        squares += value * value;
    }
    let mean = sum / count;
    [mean as f32, ((squares / count - mean * mean) * count / (count - 1.0)).max(0.0) as f32]
}

/// Mean of the moments of the pixels around one, without itself, on the same part.
fn around(case: &Case<'_>, moments: &[[f32; 2]], at: usize) -> [f32; 2] {
    let (width, height) = (case.frame.width, case.frame.height);
    let (x, y) = (at % width, at / width);
    let (mut sum, mut count) = ([0.0; 2], 0.0f32);
    for row in y.saturating_sub(AROUND)..(y + AROUND + 1).min(height) {
        for column in x.saturating_sub(AROUND)..(x + AROUND + 1).min(width) {
            let other = row * width + column;
            if other != at && case.buffer.part[other] == case.buffer.part[at] {
                (0..2).for_each(|k| sum[k] += moments[other][k]);
                count += 1.0;
            }
        }
    }
    sum.map(|sum| sum / count.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_in_proportion_to_the_spread_are_best() {
        let measured = [1.0f32, 2.0, 4.0, 0.5];
        assert!((efficiency(&measured.map(|s| 3.0 * s), &measured) - 1.0).abs() < 1e-6);
        // Uniform: (Σσ)² / (n Σσ²).
        let expected = 7.5 * 7.5 / (4.0 * 21.25);
        assert!((efficiency(&[0.2; 4], &measured) - expected).abs() < 1e-6);
        // The control: in inverse proportion it is worse than uniform.
        assert!(efficiency(&measured.map(|s| 1.0 / s), &measured) < 0.6 * expected);
        assert_eq!(efficiency(&[1.0], &[0.0]), 1.0);
    }
}
