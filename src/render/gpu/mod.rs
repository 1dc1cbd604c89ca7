//! Everything that touches wgpu.

mod device;
mod draw;
mod evaluate;
mod load;
mod pack;

pub use device::{AdapterChoice, AdapterDescription, Gpu, GpuError};
pub use draw::{Decoding, Renderer, SCENE_WGSL, Target};
pub use evaluate::{EVALUATE_WGSL, Evaluated, Evaluator, LoadedPack, LoadedPairs, SliceFilter};
pub use load::LoadedScene;
