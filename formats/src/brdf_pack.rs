//! Packs of reflectances: what engines draw materials from, of whichever codec.

use crate::bindings::Bindings;
use crate::crop::DirectionRange;
use crate::direction::DirectionPair;
use crate::table::{TableDecoder, TablePack};
use crate::wavelet::{Filter, WaveletDecoder, WaveletPack};

/// A pack of reflectances.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)]
pub enum BrdfPack {
    /// Kept slices of wavelet coefficients.
    Wavelet(WaveletPack),
    /// Logarithms over half-difference angles.
    Table(TablePack),
}

impl BrdfPack {
    /// What the codec is called.
    pub fn codec(&self) -> &'static str {
        match self {
            Self::Wavelet(_) => "wavelet",
            Self::Table(pack) if pack.curve().is_some() => "factored",
            Self::Table(_) => "table",
        }
    }

    /// Bytes on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        match self {
            Self::Wavelet(pack) => pack.gpu_bytes(),
            Self::Table(pack) => pack.gpu_bytes(),
        }
    }

    /// Directions that it is for.
    pub fn directions(&self) -> DirectionRange {
        match self {
            Self::Wavelet(pack) => pack.directions(),
            Self::Table(pack) => pack.directions(),
        }
    }

    /// Levels of detail besides the coarsest: the finest is level `levels`.
    pub fn levels(&self) -> u32 {
        match self {
            Self::Wavelet(pack) => pack.header.levels,
            Self::Table(pack) => pack.levels(),
        }
    }

    /// Texture fetches of one look-up at the finest level of detail with the filter that errors are measured with: of
    /// wavelet packs four reconstructions, of lifted ones sixteen.
    pub fn fetches(&self) -> u32 {
        match self {
            Self::Wavelet(pack) => (if pack.header.lifted { 16 } else { 4 }) * (4 * pack.header.levels + 1),
            Self::Table(pack) => pack.fetches(),
        }
    }

    /// What its shader has bound.
    pub fn bindings(&self) -> Bindings<'_> {
        match self {
            Self::Wavelet(pack) => pack.bindings(),
            Self::Table(pack) => pack.bindings(),
        }
    }

    /// The bytes of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        match self {
            Self::Wavelet(pack) => pack.to_bytes(supercompress),
            Self::Table(pack) => pack.to_bytes(supercompress),
        }
    }
}

/// A pack made ready for random access.
#[derive(Debug, Clone)]
pub enum BrdfDecoder {
    /// Of a wavelet pack.
    Wavelet(WaveletDecoder),
    /// Of a table pack.
    Table(TableDecoder),
}

impl BrdfDecoder {
    /// Unpacks a pack.
    pub fn new(pack: &BrdfPack) -> Self {
        match pack {
            BrdfPack::Wavelet(pack) => Self::Wavelet(WaveletDecoder::new(pack)),
            BrdfPack::Table(pack) => Self::Table(TableDecoder::new(pack)),
        }
    }

    /// Levels of detail, the coarsest not counted: 0 where there is one alone.
    pub fn levels(&self) -> u32 {
        match self {
            Self::Wavelet(decoder) => decoder.header().levels,
            Self::Table(decoder) => decoder.levels(),
        }
    }

    /// `f_r` at a direction pair, linear RGB, 1/sr, not negative. `filter` is that of wavelet packs; tables
    /// are filtered exactly.
    pub fn eval(&self, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3] {
        match self {
            Self::Wavelet(decoder) => decoder.eval(pair, level, filter),
            Self::Table(decoder) => decoder.eval_at(pair, level),
        }
    }
}
