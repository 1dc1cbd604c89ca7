//! What a fit aims at: logarithms, and how much each of them shows.

use super::recipe::Aim;
use super::samples::Samples;
use brdfc_metrics::lab::{distance_squared, lab, lab_each};
use rayon::prelude::*;

/// Share of the samples whose largest channel is no brighter than white.
const WHITE: f32 = 0.98;
/// What a relative error counts where nothing is seen, so that ratios stay right at grazing angles and in the dark.
pub const UNSEEN: f32 = 0.03;

/// What a small difference of the logarithm changes of L* at white.
const LIGHTNESS_OF_RATIO: f32 = 116.0 / 3.0;

/// Samples whose colours are found at once.
const LANES: usize = 32;

/// Weights of materials are about 1.
const MAX_WEIGHT: f32 = 1e6;

/// Logarithms and weights of samples.
#[derive(Debug, Clone)]
pub struct Targets {
    /// What the fit is to be close in.
    pub aim: Aim,
    /// Whether all channels are the same.
    pub grey: bool,
    /// `μ`, mean over channels of the samples as on a ball; 1 for black materials.
    pub mean: f32,
    /// `ε`.
    pub bias: f32,
    /// What `f cos θi` is multiplied by to be shown: white is what few samples on the ball exceed.
    pub exposure: f32,
    /// `ln(f / μ + ε)`, without what a curve has of it.
    pub logarithms: Vec<[f32; 3]>,
    /// What a curve has of each logarithm; empty where there is none.
    taken: Vec<[f32; 3]>,
    /// What a small difference of the logarithm changes of the lightness, as a share of white's (L* over 116), or of the
    /// value, as a share of it.
    pub weights: Vec<[f32; 3]>,
    /// L\*a\*b\* as it is shown.
    pub colours: Vec<[f32; 3]>,
    /// Whether it is brighter than white.
    highlights: Vec<bool>,
}

impl Targets {
    /// Of samples, seen as renderings are.
    pub fn new(samples: &Samples, bias: f32, grey: bool) -> Self {
        Self::with_aim(samples, bias, grey, Aim::Renderings)
    }

    /// Of samples.
    pub fn with_aim(samples: &Samples, bias: f32, grey: bool, aim: Aim) -> Self {
        let on_ball = || (0..samples.len()).filter(|k| Samples::is_on_ball(*k));
        let sum: f64 = on_ball().map(|k| samples.values[k].iter().map(|v| f64::from(*v)).sum::<f64>()).sum();
        let mean = (sum / (3 * on_ball().count().max(1)) as f64) as f32;
        // Of what is next to nothing the smallest that a pack may have.
        let mean = if sum > 0.0 { mean.max(f32::MIN_POSITIVE) } else { 1.0 };
        let mut shown: Vec<f32> =
            on_ball().map(|k| samples.values[k].iter().fold(0.0f32, |a, b| a.max(*b)) * samples.cosines[k]).collect();
        let at = ((shown.len().max(1) - 1) as f32 * WHITE) as usize;
        let white = if shown.is_empty() { 0.0 } else { *shown.select_nth_unstable_by(at, f32::total_cmp).1 };
        // As good as black where one over white is no number.
        let exposure = if white.is_normal() && white > 0.0 { 1.0 / white } else { 1.0 };
        let weight = |value: f32, cosine: f32| {
            if aim == Aim::Ratios {
                return value / (value + mean * bias);
            }
            let shown = value * cosine * exposure;
            // Beyond white renderings do not change, but highlights are to keep their light: a ratio counts there as it does at white.
            let clipped = if shown < 1.0 { 1.0 } else { 1.0 / shown };
            let weight = lightness_slope(shown.min(1.0)) * (value + mean * bias) * cosine * exposure * clipped;
            // Beside a spike that raises the mean, where nothing is exact, squares stay numbers.
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

    /// What is left when a curve has these parts of the logarithms.
    #[must_use]
    pub fn without(&self, taken: Vec<[f32; 3]>) -> Self {
        let less = |(all, taken): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| all[c] - taken[c]);
        Self { logarithms: self.logarithms.iter().zip(&taken).map(less).collect(), taken, ..self.clone() }
    }

    /// How far logarithms of samples, seen at an incoming cosine, are from what they should be: the sum, in their order, of ΔE as
    /// they are shown, or of the mean ratio. What is brighter than white adds the lightness that its ratio would change at white. Samples
    /// are told by their numbers.
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

    /// A channel of sample `k`, seen at an incoming cosine, where its logarithm is this.
    fn shown(&self, k: usize, channel: usize, logarithm: f32, cosine: f32) -> f32 {
        let taken = self.taken.get(k).map_or(0.0, |taken| taken[channel]);
        self.mean * ((logarithm + taken).exp() - self.bias) * cosine * self.exposure
    }
}

/// Derivative of CIELAB's `f`, lightness over 116.
fn lightness_slope(t: f32) -> f32 {
    if t > 216.0 / 24389.0 { 1.0 / (3.0 * t.cbrt().powi(2)) } else { 24389.0 / 27.0 / 116.0 }
}
