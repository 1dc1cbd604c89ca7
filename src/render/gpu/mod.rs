//! Everything that touches wgpu.

mod device;
mod draw;
mod evaluate;
mod pack;

pub use device::{AdapterChoice, AdapterDescription, Gpu, GpuError};
pub use draw::{Decoding, LoadedScene, Renderer, SCENE_WGSL, Target};
pub use evaluate::{EVALUATE_WGSL, Evaluated, Evaluator, LoadedPack, LoadedPairs, SliceFilter};
