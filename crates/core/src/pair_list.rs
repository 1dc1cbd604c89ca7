//! Lists of direction pairs at which several sources are evaluated, with the angles of their look-ups.

use super::half_difference::HalfDifference;
use brdfc_formats::direction::{DirectionPair, polynomial_atan2};
use brdfc_formats::table::Angles;
use rayon::prelude::*;
use std::f32::consts::FRAC_PI_2;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// Number of pairs per block: fixed, so that sums over blocks do not depend on threads.
pub const BLOCK: usize = 1024;

/// List of direction pairs. Their angles are the same for all sources: the first source that needs them computes them,
/// block by block, and the list caches them. All caches take at most 100 bytes per pair, in addition to the pair's 48.
#[derive(Debug, Clone)]
pub struct PairList {
    pairs: Vec<DirectionPair>,
    visited: Option<Visited>,
    angles: Vec<BlockAngles>,
}

/// Pairs in the order in which they are evaluated.
#[derive(Debug, Clone)]
struct Visited {
    pairs: Vec<DirectionPair>,
    /// Index into `pairs`, for each pair of the list.
    places: Vec<u32>,
}

#[derive(Debug, Clone, Default)]
struct BlockAngles {
    half_difference: OnceLock<Vec<HalfDifference>>,
    of_tables: OnceLock<Vec<Angles>>,
}

impl PairList {
    /// Creates a list of pairs, evaluated in this order.
    pub fn new(pairs: Vec<DirectionPair>) -> Self {
        let angles = pairs.chunks(BLOCK).map(|_| BlockAngles::default()).collect();
        Self { pairs, visited: None, angles }
    }

    /// The list in a cell, created at first use. It is for constant lists at which many sources are evaluated: the
    /// order of evaluation reads a large table from its beginning to its end.
    ///
    /// The cell is not locked while `make` runs, so that `make` may use all threads. If two threads create the list at
    /// once, one result is discarded.
    pub fn cached(cell: &OnceLock<Arc<Self>>, make: impl FnOnce() -> Vec<DirectionPair>) -> Arc<Self> {
        if let Some(list) = cell.get() {
            return Arc::clone(list);
        }
        let list = Self::new(make());
        let visited = Some(Visited::of(&list.pairs));
        Arc::clone(cell.get_or_init(|| Arc::new(Self { visited, ..list })))
    }

    /// Number of blocks; all but the last have [`BLOCK`] pairs.
    pub fn block_count(&self) -> usize {
        self.angles.len()
    }

    /// The block of this number: pairs that are evaluated one after the other. [`Self::in_order`] returns results of
    /// all blocks to the order of the list.
    ///
    /// # Panics
    /// Panics if the list has no such block.
    pub fn block(&self, number: usize) -> PairBlock<'_> {
        let first = number * BLOCK;
        let end = self.pairs.len().min(first + BLOCK);
        let pairs = self.visited.as_ref().map_or(&self.pairs, |visited| &visited.pairs);
        PairBlock { pairs: &pairs[first..end], angles: &self.angles[number] }
    }

    /// Reorders the results of all blocks to the order of the list.
    pub fn in_order<T: Copy + Send + Sync>(&self, found: Vec<T>) -> Vec<T> {
        match &self.visited {
            Some(visited) => {
                visited.places.par_iter().with_min_len(BLOCK).map(|place| found[*place as usize]).collect()
            }
            None => found,
        }
    }
}

/// Rings of a table in the layout of MERL along either polar angle.
const RINGS: usize = 90;

impl Visited {
    /// Sorts pairs by the rings of a table in the layout of MERL.
    fn of(pairs: &[DirectionPair]) -> Self {
        let rings: Vec<usize> = pairs.par_iter().with_min_len(BLOCK).copied().map(ring).collect();
        let mut ends = vec![0u32; RINGS * RINGS + 1];
        rings.iter().for_each(|ring| ends[ring + 1] += 1);
        (0..RINGS * RINGS).for_each(|ring| ends[ring + 1] += ends[ring]);
        let mut sorted = pairs.to_vec();
        let place = |(ring, pair): (&usize, &DirectionPair)| {
            let place = ends[*ring];
            ends[*ring] += 1;
            sorted[place as usize] = *pair;
            place
        };
        let places = rings.iter().zip(pairs).map(place).collect();
        Self { pairs: sorted, places }
    }
}

