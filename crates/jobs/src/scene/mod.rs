//! Scenes: a manifest becomes packs.

mod error;
pub mod manifest;
pub mod maps;
pub mod needs;
mod place;
pub mod render_section;
pub mod run;
pub mod scene_section;
