//! Everything that touches wgpu.

mod device;
mod draw;
mod evaluate;
mod flat_btf;
mod load;
mod pack;

pub use device::{AdapterChoice, AdapterDescription, Gpu, GpuError};
pub use draw::{Decoding, Renderer, SCENE_WGSL, Target};
pub use evaluate::{EVALUATE_WGSL, Evaluated, Evaluator, LoadedPack, LoadedPairs, SliceFilter};
pub use flat_btf::{EVALUATE_FLAT_BTF_WGSL, FlatBtfAnswer, FlatBtfEvaluator, FlatBtfQuery, LoadedFlatBtf};
pub use load::LoadedScene;
