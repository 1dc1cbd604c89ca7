//! Direction pairs that one source after another is evaluated at, with the angles that looking them up begins with.

use super::half_difference::HalfDifference;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::Angles;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// Pairs per block: fixed, so that sums over blocks do not depend on threads.
pub const BLOCK: usize = 1024;

/// Direction pairs. Their angles depend on no source: they are found when the first source asks for them, block by block, and
/// kept. That is at most 40 bytes beside the 48 of a pair.
#[derive(Debug, Clone)]
pub struct PairList {
    pairs: Vec<DirectionPair>,
    angles: Vec<BlockAngles>,
}

#[derive(Debug, Clone, Default)]
struct BlockAngles {
    half_difference: OnceLock<Vec<HalfDifference>>,
    of_tables: OnceLock<Vec<Angles>>,
}

impl PairList {
    /// Of pairs in this order.
    pub fn new(pairs: Vec<DirectionPair>) -> Self {
        let angles = pairs.chunks(BLOCK).map(|_| BlockAngles::default()).collect();
        Self { pairs, angles }
    }

    /// The list that a cell holds, made when it is first asked for: of constants that many sources are evaluated at.
    ///
    /// The cell is not locked meanwhile, so that `make` may work on all threads. Of two that make the list at once one throws
    /// its own away.
    pub fn kept(cell: &OnceLock<Arc<Self>>, make: impl FnOnce() -> Vec<DirectionPair>) -> Arc<Self> {
        if let Some(list) = cell.get() {
            return Arc::clone(list);
        }
        let list = Arc::new(Self::new(make()));
        Arc::clone(cell.get_or_init(|| list))
    }

    /// How many blocks there are; all but the last have [`BLOCK`] pairs.
    pub fn block_count(&self) -> usize {
        self.angles.len()
    }

    /// The block of this number.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn block(&self, number: usize) -> PairBlock<'_> {
        let first = number * BLOCK;
        let end = self.pairs.len().min(first + BLOCK);
        PairBlock { pairs: &self.pairs[first..end], angles: &self.angles[number] }
    }
}

impl Deref for PairList {
    type Target = [DirectionPair];

    fn deref(&self) -> &[DirectionPair] {
        &self.pairs
    }
}

/// Lists of the same pairs are the same.
impl PartialEq for PairList {
    fn eq(&self, other: &Self) -> bool {
        self.pairs == other.pairs
    }
}

/// Some pairs of a list.
#[derive(Debug, Clone, Copy)]
pub struct PairBlock<'a> {
    pairs: &'a [DirectionPair],
    angles: &'a BlockAngles,
}

impl<'a> PairBlock<'a> {
    /// The pairs.
    pub fn pairs(self) -> &'a [DirectionPair] {
        self.pairs
    }

    /// Where each is in tables in the layout of MERL.
    pub fn half_difference(self) -> &'a [HalfDifference] {
        self.angles.half_difference.get_or_init(|| self.pairs.iter().copied().map(HalfDifference::of).collect())
    }

    /// Where each is in table packs.
    pub fn of_tables(self) -> &'a [Angles] {
        self.angles.of_tables.get_or_init(|| self.pairs.iter().copied().map(Angles::of).collect())
    }
}
