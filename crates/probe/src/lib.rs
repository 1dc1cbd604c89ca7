//! Runs decoders of packs, and any other WGSL function, over lists of queries. Tests compare the results with the CPU,
//! and studies measure them. The program does not include this crate.

mod brdf;
mod compute;
mod flat_btf;
mod items;
mod pwt;

pub use brdf::{
    EVALUATE_ENTRY_WGSL, EVALUATE_TABLE_WGSL, EVALUATE_WGSL, Evaluated, Evaluator, LoadedPack, LoadedPairs,
};
pub use compute::{COMPUTE_WGSL, Compute};
pub use flat_btf::{EVALUATE_FLAT_BTF_WGSL, FlatBtfAnswer, FlatBtfEvaluator, FlatBtfQuery, LoadedFlatBtf};
pub use pwt::{EVALUATE_PWT_WGSL, LoadedPwt, PwtAnswer, PwtEvaluator, PwtQuery};
