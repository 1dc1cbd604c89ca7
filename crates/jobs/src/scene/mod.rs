//! Scenes: builds of packs from a manifest or a list of files.

pub mod batch;
pub mod build;
pub mod current;
mod error;
pub mod explain;
pub mod gates;
pub mod graph;
mod grid_cache;
pub mod inputs;
pub mod lobes;
pub mod manifest;
pub mod maps;
pub mod memory;
pub mod names;
pub mod needs;
pub mod patterns;
mod place;
pub mod plan;
pub mod render_section;
pub mod run;
pub mod scene_section;
mod shapes;
pub mod textures;
pub mod uses;
mod verdict;
pub mod watch;
pub mod works;
