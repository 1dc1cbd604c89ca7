//! Values of sources.

use brdfc_formats::direction::DirectionPair;
use brdfc_source::{Source, Tally};
use rayon::prelude::*;

/// Direction pairs per unit of parallel work: fixed, so that sums do not depend on threads.
pub const CHUNK: usize = 1024;

/// Values of a source at direction pairs, with what had to be repaired.
pub fn values_at(source: &dyn Source, pairs: &[DirectionPair]) -> (Vec<[f64; 3]>, Tally) {
    let parts: Vec<(Vec<[f64; 3]>, Tally)> = pairs
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut tally = Tally::default();
            (chunk.iter().map(|pair| source.eval(*pair, &mut tally)).collect(), tally)
        })
        .collect();
    let mut tally = Tally::default();
    parts.iter().for_each(|(_, counts)| tally += *counts);
    (parts.into_iter().flat_map(|(values, _)| values).collect(), tally)
}
