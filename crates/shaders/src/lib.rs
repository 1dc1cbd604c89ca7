//! Decoders of packs in the shading languages of engines: the WGSL of `brdfc-formats`, translated by naga, with what has to be
//! bound told at the top.
//!
//! What comes out is a piece to be pasted into a shader: declarations and functions, no entry point. SPIR-V has no such
//! pieces: there it is a compute shader that decodes a list of queries.
//!
//! [`program`] translates whole programs, for pages that draw.

mod decoder;
mod glsl;
mod header;
mod hlsl;
mod interface;
mod language;
mod msl;
mod needs;
mod parsed;
mod program;
mod spirv;
mod translate;
mod words;

pub use decoder::Decoder;
pub use interface::{Binding, BindingKind, Field, Function, Interface};
pub use language::Language;
pub use needs::DeviceNeeds;
pub use program::{Named, Program, program};
pub use translate::{EntryPoint, Shader, ShaderError, translate};
