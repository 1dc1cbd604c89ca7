//! Decoders of packs in the languages of engines: `brdfc shader`.
//!
//! Start with [`shader()`], which returns the decoder of a [`PackKind`] in a [`Language`]. [`open_pack`] reads a pack,
//! whose kind selects the decoder.

pub use brdfc_formats::{BrdfShader, PackKind};
pub use brdfc_shaders::{EntryPoint, Interface, Language, Shader, shader};
pub use brdfc_source::flat_btf::open_flat_btf;
pub use brdfc_source::pack::open_pack;
