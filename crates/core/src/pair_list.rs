//! Direction pairs that one source after another is evaluated at, with the angles that looking them up begins with.

use super::half_difference::HalfDifference;
use brdfc_formats::direction::{DirectionPair, polynomial_atan2};
use brdfc_formats::table::Angles;
use rayon::prelude::*;
use std::f32::consts::FRAC_PI_2;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// Pairs per block: fixed, so that sums over blocks do not depend on threads.
pub const BLOCK: usize = 1024;

/// Direction pairs. Their angles depend on no source: they are found when the first source asks for them, block by block, and
/// kept. With what else is kept that is at most 100 bytes beside the 48 of a pair.
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
    /// Of each pair of the list, where it is among them.
    places: Vec<u32>,
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
        Self { pairs, visited: None, angles }
    }

    /// The list that a cell holds, made when it is first asked for: of constants that many sources are evaluated at, in an order
    /// in which a large table is read from its beginning to its end.
    ///
    /// The cell is not locked meanwhile, so that `make` may work on all threads. Of two that make the list at once one throws
    /// its own away.
    pub fn kept(cell: &OnceLock<Arc<Self>>, make: impl FnOnce() -> Vec<DirectionPair>) -> Arc<Self> {
        if let Some(list) = cell.get() {
            return Arc::clone(list);
        }
        let list = Self::new(make());
        let visited = Some(Visited::of(&list.pairs));
        Arc::clone(cell.get_or_init(|| Arc::new(Self { visited, ..list })))
    }

    /// How many blocks there are; all but the last have [`BLOCK`] pairs.
    pub fn block_count(&self) -> usize {
        self.angles.len()
    }

    /// The block of this number: pairs that are evaluated one after the other. [`Self::in_order`] puts what is found of all
    /// blocks in the order of the list.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn block(&self, number: usize) -> PairBlock<'_> {
        let first = number * BLOCK;
        let end = self.pairs.len().min(first + BLOCK);
        let pairs = self.visited.as_ref().map_or(&self.pairs, |visited| &visited.pairs);
        PairBlock { pairs: &pairs[first..end], angles: &self.angles[number] }
    }

    /// What was found of the pairs of all blocks, in the order of the list.
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
    /// By rings, as a table in the layout of MERL has them one after the other.
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

/// The ring that a pair is in, roughly: it decides what is near, not what is found.
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

/// Lists of the same pairs are the same.
impl PartialEq for PairList {
    fn eq(&self, other: &Self) -> bool {
        self.pairs == other.pairs
    }
}

/// Some pairs of a list, in the order in which they are evaluated.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(count: usize) -> Vec<DirectionPair> {
        let turn = |k: usize, step: f64| (k as f64 * step).fract();
        let pair =
            |k| DirectionPair::from_angles(1.6 * turn(k, 0.7548), 6.3 * turn(k, 0.5698), 1.5 * turn(k, 0.618), 0.3);
        (0..count).map(pair).collect()
    }

    /// Whatever order they are evaluated in, what is found stands in that of the list.
    #[test]
    fn kept_lists_are_evaluated_by_rings_and_come_back_in_order() {
        static CELL: OnceLock<Arc<PairList>> = OnceLock::new();
        let expected = pairs(3 * BLOCK + 17);
        let list = PairList::kept(&CELL, || expected.clone());
        assert_eq!((&list[..], list.block_count()), (&expected[..], 4));
        let evaluated = |list: &PairList| -> Vec<DirectionPair> {
            (0..list.block_count()).flat_map(|k| list.block(k).pairs().to_vec()).collect()
        };
        let visited = evaluated(&list);
        let of_rings: Vec<usize> = visited.iter().copied().map(ring).collect();
        assert!(of_rings.is_sorted() && visited != expected);
        assert_eq!(list.in_order(visited), expected);
        assert!(Arc::ptr_eq(&list, &PairList::kept(&CELL, || unreachable!("it is kept"))));
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
