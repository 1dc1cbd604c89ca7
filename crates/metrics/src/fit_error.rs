//! The error of a source that was completed from samples, against the material that was sampled: estimated by
//! cross-validation, as that material is not known anywhere else.

use super::norms::NormSums;
use super::picture::{ReferencePicture, coarse_picture_pairs};
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_core::source::{Completion, Fold, MAX_PEAK, MAX_RISE, Parts, Repeats, Rise};
use brdfc_core::{Source, Tally};
use brdfc_formats::crop::DirectionRange;
use rayon::prelude::*;

/// Folds that are in memory together, each nearly as large as the source; within a fold, threads share the pixels.
const FOLDS_AT_ONCE: usize = 2;

/// Angle between a pixel's light or viewer and that of the nearest sample from which on the pixel counts as uncovered, degrees.
pub const COVERED: f64 = 10.0;
/// Share of uncovered pixels from which on the fit is mostly a guess.
pub const MAX_UNCOVERED: f64 = 0.1;
/// Spread of repeats from which on they disagree: the larger of two values is twice the smaller.
pub const MAX_SPREAD: f64 = 0.5;
/// Share of the direction pairs from which on those that repeat speak for all.
const MANY_REPEATS: f64 = 0.1;
/// A fit without one incidence spans twice the gap. An error that grows with its square is then larger by three times itself, and each
/// gap is opened from both its ends.
const GAPS: f64 = 1.0 / 6.0;
/// Difference that leaving out one incidence makes over the median of all from which on it contradicts the others.
const CONTRADICTION: f64 = 6.0;
/// Incidences from which on one can be told from the others.
const FEW_INCIDENCES: usize = 5;
/// Share of a pack's own ΔE from which on the fit is the weaker part: the sum of both, as of independent errors, is a fifth larger.
const WEAKER: f64 = 0.7;

/// How far a completed source may be from what was sampled.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct FitError {
    /// `ε_r` of samples that were left out in ten parts, each predicted from the others; absent where too few are left.
    pub samples: Option<f64>,
    /// The same of incidences that were left out whole; absent where there is one alone, or where too few samples are left.
    pub incidences: Option<f64>,
    /// Estimate of the mean ΔE between renderings of the source and of the sampled material; absent where nothing can be left out.
    pub delta_e: Option<f64>,
    /// The largest angle between the light or the viewer of a pixel of the ball and that of the nearest sample, degrees.
    pub farthest: f64,
    /// Share of the ball's pixels at which that angle is larger than 10 degrees.
    pub uncovered: f64,
    /// Samples of one direction pair; absent where none repeats.
    pub repeats: Option<Repeats>,
    /// How fast samples rise towards the mirror direction; absent where too few are near it.
    pub rise: Option<Rise>,
}

