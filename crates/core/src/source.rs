//! Sources: reflectance as a function of direction pairs and, where it is completed from samples, the cross-validation
//! of these samples.

use super::Tally;
use super::pair_list::PairBlock;
use brdfc_formats::Symmetry;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;

/// A reflectance function that gives `f_r` for any direction pair.
pub trait Source: Send + Sync {
    /// `f_r` at a direction pair, linear RGB, 1/sr.
    ///
    /// Values follow the data: interpolated measurements may be slightly negative. Zero where either direction is at or
    /// below the horizon (`z <= 0`). `tally` counts repairs.
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3];

    /// Values at the pairs of a block, as many as it has, with the same bits as [`Self::eval`]. Sources that need
    /// angles use the angles of the block, which are computed once for all sources.
    fn eval_block(&self, block: PairBlock<'_>, tally: &mut Tally, values: &mut [[f64; 3]]) {
        for (value, pair) in values.iter_mut().zip(block.pairs()) {
            *value = self.eval(*pair, tally);
        }
    }

    /// The symmetries that `eval` obeys exactly, up to rounding.
    fn symmetry(&self) -> Symmetry;

    /// Returns true if all three channels are equal everywhere, so that one channel is enough.
    fn is_grey(&self) -> bool {
        false
    }

    /// Directions at which values are known: for a cropped pack, its range. Elsewhere `eval` gives the nearest known
    /// value.
    fn directions(&self) -> DirectionRange {
        DirectionRange::ALL
    }

    /// The samples that may not determine the source; `None` if all values are known, or interpolated in small cells.
    fn samples(&self) -> Option<&dyn Samples> {
        self.completion().map(|completion| completion as &dyn Samples)
    }

    /// The samples that the source is completed from, which takes long; `None` if all values are known, or interpolated in cells.
    fn completion(&self) -> Option<&dyn Completion> {
        None
    }
}

/// Split of samples for cross-validation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parts {
    /// Every tenth sample: measures interpolation between neighbouring samples.
    Samples,
    /// Every tenth incidence (or a single one of fewer than ten), with all its samples: measures interpolation between
    /// incidences.
    Incidences,
}

/// Maximum number of folds of either kind.
pub const MAX_PARTS: usize = 10;

/// A source that is completed without some of the samples, and the omitted samples.
pub struct Fold {
    /// The source completed from the other samples.
    pub source: Box<dyn Source>,
    /// The omitted samples: direction pairs with their values, 1/sr.
    pub left_out: Vec<(DirectionPair, [f64; 3])>,
}

/// Direction pairs, including mirror images, that were measured more than once.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Repeats {
    /// Number of direction pairs that were measured more than once.
    pub pairs: usize,
    /// Share of these pairs among all direction pairs.
    pub share: f64,
    /// Sum over these pairs of the largest minus the smallest value, over the sum of the largest: 0 if all agree.
    pub spread: f64,
    /// The largest `1 - smallest / largest` of a channel.
    pub largest: f64,
}

/// Rise of the samples towards the mirror direction or back to the light, at the polar angle of incidence where samples determine
/// the peak there least. The diffuse part is subtracted from the values, which are multiplied by both cosines.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Rise {
    /// Direction of the peak.
    pub peak_at: PeakAt,
    /// Polar angle of incidence, degrees, a multiple of 5.
    pub incidence: f64,
    /// Root mean square half angle of the group of samples nearest to the direction of the peak, degrees.
    pub nearest: f64,
    /// Root mean square half angle of the next group of samples, degrees.
    pub next: f64,
    /// Mean value of the last samples before the next group over the mean value of the next group.
    pub ratio: f64,
    /// Peak of a GGX lobe through both means, over the mean value of the nearest group; at most 100.
    pub peak: f64,
}

/// Direction of a peak.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PeakAt {
    /// The mirror direction: a highlight.
    Mirror,
    /// Back to the light: retroreflection.
    Viewer,
}

/// A plateau at the largest value of a channel, or at the largest product with the cosine of the incidence, of the viewer or of both.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Saturation {
    /// Number of samples with the largest value.
    pub samples: usize,
    /// Largest angle between the half vector and the normal of these samples, degrees.
    pub farthest: f64,
}

/// Values that are multiples of one number, as of a file with few decimals.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Rounding {
    /// The number, 1/sr.
    pub step: f64,
    /// Mean error of rounding as a fraction of the value: a quarter of the step. Values below a twentieth of the median count as that.
    pub error: f64,
}

/// Maximum peak over the nearest samples of a highlight that samples determine.
pub const MAX_PEAK: f64 = 2.5;
/// Maximum ratio of the next samples and those before them: above it the width of the highlight is unknown, even if a sample
/// is on its peak.
pub const MAX_RISE: f64 = 30.0;

/// Maximum mean error of rounding, as a fraction of the value: about ΔE 1.
pub const MAX_ROUNDING: f64 = 0.02;

/// The samples of a source.
pub trait Samples: Sync {
    /// Distance of a direction pair from the nearest sample: the larger of the angles between their lights and between
    /// their viewers, radians. The sample may be rotated, mirrored or exchanged by the material's symmetries.
    fn distance(&self, pair: DirectionPair) -> f64;

    /// Rise of the samples towards the mirror direction or back to the light; `None` if too few are near them.
    fn rise(&self) -> Option<Rise>;

    /// A plateau at the largest value; `None` without one.
    fn saturation(&self) -> Option<Saturation>;

    /// Rounding of the values; `None` if they have no common step.
    fn rounding(&self) -> Option<Rounding>;
}

/// The samples that a source is completed from.
pub trait Completion: Samples {
    /// Number of folds, at most [`MAX_PARTS`]; 0 if all samples have the same incidence.
    fn fold_count(&self, parts: Parts) -> usize;

    /// A fold by its number; `None` if too few samples remain to complete a source.
    fn fold(&self, parts: Parts, number: usize) -> Option<Fold>;

    /// Repeated samples; `None` without any.
    fn repeats(&self) -> Option<Repeats>;

    /// Mean difference of samples from the fit to the others, with light and viewer exchanged, as a fraction of the larger value,
    /// less the estimated noise: 0 for reciprocal reflectance, and for differences that the error of the fit explains. `None` if too
    /// few exchanged samples are near others.
    fn exchanged(&self) -> Option<f64>;
}
