//! Error of a source that was completed from samples, against the sampled material. It is estimated by
//! cross-validation, because no other data of the material exist.

use super::norms::NormSums;
use super::rendering::{ReferenceRendering, coarse_rendering_pairs};
use super::sampling::PairSet;
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_core::source::{
    Completion, Fold, MAX_PEAK, MAX_RISE, MAX_ROUNDING, Parts, PeakAt, Repeats, Rise, Rounding, Samples, Saturation,
};
use brdfc_core::words::format_number;
use brdfc_core::{Source, Tally};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;
use rayon::prelude::*;

/// Number of folds in memory at the same time, each nearly as large as the source; within a fold, threads share the
/// pixels.
const FOLDS_AT_ONCE: usize = 2;

/// A direction pair counts as uncovered if its light or viewer is at least this angle from the light or viewer of the
/// nearest sample, degrees.
pub const COVERED: f64 = 10.0;
/// The fit counts as mostly a guess above this share of uncovered pairs.
pub const MAX_UNCOVERED: f64 = 0.1;
/// As [`MAX_UNCOVERED`], of tables, whose values in gaps have no estimated error.
pub const MAX_UNCOVERED_OF_TABLES: f64 = 0.02;
/// Repeats disagree above this spread: the larger of two values is twice the smaller.
pub const MAX_SPREAD: f64 = 0.5;
/// Repeats are representative above this share of the direction pairs.
const MANY_REPEATS: f64 = 0.1;
/// Samples contradict reciprocity above this mean difference of exchanged ones.
pub const MAX_EXCHANGED: f64 = 0.05;
/// Each held-out incidence doubles a gap. If the error grows with the square of the gap, the error becomes four times
/// as large, and each gap is doubled from both its ends.
const GAPS: f64 = 1.0 / 6.0;
/// An incidence contradicts the others if a fit without it differs by more than this multiple of the median.
const CONTRADICTION: f64 = 6.0;
/// Every pair of the test directions whose number is a multiple of this is looked up for gaps.
const COARSE: usize = 8;
/// Minimum number of incidences for a decision that one contradicts the others.
const MIN_INCIDENCES: usize = 5;
/// The fit is the larger error above this share of a pack's own ΔE: the sum of both, as of independent errors, is a
/// fifth larger.
const WEAKER: f64 = 0.7;

/// Estimated distance of a completed source from the sampled material.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct FitError {
    /// `ε_r` of samples held out in ten folds, each predicted from the other samples; absent if too few remain.
    pub samples: Option<f64>,
    /// `ε_r` of incidences held out with all their samples; absent for a single incidence, or if too few samples
    /// remain.
    pub incidences: Option<f64>,
    /// Estimate of the mean ΔE between renderings of the source and of the sampled material; absent without
    /// cross-validation.
    pub delta_e: Option<f64>,
    /// Gaps between the samples at the pixels of the ball, whose mean is ΔE.
    pub ball: Gaps,
    /// Gaps between the samples at the independent test directions, whose mean is `ε_r`.
    pub test_directions: Gaps,
    /// Repeated direction pairs; absent without any.
    pub repeats: Option<Repeats>,
    /// Mean difference of samples from the fit to the others, with light and viewer exchanged, as a fraction of the larger value,
    /// less the estimated noise; absent if too few exchanged samples are near others.
    pub exchanged: Option<f64>,
    /// Rise of the samples towards the mirror direction; absent if too few are near it.
    pub rise: Option<Rise>,
    /// A plateau at the largest value; absent without one.
    pub saturation: Option<Saturation>,
    /// Rounding of the values; absent if they have no common step.
    pub rounding: Option<Rounding>,
    /// True if the source is completed from scattered samples, false for a table.
    pub completed: bool,
    /// True if too few samples remain when some are held out.
    pub too_few: bool,
}

/// Distances of direction pairs from the nearest sample.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Gaps {
    /// Largest angle between the light or viewer of a pair and the light or viewer of the nearest sample, degrees.
    pub farthest: f64,
    /// Share of the pairs at which this angle is larger than 10 degrees.
    pub uncovered: f64,
}

impl Gaps {
    fn of(samples: &dyn Samples, pairs: &[DirectionPair]) -> Self {
        let distances: Vec<f64> = pairs.par_iter().map(|pair| samples.distance(*pair).to_degrees()).collect();
        let uncovered = distances.iter().filter(|degrees| **degrees > COVERED).count();
        Self {
            farthest: distances.iter().copied().fold(0.0, f64::max),
            uncovered: uncovered as f64 / distances.len().max(1) as f64,
        }
    }

    /// Description of gaps that make an error over these pairs an extrapolation.
    fn problem(&self, pairs: &str, most: f64) -> Option<String> {
        let (share, farthest) = (100.0 * self.uncovered, self.farthest);
        (self.uncovered > most).then(|| {
            format!("{share:.0} % of the {pairs} are more than {COVERED}° from any sample, up to {farthest:.0}°")
        })
    }
}

