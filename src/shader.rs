//! Decoders of packs in the languages of engines: `brdfc shader`.

pub use brdfc_formats::{BrdfShader, PackKind};
pub use brdfc_shaders::{EntryPoint, Interface, Language, Shader, shader};
pub use brdfc_source::flat_btf::open_flat_btf;
pub use brdfc_source::pack::open_pack;