/// Approximate ring of a pair. It decides the order of evaluation, not the values.
fn ring(pair: DirectionPair) -> usize {
    let (i, o) = (pair.incoming.map(|c| c as f32), pair.outgoing.map(|c| c as f32));
    let sum = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
    let apart = [i[0] - o[0], i[1] - o[1], i[2] - o[2]];
    let length = |v: &[f32]| v.iter().map(|c| c * c).sum::<f32>().sqrt();
    let half = polynomial_atan2(length(&sum[..2]), sum[2]) / FRAC_PI_2;
    let difference = polynomial_atan2(length(&apart), length(&sum)) / FRAC_PI_2;
    let along = |share: f32| ((share * RINGS as f32) as usize).min(RINGS - 1);
    along(half.sqrt()) * RINGS + along(difference)
}

impl Deref for PairList {
    type Target = [DirectionPair];

    fn deref(&self) -> &[DirectionPair] {
        &self.pairs
    }
}

/// Lists are equal if their pairs are; caches and the order of evaluation do not count.
impl PartialEq for PairList {
    fn eq(&self, other: &Self) -> bool {
        self.pairs == other.pairs
    }
}

/// Consecutive pairs of a list, in the order of evaluation.
#[derive(Debug, Clone, Copy)]
pub struct PairBlock<'a> {
    pairs: &'a [DirectionPair],
    angles: &'a BlockAngles,
}

impl<'a> PairBlock<'a> {
    /// Direction pairs of the block, in the order of evaluation.
    pub fn pairs(self) -> &'a [DirectionPair] {
        self.pairs
    }

    /// Positions of the pairs in tables in the layout of MERL.
    pub fn half_difference(self) -> &'a [HalfDifference] {
        self.angles.half_difference.get_or_init(|| self.pairs.iter().copied().map(HalfDifference::of).collect())
    }

    /// Positions of the pairs in table packs.
    pub fn of_tables(self) -> &'a [Angles] {
        self.angles.of_tables.get_or_init(|| self.pairs.iter().copied().map(Angles::of).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(count: usize) -> Vec<DirectionPair> {
        let turn = |k: usize, step: f64| (k as f64 * step).fract();
        let pair =
            |k| DirectionPair::from_angles(1.6 * turn(k, 0.7548), 6.3 * turn(k, 0.5698), 1.5 * turn(k, 0.618), 0.3);
        (0..count).map(pair).collect()
    }

    /// Results are in the order of the list, independent of the order of evaluation.
    #[test]
    fn cached_lists_are_evaluated_by_rings_with_results_in_order() {
        static CELL: OnceLock<Arc<PairList>> = OnceLock::new();
        let expected = pairs(3 * BLOCK + 17);
        let list = PairList::cached(&CELL, || expected.clone());
        assert_eq!((&list[..], list.block_count()), (&expected[..], 4));
        let evaluated = |list: &PairList| -> Vec<DirectionPair> {
            (0..list.block_count()).flat_map(|k| list.block(k).pairs().to_vec()).collect()
        };
        let visited = evaluated(&list);
        let of_rings: Vec<usize> = visited.iter().copied().map(ring).collect();
        assert!(of_rings.is_sorted() && visited != expected);
        assert_eq!(list.in_order(visited), expected);
        assert!(Arc::ptr_eq(&list, &PairList::cached(&CELL, || unreachable!("it is cached"))));
        let plain = PairList::new(expected.clone());
        assert_eq!((evaluated(&plain), plain.in_order(expected.clone())), (expected.clone(), expected));
    }

    #[test]
    fn angles_are_those_of_each_pair() {
        let list = PairList::new(pairs(BLOCK + 5));
        for block in [list.block(0), list.block(1)] {
            for (k, pair) in block.pairs().iter().enumerate().filter(|(_, pair)| pair.is_above_horizon()) {
                assert_eq!(block.half_difference()[k], HalfDifference::of(*pair));
                assert_eq!(block.of_tables()[k], Angles::of(*pair));
            }
        }
    }
}
