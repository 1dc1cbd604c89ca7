//! From a decoder to a shader in a language.

use crate::generated::Generated;
use crate::header;
use crate::interface::Interface;
use crate::language::Language;
use crate::signatures::signatures;
use brdfc_formats::PackKind;
use schemars::JsonSchema;
use serde::Serialize;

/// Entry point of SPIR-V.
pub const ENTRY: &str = "evaluate";
/// Queries of its workgroup.
pub const WORKGROUP: u32 = 64;

/// A decoder in a language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shader {
    /// Which decoder it is.
    pub decoder: PackKind,
    /// Its language.
    pub language: Language,
    /// What has to be bound, and what may be called.
    pub interface: Interface,
    /// Of SPIR-V, what runs.
    pub entry_point: Option<EntryPoint>,
    /// The file: text, or of SPIR-V its words, little-endian.
    pub bytes: Vec<u8>,
}

/// A compute shader that answers a list of queries: its group 0 has the queries, three groups of four f32 each, in the storage
/// buffer of binding 0, and the answers, four f32 each, in that of binding 1.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct EntryPoint {
    /// Its name.
    pub name: &'static str,
    /// Queries of a workgroup, along x.
    pub workgroup: u32,
    /// What a query holds.
    pub takes: &'static str,
    /// What an answer holds.
    pub gives: &'static str,
}

/// A decoder: declarations and functions to be pasted into a shader, of SPIR-V a compute shader.
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
