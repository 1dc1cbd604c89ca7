//! The cases of [`engines`](crate::engines) with the sampler filtering, and the bounds of its differences from exact
//! weights.
//!
//! GPUs represent a position between two texels with 8 bits, so a weight is off by up to [`STEP`] along each filtered
//! axis. A linear filter is then off by at most that share of the difference between neighbours, so each query has its
//! own bound.
//!
//! The modules of codecs compute the bounds of theirs.

use crate::engines::Case;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::wavelet::Filter;
use std::collections::BTreeMap;

/// Maximum error of a weight: samplers represent positions in texels with 8 fractional bits, rounded either way.
pub const STEP: f32 = 1.0 / 256.0;

/// Frame block with a filtering sampler.
pub(crate) const SAMPLED: FrameBlock =
    FrameBlock { distance_scale: 1.0, sampler_filters: true, blend: Filter::Bilinear };

/// Additional error by other arithmetic, as [`engines`](crate::engines) allows for exact weights, and by rounding of
/// filtered values.
pub(crate) const ROUNDING: f64 = 1e-4;

/// Maximum mean error as a share of the bound: positions are rounded to the nearest, so by a quarter of a step on
/// average.
const MEAN_SHARE: f64 = 0.3;

/// A case, and the error bounds for the sampler.
pub struct SamplerCase {
    pub case: Case,
    /// Bounds for each number of an answer.
    pub allowed: Vec<[f64; 4]>,
    /// True if the sampler filters along the texture's columns. False with a single column.
    pub is_filtered: bool,
}

impl SamplerCase {
    /// Errors of answers: relative to the value plus its offset, and as a share of the bound. Each is the largest over
    /// the numbers of the answer.
    fn errors(&self, found: &[[f32; 4]]) -> Vec<[f64; 2]> {
        assert_eq!(found.len(), self.allowed.len());
        let of = |at: usize| {
            let (expected, floor) = self.case.expected[at];
            (0..4).fold([0.0f64; 2], |most, k| {
                let off = (f64::from(found[at][k]) - f64::from(expected[k])).abs();
                let off = if off.is_nan() { f64::INFINITY } else { off };
                let value = f64::from(expected[k].abs()) + f64::from(floor);
                [most[0].max(off / value), most[1].max(off / self.allowed[at][k])]
            })
        };
        (0..found.len()).map(of).collect()
    }
}

/// Error bound for a BRDF value if its logarithm is off by `logarithm`.
pub(crate) fn of_logarithm(logarithm: [f32; 3], expected: [f32; 3], floor: f32) -> [f64; 4] {
    let of = |k: usize| {
        let value = f64::from(expected[k]) + f64::from(floor);
        (f64::from(logarithm[k]).exp() - 1.0 + ROUNDING) * value
    };
    [of(0), of(1), of(2), ROUNDING * f64::from(floor)]
}

/// Compares answers by the sampler with the CPU's, and prints the largest, 99th percentile and mean error. Answers that
/// are not finite come from a device that does not filter such a texture.
///
/// # Panics
/// If an answer is beyond its bound, or the mean is beyond its share.
pub fn check_sampler(what: &str, cases: &[SamplerCase], found: &[Vec<[f32; 4]>]) {
    assert_eq!(found.len(), cases.len());
    let mut all: BTreeMap<&str, [f64; 4]> = BTreeMap::new();
    let mut wrong = Vec::new();
    for (case, found) in cases.iter().zip(found) {
        let (decoder, name) = (case.case.decoder.name(), &case.case.name);
        if is_skipped(found) {
            println!("skipped: {what}: {decoder}, {name}: the device does not filter floats of 32 bits");
            continue;
        }
        let errors = case.errors(found);
        let mean = |k: usize| errors.iter().map(|error| error[k]).sum::<f64>() / errors.len() as f64;
        let mut relative: Vec<f64> = errors.iter().map(|[relative, _]| *relative).collect();
        relative.sort_by(f64::total_cmp);
        let (largest, p99) = (relative[relative.len() - 1], relative[relative.len() * 99 / 100]);
        let share = errors.iter().map(|[_, share]| *share).fold(0.0, f64::max);
        println!(
            "{what}: {decoder}, {name}: largest {largest:.1e}, 99 % {p99:.1e}, mean {:.1e}; of the bound {share:.2}, mean {:.3}",
            mean(0),
            mean(1)
        );
        let of_decoder = all.entry(decoder).or_default();
        for (most, number) in of_decoder.iter_mut().zip([largest, p99, mean(0), share]) {
            *most = most.max(number);
        }
        if share > 1.0 || mean(1) > MEAN_SHARE {
            wrong.push(format!("{decoder}, {name}"));
        }
    }
    assert!(wrong.is_empty(), "{what}: beyond the bound: {wrong:#?}");
    assert!(!all.is_empty());
    for (decoder, [largest, p99, mean, share]) in all {
        println!(
            "agrees: {what}, {decoder}: largest {largest:.1e}, 99 % {p99:.1e}, mean {mean:.1e}, {share:.2} of the bound"
        );
    }
}

/// Checks that the bounds detect answers by a shader whose look-ups are off by half a texel.
///
/// # Panics
/// If no answer of a case, or less than half of all answers, are beyond the bounds.
pub fn check_shifted(what: &str, cases: &[SamplerCase], found: &[Vec<[f32; 4]>]) {
    let (mut beyond, mut all) = (0, 0);
    for (case, found) in cases.iter().zip(found).filter(|(case, found)| case.is_filtered && !is_skipped(found)) {
        let noticed = case.errors(found).iter().filter(|[_, share]| *share > 1.0).count();
        assert!(noticed > 0, "{what}: {}, {}", case.case.decoder.name(), case.case.name);
        beyond += noticed;
        all += found.len();
    }
    println!("{what}: {beyond} of {all} answers with look-ups off by half a texel are beyond their bounds");
    assert!(2 * beyond > all, "{what}: {beyond} of {all}");
}

fn is_skipped(found: &[[f32; 4]]) -> bool {
    found.iter().flatten().all(|number| number.is_nan())
}
