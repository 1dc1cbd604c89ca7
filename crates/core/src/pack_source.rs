//! Packs as sources: what an engine would see.

use super::pair_list::PairBlock;
use super::{Source, Symmetry, Tally};
use brdfc_formats::BrdfPack;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::{TableDecoder, TablePack};
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};

/// A pack of either codec, decoded at a level of detail; `None` is the finest.
pub fn decoded(pack: &BrdfPack, level: Option<f32>) -> Box<dyn Source> {
    match pack {
        BrdfPack::Wavelet(pack) => Box::new(PackSource::new(pack, level)),
        BrdfPack::Table(pack) => Box::new(TableSource::at(pack, level)),
    }
}

/// A wavelet pack, decoded at a level of detail with bilinear filtering on both hemispheres.
#[derive(Debug)]
pub struct PackSource {
    decoder: WaveletDecoder,
    directions: DirectionRange,
    level: f32,
}

impl PackSource {
    /// `level` is the level of detail, `0.0..=N`; `None` is the finest.
    pub fn new(pack: &WaveletPack, level: Option<f32>) -> Self {
        let level = level.unwrap_or(pack.header.levels as f32);
        Self { decoder: WaveletDecoder::new(pack), directions: pack.directions(), level }
    }

    /// The decoder.
    pub fn decoder(&self) -> &WaveletDecoder {
        &self.decoder
    }
}

impl Source for PackSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        self.decoder.eval(pair, self.level, Filter::Bilinear).map(f64::from)
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::NONE
    }

    fn is_grey(&self) -> bool {
        self.decoder.header().channels == 1
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }
}

/// A table pack, filtered exactly.
#[derive(Debug)]
pub struct TableSource {
    decoder: TableDecoder,
    directions: DirectionRange,
    level: f32,
}

impl TableSource {
    /// Unpacks a pack, to be evaluated at its finest level of detail.
    pub fn new(pack: &TablePack) -> Self {
        Self::at(pack, None)
    }

    /// `level` is the level of detail, from 0 to the pack's number of levels; `None` is the finest.
    pub fn at(pack: &TablePack, level: Option<f32>) -> Self {
        let level = level.unwrap_or(pack.levels() as f32);
        Self { decoder: TableDecoder::new(pack), directions: pack.directions(), level }
    }
}

impl Source for TableSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        self.decoder.eval_at(pair, self.level).map(f64::from)
    }

    fn eval_block(&self, block: PairBlock<'_>, tally: &mut Tally, values: &mut [[f64; 3]]) {
        tally.evaluations += values.len() as u64;
        for ((value, pair), angles) in values.iter_mut().zip(block.pairs()).zip(block.of_tables()) {
            let found = if pair.is_above_horizon() { self.decoder.eval_angles(*angles, self.level) } else { [0.0; 3] };
            *value = found.map(f64::from);
        }
    }

    fn symmetry(&self) -> Symmetry {
        let header = self.decoder.header();
        let folds = header.symmetry;
        let mirror = if header.isotropic() { folds.mirror } else { folds.half_turn && folds.reflected };
        Symmetry { isotropic: header.isotropic(), mirror, reciprocal: folds.reciprocal }
    }

    fn is_grey(&self) -> bool {
        self.decoder.header().channels == 1
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }
}
