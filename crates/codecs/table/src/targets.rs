//! Targets of a fit: logarithms with perceptual weights.

use super::recipe::Aim;
use super::samples::Samples;
use brdfc_metrics::lab::{distance_squared, lab, lab_each};
use rayon::prelude::*;

/// Share of the samples whose largest channel is not brighter than white.
const WHITE: f32 = 0.98;
/// Weight of a relative error where it is invisible, so that ratios stay correct at grazing angles and in the dark.
pub const UNSEEN: f32 = 0.03;

/// Derivative of L* with respect to the logarithm at white.
const LIGHTNESS_OF_RATIO: f32 = 116.0 / 3.0;

/// Number of samples whose colours are computed at once.
const LANES: usize = 32;

/// Upper limit of weights; weights of materials are about 1.
const MAX_WEIGHT: f32 = 1e6;

/// Logarithms and weights of samples.
#[derive(Debug, Clone)]
pub struct Targets {
    /// Error measure of the fit.
    pub aim: Aim,
    /// True if all channels are equal.
    pub grey: bool,
    /// `μ`, mean over channels of the samples on a ball; 1 for black materials.
    pub mean: f32,
    /// Bias `ε` of the logarithm.
    pub bias: f32,
    /// Exposure of `f cos θi` for display: few samples on the ball exceed white.
    pub exposure: f32,
    /// `ln(f / μ + ε)`, without the contribution of a curve.
    pub logarithms: Vec<[f32; 3]>,
    /// Contribution of a curve to each logarithm; empty without a curve.
    taken: Vec<[f32; 3]>,
    /// Derivative with respect to the logarithm: of the lightness, as a share of white's (L* over 116), or of the
    /// value, as a share of the value.
    pub weights: Vec<[f32; 3]>,
    /// Displayed L\*a\*b\*.
    pub colours: Vec<[f32; 3]>,
    /// True for samples brighter than white.
    highlights: Vec<bool>,
}

impl Targets {
    /// Targets of samples for renderings.
    pub fn new(samples: &Samples, bias: f32, grey: bool) -> Self {
        Self::with_aim(samples, bias, grey, Aim::Renderings)
    }

    /// Targets of samples for an error measure.
    pub fn with_aim(samples: &Samples, bias: f32, grey: bool, aim: Aim) -> Self {
        let on_ball = || (0..samples.len()).filter(|k| Samples::is_on_ball(*k));
        let sum: f64 = on_ball().map(|k| samples.values[k].iter().map(|v| f64::from(*v)).sum::<f64>()).sum();
        let mean = (sum / (3 * on_ball().count().max(1)) as f64) as f32;
        // Materials that are almost black have the smallest mean of a pack.
        let mean = if sum > 0.0 { mean.max(f32::MIN_POSITIVE) } else { 1.0 };
        let mut shown: Vec<f32> =
            on_ball().map(|k| samples.values[k].iter().fold(0.0f32, |a, b| a.max(*b)) * samples.cosines[k]).collect();
        let at = ((shown.len().max(1) - 1) as f32 * WHITE) as usize;
        let white = if shown.is_empty() { 0.0 } else { *shown.select_nth_unstable_by(at, f32::total_cmp).1 };
        // Materials whose exposure would not be finite count as black.
        let exposure = if white.is_normal() && white > 0.0 { 1.0 / white } else { 1.0 };
        let weight = |value: f32, cosine: f32| {
            if aim == Aim::Ratios {
                return value / (value + mean * bias);
            }
            let shown = value * cosine * exposure;
            // Renderings clip at white, but highlights should retain their light: a ratio counts there as at white.
            let clipped = if shown < 1.0 { 1.0 } else { 1.0 / shown };
            let weight = lightness_slope(shown.min(1.0)) * (value + mean * bias) * cosine * exposure * clipped;
            // A spike raises the mean, and nothing next to it is exact; the limit keeps squares finite.
            weight.min(MAX_WEIGHT)
        };
        let pairs = || samples.values.par_iter().zip(&samples.cosines).with_min_len(4096);
        Self {
            logarithms: samples
                .values
                .par_iter()
                .with_min_len(4096)
                .map(|v| v.map(|v| (v / mean + bias).ln()))
                .collect(),
            weights: pairs().map(|(v, cosine)| v.map(|v| weight(v, *cosine))).collect(),
            colours: pairs().map(|(v, cosine)| lab(v.map(|v| v * cosine * exposure))).collect(),
            highlights: pairs().map(|(v, cosine)| v.iter().any(|v| v * cosine * exposure > 1.0)).collect(),
            taken: Vec::new(),
            aim,
            grey,
            mean,
            bias,
            exposure,
        }
    }

    /// Remaining targets after subtracting the contribution of a curve from the logarithms.
    #[must_use]
    pub fn without(&self, taken: Vec<[f32; 3]>) -> Self {
        let less = |(all, taken): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| all[c] - taken[c]);
        Self { logarithms: self.logarithms.iter().zip(&taken).map(less).collect(), taken, ..self.clone() }
    }

    /// Sum of errors of logarithms of samples, each at an incoming cosine: displayed ΔE, or the mean ratio, added in
    /// their order. Samples brighter than white add the difference of lightness that their ratio would make at white.
    /// Samples are identified by their numbers.
    pub fn sum_of_differences(&self, mut samples: impl Iterator<Item = (usize, [f32; 3], f32)>) -> f64 {
        let mut sum = 0.0;
        if self.aim == Aim::Ratios {
            for (k, logarithms, _) in samples {
                let of = |c: usize| self.weights[k][c] * (logarithms[c] - self.logarithms[k][c]).abs();
                sum += f64::from((0..3).map(of).sum::<f32>() / 3.0);
            }
            return sum;
        }
        let (mut numbers, mut shown) = ([0; LANES], [[0.0; LANES]; 3]);
        loop {
            let mut count = 0;
            for (lane, (k, logarithms, cosine)) in samples.by_ref().take(LANES).enumerate() {
                numbers[lane] = k;
                if self.highlights[k] {
                    let ratio: f32 = (0..3).map(|c| (logarithms[c] - self.logarithms[k][c]).abs()).sum();
                    sum += f64::from(LIGHTNESS_OF_RATIO / 3.0 * ratio);
                }
                (0..3).for_each(|c| shown[c][lane] = self.shown(k, c, logarithms[c], cosine));
                count += 1;
            }
            let [l, a, b] = lab_each(&shown);
            for lane in 0..count {
                let colour = [l[lane], a[lane], b[lane]];
                sum += f64::from(distance_squared(colour, self.colours[numbers[lane]]).sqrt());
            }
            if count < LANES {
                return sum;
            }
        }
    }

    /// Displayed channel of sample `k` at an incoming cosine, for this logarithm.
    fn shown(&self, k: usize, channel: usize, logarithm: f32, cosine: f32) -> f32 {
        let taken = self.taken.get(k).map_or(0.0, |taken| taken[channel]);
        self.mean * ((logarithm + taken).exp() - self.bias) * cosine * self.exposure
    }
}

/// Derivative of CIELAB's `f`, lightness over 116.
fn lightness_slope(t: f32) -> f32 {
    if t > 216.0 / 24389.0 { 1.0 / (3.0 * t.cbrt().powi(2)) } else { 24389.0 / 27.0 / 116.0 }
}
