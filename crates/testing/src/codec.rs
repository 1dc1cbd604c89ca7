//! Interface between tests and each codec.

use crate::engines::Case;
use crate::golden::Hashes;
use crate::sampler::SamplerCase;
use brdfc_formats::Pack;
use std::ops::Range;

/// Packs by name.
pub type Files = Vec<(String, Vec<u8>)>;

/// An entry of a pack with measured values, and the range of bytes that has them; `None` for the whole entry.
pub type Measured = (&'static str, Option<Range<usize>>);

/// Test data of a codec, in addition to its descriptor.
pub trait TestedCodec {
    /// A small pack: tests change each bit of it.
    fn small_pack(&self, supercompress: bool) -> Vec<u8>;

    /// Packs with queries and the answers of the CPU decoder.
    fn cases(&self) -> Vec<Case>;

    /// Packs with queries and the error bounds of the sampler's filter against the CPU decoder. Empty if a shader has
    /// no sampler, or reads only single texels with it.
    fn sampler_cases(&self) -> Vec<SamplerCase> {
        Vec::new()
    }

    /// Packs of the golden folder that no encoder makes.
    fn committed(&self) -> Files {
        Vec::new()
    }

    /// Hashes of the values that the decoder reads from a pack, for the columns of the codec's lists except `contents`
    /// and `file`.
    ///
    /// # Panics
    /// If the pack is of another codec.
    fn hashes(&self, pack: Pack) -> Hashes;

    /// Entries of its packs that do not follow from the encoder's stored data.
    fn measured(&self) -> &'static [Measured] {
        &[]
    }
}
