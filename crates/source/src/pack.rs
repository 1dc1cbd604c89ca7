//! Packs as sources: what an engine would see.

use super::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};

/// A wavelet pack, decoded at a level of detail with bilinear filtering on both hemispheres.
#[derive(Debug)]
pub struct PackSource {
    decoder: WaveletDecoder,
    level: f32,
}

impl PackSource {
    /// `level` is the level of detail, `0.0..=N`; `None` is the finest.
    pub fn new(pack: &WaveletPack, level: Option<f32>) -> Self {
        Self { decoder: WaveletDecoder::new(pack), level: level.unwrap_or(pack.header.levels as f32) }
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
}
