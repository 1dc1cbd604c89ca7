//! Byte layouts, CPU decoders and shaders of packs.
//!
//! An engine that loads packs needs only this crate. Each layout is specified normatively in the `spec.md` of its
//! module: `src/*/spec.md`.
//!
//! Conventions: the local frame is x = tangent, y = bitangent, z = normal; directions are unit vectors that point away
//! from the surface (`incoming` to the light, `outgoing` to the viewer); values are `f_r` in 1/sr, linear RGB with
//! Rec. 709 primaries.

mod arc_tangent;
pub mod bandwidth;
pub mod bindings;
mod brdf_pack;
mod combined;
pub mod container;
pub mod crop;
pub mod cursor;
mod descriptor;
pub mod direction;
pub mod direction_mesh;
pub mod direction_set;
pub mod environment;
mod error;
mod error_summary;
pub mod flat_btf;
pub mod flat_btf_trees;
pub mod importance;
#[macro_use]
mod kind;
pub mod lobes;
pub mod memory;
pub mod pwt;
mod symmetry;
pub mod table;
pub mod tap;
pub mod vector_math;
pub mod wavelet;
pub mod words;

pub use brdf_pack::{Brdf, BrdfDecoder};
pub use combined::combined_wgsl;
pub use descriptor::{Answer, BrdfShader, Descriptor, StructAnswer};
pub use error::{Finding, FormatError, Place};
pub use error_summary::{ErrorSummary, RenderingSummary};
pub use symmetry::Symmetry;

use bandwidth::BandwidthMap;
use environment::EnvironmentPack;
use flat_btf::FlatBtfFile;
use importance::ImportancePack;
use lobes::LobesPack;
use pwt::PwtPack;
use table::TablePack;
use wavelet::WaveletPack;

// One line per codec.
codecs! {
    brdfs: {
        /// A table pack, plain or factored.
        Table(TablePack): table;
        /// A wavelet BRDF pack.
        Wavelet(WaveletPack): wavelet;
    }
    others: {
        /// A flat BTF.
        FlatBtf(Box<FlatBtfFile>): FlatBtfFile, flat_btf;
        /// A flat BTF whose reflectance is polynomial wavelet trees.
        FlatBtfTrees(Box<FlatBtfFile>): FlatBtfFile, flat_btf_trees;
        /// A polynomial wavelet tree.
        Pwt(PwtPack): PwtPack, pwt;
        /// A bandwidth map.
        Bandwidth(BandwidthMap): BandwidthMap, bandwidth;
        /// Importance samples.
        Importance(ImportancePack): ImportancePack, importance;
        /// A prefiltered environment.
        Environment(EnvironmentPack): EnvironmentPack, environment;
        /// Lobes of a BRDF.
        Lobes(LobesPack): LobesPack, lobes;
    }
}

/// The examples of the README compile.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
