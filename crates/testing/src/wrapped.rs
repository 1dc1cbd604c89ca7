//! Deliberately wrong sources.

use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;

/// Claims symmetries, true or false, regardless of the source's own.
pub struct Claiming(pub Box<dyn Source>, pub Symmetry);

impl Source for Claiming {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        self.0.eval(pair, tally)
    }

    fn symmetry(&self) -> Symmetry {
        self.1
    }

    fn is_grey(&self) -> bool {
        self.0.is_grey()
    }
}

/// Darker towards grazing incidence, so not reciprocal, and declares no reciprocity.
pub struct OneWay(pub Box<dyn Source>);

impl Source for OneWay {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        self.0.eval(pair, tally).map(|f| f * (0.2 + 0.8 * pair.incoming[2]))
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::NONE
    }

    fn is_grey(&self) -> bool {
        self.0.is_grey()
    }
}

/// Multiplies each value by `1 ± amplitude`, a fixed function of the directions and the seed.
pub struct Noisy {
    pub source: Box<dyn Source>,
    pub amplitude: f64,
    pub seed: u64,
}

impl Source for Noisy {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        let mut hash = self.seed;
        for component in pair.incoming.into_iter().chain(pair.outgoing) {
            hash = (hash ^ component.to_bits()).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
        }
        let uniform = (hash >> 11) as f64 / (1u64 << 53) as f64;
        self.source.eval(pair, tally).map(|f| f * (1.0 + self.amplitude * (2.0 * uniform - 1.0)))
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::NONE
    }

    fn is_grey(&self) -> bool {
        self.source.is_grey()
    }
}
