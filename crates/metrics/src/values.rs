//! Values of sources.

use brdfc_core::pair_list::{BLOCK, PairList};
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::DirectionPair;
use rayon::prelude::*;

/// Direction pairs per unit of parallel work: fixed, so that sums do not depend on threads.
pub const CHUNK: usize = BLOCK;

/// Evaluates a source at direction pairs. The tally counts repairs.
pub fn values_at(source: &dyn Source, pairs: &[DirectionPair]) -> (Vec<[f64; 3]>, Tally) {
    each_chunk(pairs.len(), |number, values, tally| {
        for (value, pair) in values.iter_mut().zip(&pairs[number * CHUNK..]) {
            *value = source.eval(*pair, tally);
        }
    })
}

/// Evaluates a source at a list of pairs that other sources share.
pub fn values_of_list(source: &dyn Source, list: &PairList) -> (Vec<[f64; 3]>, Tally) {
    let fill =
        |number, values: &mut [[f64; 3]], tally: &mut Tally| source.eval_block(list.block(number), tally, values);
    let (values, tally) = each_chunk(list.len(), fill);
    (list.in_order(values), tally)
}

fn each_chunk(count: usize, fill: impl Fn(usize, &mut [[f64; 3]], &mut Tally) + Sync) -> (Vec<[f64; 3]>, Tally) {
    let mut values = vec![[0.0; 3]; count];
    let filled = |(number, values): (usize, &mut [[f64; 3]])| {
        let mut tally = Tally::default();
        fill(number, values, &mut tally);
        tally
    };
    let tallies: Vec<Tally> = values.par_chunks_mut(CHUNK).enumerate().map(filled).collect();
    let mut tally = Tally::default();
    tallies.into_iter().for_each(|counts| tally += counts);
    (values, tally)
}