impl FitError {
    /// Looks at the samples of a source, and cross-validates it if it is completed from them, for renderings within a range of directions.
    /// `None` for sources without samples.
    ///
    /// # Errors
    /// Returns an error if the work is cancelled.
    pub fn measure(
        source: &dyn Source,
        directions: DirectionRange,
        progress: &dyn Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(unvalidated) = Self::without_validation(source, directions) else { return Ok(None) };
        source.completion().map_or(Ok(Some(unvalidated)), |completion| {
            unvalidated.validated(source, completion, directions, progress).map(Some)
        })
    }

    fn validated(
        self,
        source: &dyn Source,
        completion: &dyn Completion,
        directions: DirectionRange,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        progress.stage(Stage::CrossValidate, 1)?;
        let pairs = coarse_rendering_pairs(directions);
        let rendering = ReferenceRendering::of_pairs(source, pairs.clone()).0;
        let validated = |parts| {
            let validate = |number| {
                progress.check().ok()?;
                let fold = completion.fold(parts, number)?;
                let delta_e = rendering.compare(fold.source.as_ref()).delta_e.mean;
                Some((predicted(&fold, source.is_grey()), delta_e))
            };
            let numbers: Vec<usize> = (0..completion.fold_count(parts)).collect();
            let mut folds: Vec<Option<(NormSums, f64)>> = Vec::new();
            for at_once in numbers.chunks(FOLDS_AT_ONCE) {
                folds.par_extend(at_once.par_iter().map(|number| validate(*number)));
            }
            let count = folds.len();
            let folds: Vec<_> = folds.into_iter().flatten().collect();
            // If a fold cannot be fitted, no sample predicts the samples that it leaves out.
            if folds.is_empty() || folds.len() < count {
                return None;
            }
            let mut all = folds[0].0.clone();
            folds[1..].iter().for_each(|(sums, _)| all.merge(sums));
            let differences: Vec<f64> = folds.iter().map(|(_, delta_e)| *delta_e).collect();
            // A black material has nothing to predict.
            let norms = all.norms();
            (norms.counted() > 0).then_some((norms.relative_mean, differences))
        };
        let samples = validated(Parts::Samples);
        let incidences = validated(Parts::Incidences);
        // Jackknife by groups (Efron and Stein 1981): the variance of a fit is (g - 1)/g times the sum of squared
        // differences.
        let deviation = |differences: &[f64]| {
            let groups = differences.len() as f64;
            ((groups - 1.0) / groups * differences.iter().map(|d| d * d).sum::<f64>()).sqrt()
        };
        progress.check()?;
        let of_samples = samples.as_ref().map(|(_, differences)| deviation(differences));
        let of_incidences = incidences.as_ref().map(|(_, differences)| difference_of_gaps(differences));
        let delta_e = match (of_samples, of_incidences) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        Ok(Self {
            samples: samples.map(|(error, _)| error),
            incidences: incidences.map(|(error, _)| error),
            delta_e,
            too_few: delta_e.is_none(),
            ..self
        })
    }

    /// The parts that follow from the directions and values of the samples alone.
    fn without_validation(source: &dyn Source, directions: DirectionRange) -> Option<Self> {
        let (samples, completion) = (source.samples()?, source.completion());
        let tested: Vec<DirectionPair> = PairSet::within(directions).pairs.iter().copied().step_by(COARSE).collect();
        Some(Self {
            samples: None,
            incidences: None,
            delta_e: None,
            ball: Gaps::of(samples, &coarse_rendering_pairs(directions)),
            test_directions: Gaps::of(samples, &tested),
            repeats: completion.and_then(Completion::repeats),
            exchanged: completion.and_then(Completion::exchanged),
            rise: samples.rise(),
            saturation: samples.saturation(),
            rounding: samples.rounding(),
            completed: completion.is_some(),
            too_few: false,
        })
    }

    /// The larger of both `ε_r`; absent without cross-validation.
    pub fn error(&self) -> Option<f64> {
        [self.samples, self.incidences].into_iter().flatten().reduce(f64::max)
    }

    /// The larger gaps of both sets of directions: larger share, then larger angle.
    pub fn largest_gaps(&self) -> Gaps {
        let key = |gaps: &Gaps| (gaps.uncovered, gaps.farthest);
        if key(&self.ball) > key(&self.test_directions) { self.ball } else { self.test_directions }
    }

    fn max_uncovered(&self) -> f64 {
        if self.completed { MAX_UNCOVERED } else { MAX_UNCOVERED_OF_TABLES }
    }

    /// Reason why `ε_r` of the fit, and `ε_r` of a pack against the material, are extrapolated; `None` if they are not.
    pub fn extrapolation(&self) -> Option<String> {
        self.test_directions.problem("test directions, over which ε_r is a mean,", self.max_uncovered())
    }

