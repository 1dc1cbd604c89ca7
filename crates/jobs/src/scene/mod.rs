//! Scenes: a manifest becomes packs.

pub mod manifest;
pub mod maps;
pub mod needs;
pub mod render_section;
pub mod run;
pub mod scene_section;
