//! The main job: a scene manifest becomes packs. What no use asks for is not opened, computed or written.

pub mod btf_stack;
pub mod cache;
pub mod flatten;
pub mod manifest;
pub mod maps;
pub mod needs;
pub mod render_section;
pub mod run;
pub mod scene_section;
pub mod stage_clock;
pub mod write;