    /// Reason why the samples do not determine the renderings, for any pack; `None` if they do.
    pub fn gaps(&self) -> Option<String> {
        if let Some(problem) = self.ball.problem("ball's pixels", self.max_uncovered()) {
            return Some(problem);
        }
        if let Some(repeats) =
            self.repeats.filter(|repeats| repeats.share > MANY_REPEATS && repeats.spread > MAX_SPREAD)
        {
            let (pairs, spread) = (repeats.pairs, 100.0 * repeats.spread);
            return Some(format!("repeated samples of {pairs} direction pairs differ by {spread:.0} %"));
        }
        if let Some(exchanged) = self.exchanged.filter(|exchanged| *exchanged > MAX_EXCHANGED) {
            let difference = 100.0 * exchanged;
            return Some(format!(
                "with light and viewer exchanged, samples differ by {difference:.0} % on average: the material is anisotropic and was \
                 measured from one azimuth, or values or angles are wrong (values times a cosine? an offset of angles?)"
            ));
        }
        if let Some(rise) = self.rise.filter(|rise| rise.peak > MAX_PEAK || rise.ratio > MAX_RISE) {
            let Rise { incidence, nearest, next, ratio, .. } = rise;
            let (what, place) = match rise.peak_at {
                PeakAt::Mirror => ("highlight", "mirror direction"),
                PeakAt::Viewer => ("retroreflection", "direction back to the light"),
            };
            return Some(format!(
                "the {what} is narrower than the samples resolve: at {incidence:.0}° incidence values rise {ratio:.1} times from {next:.1}° off \
                 the {place} (half angles) to the next samples towards it, of which the nearest is {nearest:.1}° off"
            ));
        }
        if let Some(Saturation { samples, farthest }) = self.saturation {
            return Some(format!(
                "the largest values, or values times cosines, of {samples} samples are equal, up to {farthest:.0}° off the mirror direction (half \
                 angles): the detector was saturated, or values are cut off"
            ));
        }
        if let Some(Rounding { step, error }) = self.rounding.filter(|rounding| rounding.error > MAX_ROUNDING) {
            // Three digits, without those of binary fractions.
            let step: f64 = format!("{step:.2e}").parse().unwrap_or(step);
            let (step, error) = (format_number(step), 100.0 * error);
            return Some(format!(
                "values are rounded to multiples of {step}, which changes them by {error:.0} % on average"
            ));
        }
        self.too_few.then(|| "too few samples to hold any out".to_owned())
    }

    /// Reason why the error of a pack is not meaningful: its error against the sampled material is larger. `pack` is
    /// the mean ΔE between renderings of the pack and of the source. `None` if the fit has the smaller error.
    pub fn weakness(&self, pack: f64) -> Option<String> {
        let weaker = |fit: &f64| *fit > WEAKER * pack;
        let of_fit =
            || self.delta_e.filter(weaker).map(|fit| format!("about ΔE {fit:.2} of the fit, {pack:.2} of the pack"));
        self.gaps().or_else(of_fit).or_else(|| self.extrapolation())
    }
}

/// Reason why samples do not determine a source at all directions, without cross-validation; `None` if they do, or if the source is
/// not completed from samples.
pub fn undetermined(source: &dyn Source, directions: DirectionRange) -> Option<String> {
    let fit = FitError::without_validation(source, directions)?;
    fit.gaps().or_else(|| fit.extrapolation())
}

/// Estimates the mean ΔE that gaps between incidences cost, from the difference that holding out each incidence makes.
/// An incidence that differs from all others contradicts them; either side may be right, so its difference counts
/// fully.
fn difference_of_gaps(differences: &[f64]) -> f64 {
    let mut sorted = differences.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (median, largest) = (sorted[sorted.len() / 2], sorted[sorted.len() - 1]);
    let gaps = GAPS * differences.iter().sum::<f64>();
    if sorted.len() >= MIN_INCIDENCES && largest > CONTRADICTION * median { gaps.max(largest) } else { gaps }
}

/// Norms of the predictions of a fold for the samples that it holds out.
fn predicted(fold: &Fold, grey: bool) -> NormSums {
    let channels = if grey { 1 } else { 3 };
    let samples = &fold.left_out;
    let mean = samples.iter().flat_map(|(_, value)| value).sum::<f64>() / (3 * samples.len()).max(1) as f64;
    let mut sums = NormSums::new(mean);
    for (pair, value) in samples {
        let found = fold.source.eval(*pair, &mut Tally::default());
        for channel in 0..channels {
            sums.add(value[channel], found[channel], pair.incoming[2]);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_incidence_that_contradicts_the_others_counts_whole() {
        let gaps = [0.02, 0.05, 0.05, 0.05, 0.08, 0.04, 0.06, 0.06];
        assert!((difference_of_gaps(&gaps) - GAPS * gaps.iter().sum::<f64>()).abs() < 1e-12);
        let one = [0.02, 0.05, 0.05, 0.05, 0.08, 0.13, 0.76, 1.23];
        assert!((difference_of_gaps(&one) - 1.23).abs() < 1e-12);
        // The ends of few incidences differ by nature.
        let few = [0.26, 0.39, 0.02];
        assert!(difference_of_gaps(&few) < 0.2);
    }
}
