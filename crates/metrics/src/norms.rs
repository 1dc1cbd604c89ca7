//! The error norms of `docs/accuracy.md`, from sums that merge in a fixed order.

use brdfc_formats::ErrorSummary;
use brdfc_formats::vector_math::ln_1p;

/// Samples with `f` below this fraction of the mean are excluded from relative norms and counted separately.
pub const RELATIVE_FLOOR: f64 = 1e-3;

/// Number of low bits of an f32 that a histogram bin drops: 256 bins per factor of two, 0.4 % wide.
const BIN_SHIFT: u32 = 15;
/// Number of samples processed at once in single precision.
const LANES: usize = 256;
/// Ratios outside 2^-40 to 2^40 fall into the first and the last bin.
const FIRST_BIN: u32 = (127 - 40) << (23 - BIN_SHIFT);
const BINS: usize = 80 << (23 - BIN_SHIFT);

/// Norms of `f' - f` over a set of samples; each channel of a direction pair is one sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Norms {
    /// Number of compared samples.
    pub samples: u64,
    /// Samples with `f < 1e-3 μ`, excluded from the relative and log norms.
    pub below_floor: u64,
    /// `ε` of section 6.2 of Claustres et al. 2007: RMS of `f' - f`, 1/sr.
    pub rms: f64,
    /// `ε_r` of section 6.2 of Claustres et al. 2007: mean of `|f' - f| / f`, a fraction.
    pub relative_mean: f64,
    /// Standard error of `ε_r`, assuming independent samples.
    pub relative_standard_error: f64,
    /// 95th percentile of `|f' - f| / f`, to 0.4 %.
    pub relative_p95: f64,
    /// 99th percentile of `|f' - f| / f`, to 0.4 %.
    pub relative_p99: f64,
    /// Maximum of `|f' - f| / f`.
    pub relative_max: f64,
    /// RMS of `ln f' - ln f`; `f'` counts as at least `1e-6 μ`.
    pub log_rms: f64,
    /// RMS of `ln(1 + f' cos θi) - ln(1 + f cos θi)` over all samples.
    pub cosine_log_rms: f64,
}

impl Norms {
    /// The errors as a pack stores them, with the largest difference of albedos and the reciprocity error.
    pub fn summary(&self, albedo_max_difference: f64, reciprocity: f64) -> ErrorSummary {
        let narrow = |v: f64| (v as f32).min(f32::MAX);
        ErrorSummary {
            samples: self.samples.min(u64::from(u32::MAX)) as u32,
            rms: narrow(self.rms),
            relative_mean: narrow(self.relative_mean),
            relative_p95: narrow(self.relative_p95),
            relative_p99: narrow(self.relative_p99),
            relative_max: narrow(self.relative_max),
            log_rms: narrow(self.log_rms),
            cosine_log_rms: narrow(self.cosine_log_rms),
            albedo_max_difference: narrow(albedo_max_difference),
            reciprocity: narrow(reciprocity),
        }
    }
}

impl Norms {
    /// Number of samples in the relative and log norms.
    pub fn counted(&self) -> u64 {
        self.samples - self.below_floor
    }
}

/// Sums for [`Norms`]. Merging in a fixed order gives the same bits on any number of threads.
#[derive(Debug, Clone)]
pub struct NormSums {
    mean: f64,
    samples: u64,
    below_floor: u64,
    square: f64,
    relative: f64,
    relative_square: f64,
    relative_max: f64,
    log_square: f64,
    cosine_log_square: f64,
    histogram: Vec<u32>,
}

impl NormSums {
    /// No samples; `mean` is the `μ` of the floor.
    pub fn new(mean: f64) -> Self {
        Self {
            mean,
            samples: 0,
            below_floor: 0,
            square: 0.0,
            relative: 0.0,
            relative_square: 0.0,
            relative_max: 0.0,
            log_square: 0.0,
            cosine_log_square: 0.0,
            histogram: vec![0; BINS],
        }
    }

