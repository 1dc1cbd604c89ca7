//! Shaders compared with their CPU twins, and renderings compared with the reference renderer.

mod adaptive_twin;
mod bandwidth_twin;
mod common;
mod compute;
mod cropped_scene;
mod factored_twin;
mod flat_btf_twin;
mod flat_scenes;
mod importance_twin;
mod lobes_scenes;
mod propagation_twin;
mod pwt_scenes;
mod pwt_twin;
mod render_views;
mod shader_twin;
mod table_twin;
mod texel_features;
mod tint;
