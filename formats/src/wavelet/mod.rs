//! Wavelet BRDF packs (Claustres et al. 2007, "Wavelet encoding of BRDFs for real-time rendering"). Layout and
//! equations: `spec.md` in this folder.

mod brdf;
mod decode;
pub(crate) mod descriptor;
pub mod haar;
mod layout;
mod pack;
pub mod shader;

pub use decode::{DEFAULT_DISTANCE_SCALE, Filter, RowScratch, WaveletDecoder, level_of_detail};
pub use pack::{Header, MAX_LEVELS, MAX_SLICES, SliceScale, WaveletPack, gpu_bytes};
