//! Comparison of predicted variance with the variance of samples (figure 12, a and b, of Bagher et al. 2012).

use super::case::{Case, StudyMaterial};
use super::statistics::{Quantiles, correlation, ranks};
use brdfc_metrics::image::luminance;
use brdfc_render::environment_light::integrand;
use brdfc_render::lobe_sampler::{LobeSampler as _, MeasuredLobe, shift_of};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// Samples of each point.
const SAMPLES: usize = 256;

/// Predicted standard deviations of samples, compared with those of samples.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DeviationRow {
    /// Points that are not black or brighter than white.
    pub points: usize,
    /// Share of them whose ratio is within a factor 2 of the median ratio, 0 to 1. Only ratios between points count:
    /// the number of samples is proportional to the prediction.
    pub within_2: f64,
    /// Spearman's rank correlation, -1 to 1.
    pub rank_correlation: f64,
    /// Ratios of prediction and reference. A prediction is a bound of unknown tightness.
    pub ratios: Quantiles,
}

/// Standard deviation of a sample's luminance as displayed, up to a factor, for each pixel: `σ / √L`, as the display's
/// change is nearly proportional to `1 / √L`. 0 for pixels without a surface, that are black, or brighter than white.
pub fn sampled_deviations(case: &Case<'_>, material: &StudyMaterial<'_>, pixels: &[usize]) -> Vec<f32> {
    let environment = &case.adaptive.scene.environment;
    let of = |pixel: &usize| -> f32 {
        let (Some(part), Some(point)) = (case.buffer.part_at(*pixel), case.buffer.shading_point(*pixel)) else {
            return 0.0;
        };
        let reflectance = case.adaptive.materials[part].reflectance;
        let lobe = MeasuredLobe { distributions: &material.lookups.distributions, shift: shift_of(*pixel) };
        let (mut sum, mut squares) = (0.0, 0.0);
        for index in 0..SAMPLES {
            let (incoming, inverse_density) = lobe.sample(point.outgoing, index);
            if inverse_density > 0.0 {
                let value = integrand(&point, environment, reflectance, incoming);
                let sample = case.exposure * inverse_density * luminance(value.map(|c| c as f32));
                sum += sample;
                squares += sample * sample;
            }
        }
        let mean = sum / SAMPLES as f64;
        if mean <= 1e-6 || mean > 1.0 {
            return 0.0;
        }
        ((squares / SAMPLES as f64 - mean * mean).max(0.0) / mean).sqrt() as f32
    };
    pixels.par_iter().map(of).collect()
}

/// Compares predictions with [`sampled_deviations`] at the same pixels.
pub fn compared(predicted: &[f32], reference: &[f32]) -> DeviationRow {
    let both = predicted.iter().zip(reference).filter(|(p, r)| **p > 0.0 && **r > 0.0);
    let (predicted, reference): (Vec<f32>, Vec<f32>) = both.map(|(p, r)| (*p, *r)).unzip();
    let mut ratios: Vec<f64> = predicted.iter().zip(&reference).map(|(p, r)| f64::from(p / r)).collect();
    ratios.sort_by(f64::total_cmp);
    let quantiles = Quantiles::of(&ratios);
    let is_near = |ratio: &&f64| (0.5..=2.0).contains(&(**ratio / quantiles.median));
    DeviationRow {
        points: ratios.len(),
        within_2: ratios.iter().filter(is_near).count() as f64 / ratios.len().max(1) as f64,
        rank_correlation: correlation(&ranks(&predicted), &ranks(&reference)),
        ratios: quantiles,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptive::{Lighting, TruthSamples};
    use brdfc_core::address::parse_synth;
    use brdfc_render::adaptive::{Start, predict};
    use brdfc_render::scene::Frame;
    use brdfc_render::scenes::Builtin;

    #[test]
    fn a_common_factor_does_not_count() {
        let reference = [0.1, 0.4, 0.2, 0.0, 0.8];
        let row = compared(&reference.map(|r| 3.0 * r), &reference);
        assert_eq!((row.points, row.within_2), (4, 1.0));
        assert!((row.rank_correlation - 1.0).abs() < 1e-12 && (row.ratios.median - 3.0).abs() < 1e-6, "{row:?}");
        // The control: the same prediction everywhere.
        let row = compared(&[1.0; 5], &reference);
        assert!(row.within_2 < 1.0 && row.rank_correlation == 0.0, "{row:?}");
    }

    /// Samples that all see the same light vary only by the difference of their density from the lobe.
    #[test]
    fn variance_comes_from_the_light() {
        let source = parse_synth("synth:ggx?kd=0&f0=0.9&alpha=0.1").unwrap();
        let material = StudyMaterial::new("metal".to_owned(), source.as_ref()).unwrap();
        let sky = Builtin::Sphere.scene().environment;
        let mut uniform = sky.clone();
        uniform.pixels.fill([0.5; 3]);
        let frame = Frame { width: 48, height: 48, samples: 1 };
        let truth = TruthSamples::Fixed(64, Start::Shared);
        let all: Vec<usize> = (0..48 * 48).collect();
        let mean = |environment| {
            let lighting = Lighting::new(environment).unwrap();
            Case::with(&material, &Builtin::Sphere.scene(), &lighting, frame, truth, |case| {
                // Away from outlines, where samples below the horizon vary.
                let center = [24 * 48 + 24];
                let found = sampled_deviations(case, &material, &center)[0];
                let prediction = predict(&case.adaptive, case.frame, case.buffer, &case.settings());
                (found, compared(&prediction.deviation, &sampled_deviations(case, &material, &all)))
            })
        };
        let ((flat, _), (varied, row)) = (mean(uniform), mean(sky));
        assert!(flat < 0.5 * varied, "{flat} {varied}");
        assert!(row.points > 500 && row.rank_correlation > 0.3, "{row:?}");
    }
}
