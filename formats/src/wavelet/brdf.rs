//! [`Brdf`] for wavelet packs.

use super::descriptor::DESCRIPTOR;
use super::{Filter, WaveletDecoder, WaveletPack};
use crate::bindings::Bindings;
use crate::crop::DirectionRange;
use crate::direction::DirectionPair;
use crate::{Brdf, BrdfDecoder, ErrorSummary};

impl Brdf for WaveletPack {
    fn variant(&self) -> &'static str {
        DESCRIPTOR.name
    }

    fn channels(&self) -> u32 {
        self.header.channels
    }

    fn mean(&self) -> f32 {
        self.header.mean
    }

    fn gpu_bytes(&self) -> u64 {
        self.gpu_bytes()
    }

    fn directions(&self) -> DirectionRange {
        self.directions()
    }

    fn levels(&self) -> u32 {
        self.header.levels
    }

    /// One reconstruction per inner cell. The scaling coefficient of a coarser level is read through the index map.
    fn fetches_at(&self, level: u32, filter: Filter) -> u32 {
        let inner = if filter == Filter::Bilinear { 4 } else { 1 };
        let scaling = if level < self.header.trees() { 2 } else { 1 };
        inner * (4 * level + scaling)
    }

    fn off_grid(&self) -> ErrorSummary {
        self.off_grid
    }

    fn bindings(&self) -> Bindings<'_> {
        self.bindings()
    }

    fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        self.to_bytes(supercompress)
    }

    fn decoder(&self) -> Box<dyn BrdfDecoder> {
        Box::new(WaveletDecoder::new(self))
    }
}

impl BrdfDecoder for WaveletDecoder {
    fn levels(&self) -> u32 {
        self.header().levels
    }

    fn is_grey(&self) -> bool {
        self.header().channels == 1
    }

    fn eval(&self, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3] {
        self.eval(pair, level, filter)
    }
}
