//! Test data of each codec, in a file of its name.

pub mod bandwidth;
pub mod environment;
pub mod flat_btf;
pub mod flat_btf_trees;
pub mod importance;
pub mod lobes;
pub mod pwt;
pub mod table;
pub mod wavelet;

use crate::codec::TestedCodec;
use crate::engines::Case;
use crate::golden::Hashes;
use crate::sampler::SamplerCase;
use brdfc_formats::{FormatError, Pack, PackKind};

/// Test data of a codec.
pub fn tested(kind: PackKind) -> &'static dyn TestedCodec {
    match kind {
        PackKind::Table => &table::Table,
        PackKind::Wavelet => &wavelet::Wavelet,
        PackKind::FlatBtf => &flat_btf::FlatBtf,
        PackKind::FlatBtfTrees => &flat_btf_trees::FlatBtfTrees,
        PackKind::Pwt => &pwt::Pwt,
        PackKind::Bandwidth => &bandwidth::Bandwidth,
        PackKind::Importance => &importance::Importance,
        PackKind::Environment => &environment::Environment,
        PackKind::Lobes => &lobes::Lobes,
    }
}

/// The cases of all codecs. Each codec has at least one.
pub fn cases() -> Vec<Case> {
    let of_kind = |kind| {
        let cases = tested(kind).cases();
        assert!(!cases.is_empty() && cases.iter().all(|case| case.decoder == kind), "{}", kind.name());
        cases
    };
    PackKind::ALL.into_iter().flat_map(of_kind).collect()
}

/// The cases of all codecs with the sampler filtering. Their texels are random, so that neighbours differ as much as
/// possible, more than in any material.
pub fn sampler_cases() -> Vec<SamplerCase> {
    PackKind::ALL.into_iter().flat_map(|kind| tested(kind).sampler_cases()).collect()
}

/// Hashes of the values that the decoder of its kind reads from one file.
///
/// # Errors
/// Returns the error of the reader.
pub fn of_pack(bytes: &[u8]) -> Result<Hashes, FormatError> {
    let pack = Pack::from_bytes(bytes)?;
    Ok(tested(pack.kind()).hashes(pack))
}
