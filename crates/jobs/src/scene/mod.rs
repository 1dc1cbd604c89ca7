//! Scenes: a manifest, or a list of files, becomes packs.

pub mod batch;
pub mod build;
pub mod current;
mod error;
pub mod gates;
pub mod graph;
pub mod manifest;
pub mod maps;
pub mod memory;
pub mod names;
pub mod needs;
mod place;
pub mod plan;
pub mod render_section;
pub mod run;
pub mod scene_section;
pub mod watch;
pub mod works;
