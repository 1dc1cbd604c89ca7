//! Decoders of packs in the shading languages of engines: the WGSL of `brdfc-formats`, translated ahead of time, with a
//! header that lists the bindings.
//!
//! The output is a fragment of source to be pasted into a shader: declarations and functions, no entry point. SPIR-V
//! has no such fragments, so its output is a compute shader that decodes a list of queries.
//!
//! [`Program`] is a whole program, for pages that draw.

mod generated;
mod header;
mod interface;
mod language;
mod needs;
mod program;
mod shader;
mod signatures;
mod words;

pub use generated::Generated;
pub use interface::{Binding, BindingKind, Field, Function, Interface};
pub use language::Language;
pub use needs::DeviceNeeds;
pub use program::{Named, Program, TranslatedProgram};
pub use shader::{ENTRY, EntryPoint, Shader, WORKGROUP, shader};
