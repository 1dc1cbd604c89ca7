//! What every stage shares, without files: reflectance that can be evaluated at a direction pair, tallies of repairs, progress
//! and cancelling, and numbers as people write and read them.

pub mod address;
pub mod analytic;
pub mod byte_count;
mod describe;
pub mod half_difference;
mod pack_source;
pub mod pair_list;
pub mod progress;
mod stray_rows;
mod tally;
pub mod whole_number;
pub mod words;

pub use brdfc_formats::Symmetry;
pub use describe::Describe;
pub use pack_source::PackSource;
pub use stray_rows::StrayRows;
pub use tally::Tally;

use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;
use pair_list::PairBlock;

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
}