    /// Adds a sample: reference `f`, approximation `f'` (here `g`), cosine of the incoming angle.
    pub fn add(&mut self, f: f64, g: f64, cos_theta_i: f64) {
        let difference = g - f;
        self.samples += 1;
        self.square += difference * difference;
        // ln(1 + g c) - ln(1 + f c), as one logarithm that preserves small differences.
        let cosine_log = (difference * cos_theta_i / (1.0 + f * cos_theta_i)).ln_1p();
        self.cosine_log_square += cosine_log * cosine_log;
        if f < RELATIVE_FLOOR * self.mean || f <= 0.0 {
            self.below_floor += 1;
            return;
        }
        let relative = difference.abs() / f;
        self.relative += relative;
        self.relative_square += relative * relative;
        self.relative_max = self.relative_max.max(relative);
        self.histogram[bin_of(relative as f32)] += 1;
        let log = (g.max(1e-6 * self.mean) / f).ln();
        self.log_square += log * log;
    }

    /// Adds many samples with the same incoming cosine: references `f`, approximations `g`. The same norms as
    /// [`Self::add`], in single precision: about 1e-6 of each sample's value.
    pub fn add_row(&mut self, f: &[f32], g: &[f32], cos_theta_i: f32) {
        let floor = ((RELATIVE_FLOOR * self.mean) as f32).max(f32::MIN_POSITIVE);
        let least = (1e-6 * self.mean) as f32;
        let mut squares = [[0.0f32; LANES]; 3];
        let mut relative = [0.0f32; LANES];
        for (f, g) in f.chunks(LANES).zip(g.chunks(LANES)) {
            let [difference, log, cosine_log] = &mut squares;
            let mut counted = 0;
            for k in 0..f.len() {
                let d = g[k] - f[k];
                let base = f[k].max(floor);
                // Samples below the floor count as exact here; a separate count holds their number.
                let above = if f[k] >= floor { 1.0 } else { 0.0 };
                let l = above * ln_1p((g[k].max(least) - base) / base);
                let c = ln_1p(d * cos_theta_i / (1.0 + f[k] * cos_theta_i));
                relative[k] = above * d.abs() / base;
                (difference[k], log[k], cosine_log[k]) = (d * d, l * l, c * c);
                counted += u32::from(f[k] >= floor);
            }
            let n = f.len();
            self.square += sum(&difference[..n]);
            self.log_square += sum(&log[..n]);
            self.cosine_log_square += sum(&cosine_log[..n]);
            self.relative += sum(&relative[..n]);
            // Squares of large ratios overflow in single precision.
            self.relative_square += relative[..n].iter().map(|ratio| f64::from(*ratio).powi(2)).sum::<f64>();
            for (k, ratio) in relative[..n].iter().enumerate() {
                if f[k] >= floor {
                    self.relative_max = self.relative_max.max(f64::from(*ratio));
                    self.histogram[bin_of(*ratio)] += 1;
                }
            }
            self.samples += n as u64;
            self.below_floor += n as u64 - u64::from(counted);
        }
    }

    /// Adds the samples of another set.
    pub fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.below_floor += other.below_floor;
        self.square += other.square;
        self.relative += other.relative;
        self.relative_square += other.relative_square;
        self.relative_max = self.relative_max.max(other.relative_max);
        self.log_square += other.log_square;
        self.cosine_log_square += other.cosine_log_square;
        for (bin, count) in self.histogram.iter_mut().zip(&other.histogram) {
            *bin += count;
        }
    }

    /// The norms; all zero without samples.
    pub fn norms(&self) -> Norms {
        let per = |sum: f64, count: u64| if count == 0 { 0.0 } else { sum / count as f64 };
        let counted = self.samples - self.below_floor;
        let relative_mean = per(self.relative, counted);
        let variance = (per(self.relative_square, counted) - relative_mean * relative_mean).max(0.0);
        Norms {
            samples: self.samples,
            below_floor: self.below_floor,
            rms: per(self.square, self.samples).sqrt(),
            relative_mean,
            relative_standard_error: per(variance, counted).sqrt(),
            relative_p95: self.percentile(0.95, counted),
            relative_p99: self.percentile(0.99, counted),
            relative_max: self.relative_max,
            log_rms: per(self.log_square, counted).sqrt(),
            cosine_log_rms: per(self.cosine_log_square, self.samples).sqrt(),
        }
    }

    /// Centre of the bin that holds the sample of this rank.
    fn percentile(&self, fraction: f64, counted: u64) -> f64 {
        let rank = (fraction * counted as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (bin, count) in self.histogram.iter().enumerate() {
            seen += u64::from(*count);
            if seen >= rank {
                let centre = ((bin as u32 + FIRST_BIN) << BIN_SHIFT) + (1 << (BIN_SHIFT - 1));
                return f64::from(f32::from_bits(centre)).min(self.relative_max);
            }
        }
        0.0
    }
}

