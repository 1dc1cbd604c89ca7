//! Everything that touches wgpu.

mod adaptive;
mod bindings;
mod compute;
mod device;
mod draw;
mod evaluate;
mod flat;
mod flat_btf;
mod flat_textures;
mod items;
mod load;
mod pack;
mod pwt;
mod pwt_scene;
mod pwt_textures;
mod raster;
mod surface;
pub mod verify;

pub use adaptive::{AdaptiveRenderer, AdaptiveShaders, LoadedAdaptive, LoadedGBuffer};
pub use bindings::texture_format;
pub use compute::{COMPUTE_WGSL, Compute};
pub use device::{AdapterChoice, AdapterDescription, Gpu, GpuError};
pub use draw::{Decoding, Renderer, SCENE_WGSL, scene_source};
pub use evaluate::{
    EVALUATE_ENTRY_WGSL, EVALUATE_TABLE_WGSL, EVALUATE_WGSL, Evaluated, Evaluator, LoadedPack, LoadedPairs, SliceFilter,
};
pub use flat::{FLAT_SCENE_WGSL, FlatRenderer, draw_flat_btf, flat_scene_source};
pub use flat_btf::{EVALUATE_FLAT_BTF_WGSL, FlatBtfAnswer, FlatBtfEvaluator, FlatBtfQuery, LoadedFlatBtf};
pub use load::LoadedScene;
pub use pwt::{EVALUATE_PWT_WGSL, LoadedPwt, PwtAnswer, PwtEvaluator, PwtQuery};
pub use pwt_scene::{PWT_SCENE_WGSL, PwtRenderer, draw_pwt, pwt_scene_source};
pub use raster::{Target, view_wgsl};
pub use surface::{ENVIRONMENT_WGSL, PERIODIC_WGSL, SURFACE_WGSL};
