//! What tests ask of every codec.

use crate::engines::Case;
use crate::golden::Hashes;
use crate::sampler::SamplerCase;
use brdfc_formats::Pack;
use std::ops::Range;

/// Packs by name.
pub type Files = Vec<(String, Vec<u8>)>;

/// An entry of a pack that holds what was measured of it, and which of its bytes do: all of them where there is no range.
pub type Measured = (&'static str, Option<Range<usize>>);

/// What tests know of a codec besides its descriptor.
pub trait TestedCodec {
    /// A pack of few bytes: tests change each bit of it.
    fn small_pack(&self, supercompress: bool) -> Vec<u8>;

    /// Packs with queries and what the CPU decoder answers.
    fn cases(&self) -> Vec<Case>;

    /// Packs with queries and how far the sampler's filter may be from what the CPU decoder answers; none where a shader has no
    /// sampler, or asks it for single texels.
    fn sampler_cases(&self) -> Vec<SamplerCase> {
        Vec::new()
    }

    /// Packs of the golden folder that no encoder makes.
    fn committed(&self) -> Files {
        Vec::new()
    }

    /// What the decoder makes of a pack: hashes of the columns of the codec's lists but `contents` and `file`.
    ///
    /// # Panics
    /// Where the pack is of another codec.
    fn hashes(&self, pack: Pack) -> Hashes;

    /// What its packs hold that does not follow from what the encoder stores.
    fn measured(&self) -> &'static [Measured] {
        &[]
    }
}
