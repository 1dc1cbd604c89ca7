//! Assembly of a decoder's shader in a language.

use crate::generated::Generated;
use crate::header;
use crate::interface::Interface;
use crate::language::Language;
use crate::signatures::signatures;
use brdfc_formats::PackKind;
use schemars::JsonSchema;
use serde::Serialize;

/// Entry point of the SPIR-V.
pub const ENTRY: &str = "evaluate";
/// Queries per workgroup of the SPIR-V.
pub const WORKGROUP: u32 = 64;

/// A decoder in a language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shader {
    /// Kind of pack that it decodes.
    pub decoder: PackKind,
    /// Its language.
    pub language: Language,
    /// Bindings and callable functions.
    pub interface: Interface,
    /// Entry point of SPIR-V; `None` for other languages.
    pub entry_point: Option<EntryPoint>,
    /// Contents of the file: text, or the words of SPIR-V, little-endian.
    pub bytes: Vec<u8>,
}

/// A compute shader that answers a list of queries. Its group 0 has the queries, three groups of four f32 each, in the
/// storage buffer of binding 0, and the answers, four f32 each, in the storage buffer of binding 1.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct EntryPoint {
    /// Its name.
    pub name: &'static str,
    /// Queries per workgroup, along x.
    pub workgroup: u32,
    /// Contents of a query.
    pub takes: &'static str,
    /// Contents of an answer.
    pub gives: &'static str,
}

/// Returns a decoder: declarations and functions to be pasted into a shader, or a compute shader in SPIR-V.
pub fn shader(decoder: PackKind, language: Language) -> Shader {
    let generated = Generated::of(decoder);
    let interface = generated.interface.clone();
    let headed = |text: &str, signatures: &[String]| {
        (header::header(decoder, language, &interface, signatures) + text).into_bytes()
    };
    let bytes = match language {
        Language::Wgsl => {
            let signatures: Vec<String> =
                interface.functions.iter().map(|function| function.signature.clone()).collect();
            headed(&(decoder.descriptor().wgsl)(), &signatures)
        }
        Language::Spirv => generated.spirv.iter().copied().flat_map(u32::to_le_bytes).collect(),
        Language::Glsl | Language::Essl300 | Language::Hlsl | Language::Msl => {
            let text = generated.text(language);
            headed(&text, &signatures(&text, &interface))
        }
    };
    let answer = decoder.descriptor().answer;
    let entry_point = (language == Language::Spirv).then_some(EntryPoint {
        name: ENTRY,
        workgroup: WORKGROUP,
        takes: answer.takes,
        gives: answer.gives,
    });
    Shader { decoder, language, interface, entry_point, bytes }
}
