//! GPU renderer and device access, built on wgpu.

mod adaptive;
pub mod bindings;
mod device;
mod draw;
mod flat;
pub mod flat_textures;
mod load;
mod lobes_scene;
pub mod pack;
mod pwt_scene;
pub mod pwt_textures;
mod raster;
mod surface;
pub mod verify;

pub use adaptive::{AdaptiveRenderer, AdaptiveShaders, LoadedAdaptive, LoadedGBuffer};
pub use bindings::texture_format;
pub use device::{AdapterChoice, AdapterDescription, Gpu, GpuError};
pub use draw::{Decoding, Renderer, SliceFilter, scene_source};
pub use flat::{LoadedFlatBtf, draw_flat_btf, draw_flat_btf_by, flat_scene_source};
pub use load::LoadedScene;
pub use lobes_scene::{LobesRenderer, draw_lobes, lobes_scene_source};
pub use pwt_scene::{draw_pwt, draw_pwt_by, pwt_scene_source};
pub use raster::{Target, view_wgsl};
pub use surface::{ENVIRONMENT_WGSL, PERIODIC_WGSL, SURFACE_WGSL};