impl FitError {
    /// Cross-validates a source that is completed from samples, for renderings within a range of directions.
    ///
    /// # Errors
    /// Cancellation.
    pub fn measure(
        source: &dyn Source,
        completion: &dyn Completion,
        directions: DirectionRange,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        progress.stage(Stage::CrossValidate, 1)?;
        let pairs = coarse_picture_pairs(directions);
        let picture = ReferencePicture::of_pairs(source, pairs.clone()).0;
        let validated = |parts| {
            let validate = |number| {
                progress.check().ok()?;
                let fold = completion.fold(parts, number)?;
                let delta_e = picture.compare(fold.source.as_ref()).delta_e.mean;
                Some((predicted(&fold, source.is_grey()), delta_e))
            };
            let numbers: Vec<usize> = (0..completion.fold_count(parts)).collect();
            let mut folds: Vec<Option<(NormSums, f64)>> = Vec::new();
            for at_once in numbers.chunks(FOLDS_AT_ONCE) {
                folds.par_extend(at_once.par_iter().map(|number| validate(*number)));
            }
            let count = folds.len();
            let folds: Vec<_> = folds.into_iter().flatten().collect();
            // Folds that cannot be fitted are those whose samples nothing predicts.
            if folds.is_empty() || folds.len() < count {
                return None;
            }
            let mut all = folds[0].0.clone();
            folds[1..].iter().for_each(|(sums, _)| all.merge(sums));
            let differences: Vec<f64> = folds.iter().map(|(_, delta_e)| *delta_e).collect();
            // Of what is black there is nothing to predict.
            let norms = all.norms();
            (norms.counted() > 0).then_some((norms.relative_mean, differences))
        };
        let samples = validated(Parts::Samples);
        let incidences = validated(Parts::Incidences);
        // Jackknife by groups (Efron and Stein 1981): the variance of a fit is (g - 1)/g times the sum of squared differences.
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
        let distances: Vec<f64> = pairs.par_iter().map(|pair| completion.distance(*pair).to_degrees()).collect();
        let uncovered = distances.iter().filter(|degrees| **degrees > COVERED).count();
        Ok(Self {
            samples: samples.map(|(error, _)| error),
            incidences: incidences.map(|(error, _)| error),
            delta_e,
            farthest: distances.iter().copied().fold(0.0, f64::max),
            uncovered: uncovered as f64 / distances.len().max(1) as f64,
            repeats: completion.repeats(),
            rise: completion.rise(),
        })
    }

    /// The larger of both `ε_r`; absent where nothing can be left out.
    pub fn error(&self) -> Option<f64> {
        [self.samples, self.incidences].into_iter().flatten().reduce(f64::max)
    }

    /// Why the samples do not say what the material is, whatever the pack; nothing where they do.
    pub fn gaps(&self) -> Option<String> {
        if self.uncovered > MAX_UNCOVERED {
            let (share, farthest) = (100.0 * self.uncovered, self.farthest);
            return Some(format!(
                "{share:.0} % of the ball's pixels are more than {COVERED}° from any sample, up to {farthest:.0}°"
            ));
        }
        if let Some(repeats) =
            self.repeats.filter(|repeats| repeats.share > MANY_REPEATS && repeats.spread > MAX_SPREAD)
        {
            let (pairs, spread) = (repeats.pairs, 100.0 * repeats.spread);
            return Some(format!("samples of {pairs} direction pairs repeat, and differ by {spread:.0} %"));
        }
        if let Some(rise) = self.rise.filter(|rise| rise.peak > MAX_PEAK || rise.ratio > MAX_RISE) {
            let Rise { incidence, nearest, next, ratio, .. } = rise;
            return Some(format!(
                "the highlight is narrower than the samples tell: at {incidence:.0}° incidence values rise {ratio:.1} times from {next:.1}° \
                 to {nearest:.1}° off the mirror direction (half angles), where samples end"
            ));
        }
        self.delta_e.is_none().then(|| "too few samples to leave any out".to_owned())
    }

    /// Why the error of a pack, whose renderings differ from those of the source by this mean ΔE, says too little: its error against
    /// the material that was sampled is larger. Nothing where the fit is the stronger part.
    pub fn weakness(&self, pack: f64) -> Option<String> {
        let weaker = |fit: &f64| *fit > WEAKER * pack;
        let of_fit =
            || self.delta_e.filter(weaker).map(|fit| format!("about ΔE {fit:.2} of the fit, {pack:.2} of the pack"));
        self.gaps().or_else(of_fit)
    }
}

/// Mean ΔE that gaps between incidences cost, from the differences that leaving out each makes. One that differs from all others is no
/// gap: it contradicts them, and either may be right.
fn difference_of_gaps(differences: &[f64]) -> f64 {
    let mut sorted = differences.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (median, largest) = (sorted[sorted.len() / 2], sorted[sorted.len() - 1]);
    let gaps = GAPS * differences.iter().sum::<f64>();
    if sorted.len() >= FEW_INCIDENCES && largest > CONTRADICTION * median { gaps.max(largest) } else { gaps }
}

/// How well a fold predicts what was left out of it.
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
