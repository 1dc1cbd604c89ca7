//! Everything that touches wgpu.

mod device;
mod evaluate;
mod pack;

pub use device::{AdapterChoice, AdapterDescription, Gpu, GpuError};
pub use evaluate::{EVALUATE_WGSL, Evaluated, Evaluator, LoadedPack, LoadedPairs, SliceFilter};
