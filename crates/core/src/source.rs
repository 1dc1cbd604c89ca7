//! What a source is: reflectance that can be evaluated at any direction pair, and, where it was completed from samples, what it takes to
//! see how well they predict each other.

use super::Tally;
use super::pair_list::PairBlock;
use brdfc_formats::Symmetry;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;

/// A reflectance function that can be asked for `f_r` anywhere.
pub trait Source: Send + Sync {
    /// `f_r` at a direction pair, linear RGB, 1/sr.
    ///
    /// Values are what the data says: interpolated measurements may be slightly negative. Zero where either direction
    /// is at or below the horizon (`z <= 0`). What had to be mended on the way is counted in `tally`.
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3];

    /// Values at the pairs of a block, which has as many: the same bits as those of [`Self::eval`]. Sources that look up angles
    /// first take the block's, which are found once for all sources.
    fn eval_block(&self, block: PairBlock<'_>, tally: &mut Tally, values: &mut [[f64; 3]]) {
        for (value, pair) in values.iter_mut().zip(block.pairs()) {
            *value = self.eval(*pair, tally);
        }
    }

    /// The symmetries that `eval` obeys exactly, up to rounding.
    fn symmetry(&self) -> Symmetry;

    /// Whether all three channels are equal everywhere, so that one is enough.
    fn is_grey(&self) -> bool {
        false
    }

    /// Directions at which values are known: of a pack that was made for some only, these. Elsewhere `eval` gives the nearest
    /// that there are.
    fn directions(&self) -> DirectionRange {
        DirectionRange::ALL
    }

    /// The samples that the source is completed from; `None` where values between them are known, or interpolated in cells.
    fn completion(&self) -> Option<&dyn Completion> {
        None
    }
}

/// How samples are parted for cross-validation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parts {
    /// Every tenth sample: how well a gap within what was measured is filled.
    Samples,
    /// Every tenth incidence, or one of fewer, with all its samples: how well a gap between incidences is filled.
    Incidences,
}

/// Most parts of either kind.
pub const MAX_PARTS: usize = 10;

/// A source that is completed without some of the samples, and these.
pub struct Fold {
    /// What the others give.
    pub source: Box<dyn Source>,
    /// The samples that were left out: direction pairs with their values, 1/sr.
    pub left_out: Vec<(DirectionPair, [f64; 3])>,
}

/// Samples of one direction pair, mirror images included, that were measured more than once.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Repeats {
    /// Direction pairs that were measured more than once.
    pub pairs: usize,
    /// Their share of all direction pairs.
    pub share: f64,
    /// Sum over them of largest minus smallest values, as a share of the sum of the largest: 0 where all agree.
    pub spread: f64,
    /// The largest `1 - smallest / largest` of a channel.
    pub largest: f64,
}

/// How samples rise towards the mirror direction, at the polar angle of incidence where they tell least of a highlight. Values are
/// those above the diffuse part, times both cosines.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Rise {
    /// Polar angle of incidence, degrees, to 5.
    pub incidence: f64,
    /// Half angle of the samples that are nearest to the mirror direction, degrees.
    pub nearest: f64,
    /// Half angle of the next ones, degrees.
    pub next: f64,
    /// Mean value of the nearest over that of the next.
    pub ratio: f64,
    /// The peak over the nearest, were it a lobe of GGX through both; at most 100.
    pub peak: f64,
}

/// Estimated peak over the nearest samples from which on a highlight is narrower than they tell.
pub const MAX_PEAK: f64 = 2.5;
/// Ratio of the nearest samples and the next from which on they leave a highlight's width open, though one may lie on its peak.
pub const MAX_RISE: f64 = 30.0;

/// The samples that a source is completed from.
pub trait Completion: Sync {
    /// How many folds there are, at most [`MAX_PARTS`]; 0 where the samples have one incidence alone.
    fn fold_count(&self, parts: Parts) -> usize;

    /// One of the folds; nothing where too few samples are left to complete a source from.
    fn fold(&self, parts: Parts, number: usize) -> Option<Fold>;

    /// The larger of the angles between the lights and between the viewers of a direction pair and of the nearest sample, which
    /// may be turned, mirrored or exchanged as the material's symmetries allow; radians.
    fn distance(&self, pair: DirectionPair) -> f64;

    /// Samples that repeat; nothing where none does.
    fn repeats(&self) -> Option<Repeats>;

    /// How fast samples rise towards the mirror direction; nothing where too few are near it.
    fn rise(&self) -> Option<Rise>;
}