fn bin_of(ratio: f32) -> usize {
    ((ratio.to_bits() >> BIN_SHIFT).saturating_sub(FIRST_BIN) as usize).min(BINS - 1)
}

/// Sums in eight lanes and in a fixed order, which the compiler can vectorise.
fn sum(values: &[f32]) -> f64 {
    let mut strands = [0.0f32; 8];
    let (groups, rest) = values.as_chunks::<8>();
    for group in groups {
        for k in 0..8 {
            strands[k] += group[k];
        }
    }
    strands.iter().chain(rest).map(|v| f64::from(*v)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(pairs: &[(f64, f64)]) -> Norms {
        let mut sums = NormSums::new(1.0);
        for (f, g) in pairs {
            sums.add(*f, *g, 0.5);
        }
        sums.norms()
    }

    #[test]
    fn known_values() {
        let norms = of(&[(1.0, 1.1), (2.0, 1.8), (1e-4, 1.0)]);
        assert_eq!((norms.samples, norms.below_floor), (3, 1));
        assert!((norms.relative_mean - 0.1).abs() < 1e-12);
        let rms = ((0.01 + 0.04 + (1.0f64 - 1e-4).powi(2)) / 3.0).sqrt();
        assert!((norms.rms - rms).abs() < 1e-12);
        assert!((norms.log_rms - ((1.1f64.ln().powi(2) + 0.9f64.ln().powi(2)) / 2.0).sqrt()).abs() < 1e-12);
        let spread = of(&[(1.0, 1.1), (2.0, 2.6)]).relative_standard_error;
        assert!((spread - 0.1 / 2.0f64.sqrt()).abs() < 1e-12, "{spread}");
        let cosine = of(&[(1.0, 3.0)]).cosine_log_rms;
        assert!((cosine - (2.5f64 / 1.5).ln()).abs() < 1e-12);
    }

    #[test]
    fn rows_in_single_precision_follow_single_samples() {
        let f: Vec<f32> = (0..1000).map(|k| 1e-4 * 1.012f32.powi(k)).collect();
        for spread in [0.5f32, 1e-2, 1e-4] {
            let g: Vec<f32> =
                f.iter().zip(0..).map(|(f, k)| f * (1.0 + spread * ((k % 7) as f32 - 3.0) / 3.0)).collect();
            let mut rows = NormSums::new(1.0);
            rows.add_row(&f, &g, 0.7);
            let mut single = NormSums::new(1.0);
            for (f, g) in f.iter().zip(&g) {
                single.add(f64::from(*f), f64::from(*g), f64::from(0.7f32));
            }
            let (a, b) = (rows.norms(), single.norms());
            assert_eq!((a.samples, a.below_floor), (b.samples, b.below_floor));
            for (x, y) in [
                (a.rms, b.rms),
                (a.relative_mean, b.relative_mean),
                (a.relative_standard_error, b.relative_standard_error),
                (a.relative_max, b.relative_max),
                (a.log_rms, b.log_rms),
                (a.cosine_log_rms, b.cosine_log_rms),
            ] {
                assert!((x - y).abs() <= 2e-6 * y + 1e-7, "{x} {y} at {spread}");
            }
        }
    }

    #[test]
    fn percentiles_are_within_a_bin() {
        let pairs: Vec<_> = (1..=1000).map(|k| (1.0, 1.0 + f64::from(k) * 1e-3)).collect();
        let norms = of(&pairs);
        assert!((norms.relative_p95 / 0.95 - 1.0).abs() < 0.004, "{}", norms.relative_p95);
        assert!((norms.relative_p99 / 0.99 - 1.0).abs() < 0.004);
    }

    #[test]
    fn equal_functions_have_no_error_and_huge_ones_do_not_break() {
        let norms = of(&[(1.0, 1.0), (5.0, 5.0)]);
        assert_eq!((norms.rms, norms.relative_max, norms.log_rms), (0.0, 0.0, 0.0));
        assert!(of(&[(1.0, 1e300)]).relative_max > 1e299);
        assert_eq!(of(&[]), Norms::default());
    }
}
