//! Packs as sources, with the values that an engine computes.

use super::pair_list::PairBlock;
use super::{Source, Symmetry, Tally};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::Filter;
use brdfc_formats::{Brdf, BrdfDecoder};

/// A BRDF pack, decoded at a level of detail with the filter of error measurements: wavelet packs bilinearly on both
/// hemispheres, tables exactly.
#[derive(Debug)]
pub struct PackSource {
    decoder: Box<dyn BrdfDecoder>,
    directions: DirectionRange,
    level: f32,
}

impl PackSource {
    /// Unpacks a pack. `level` is the level of detail, from 0 to the pack's [`Brdf::levels`]; `None` is the finest.
    pub fn new(pack: &dyn Brdf, level: Option<f32>) -> Self {
        let level = level.unwrap_or(pack.levels() as f32);
        Self { decoder: pack.decoder(), directions: pack.directions(), level }
    }
}

impl Source for PackSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        self.decoder.eval(pair, self.level, Filter::Bilinear).map(f64::from)
    }

    fn eval_block(&self, block: PairBlock<'_>, tally: &mut Tally, values: &mut [[f64; 3]]) {
        tally.evaluations += values.len() as u64;
        self.decoder.eval_block(block.pairs(), &|| block.of_tables(), self.level, values);
    }

    fn symmetry(&self) -> Symmetry {
        self.decoder.symmetry()
    }

    fn is_grey(&self) -> bool {
        self.decoder.is_grey()
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }
}
