//! From a decoder to a shader in a language.

use crate::decoder::Decoder;
use crate::interface::Interface;
use crate::language::Language;
use crate::parsed::Parsed;
use crate::{glsl, header, hlsl, msl, spirv};
use schemars::JsonSchema;
use serde::Serialize;

/// A decoder in a language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shader {
    /// Which decoder it is.
    pub decoder: Decoder,
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

/// A decoder that does not go into a language.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the decoder of {} does not go into {}: {message}", decoder.title(), language.title())]
pub struct ShaderError {
    /// The decoder.
    pub decoder: Decoder,
    /// The language.
    pub language: Language,
    /// What the translator says.
    pub message: String,
}

/// Translates a decoder: declarations and functions to be pasted into a shader, of SPIR-V a compute shader.
///
/// # Errors
/// What the translator cannot say in the language.
pub fn translate(decoder: Decoder, language: Language) -> Result<Shader, ShaderError> {
    let failed = |message: String| ShaderError { decoder, language, message };
    let source = decoder.wgsl();
    let parsed = Parsed::new(&source).map_err(failed)?;
    let interface = Interface::of(&source, &parsed.module, decoder.functions());
    let bytes = match language {
        Language::Wgsl => {
            let signatures: Vec<String> =
                interface.functions.iter().map(|function| function.signature.clone()).collect();
            (header::header(decoder, language, &interface, &signatures) + &source).into_bytes()
        }
        Language::Spirv => spirv::module(decoder, &source).map_err(failed)?,
        Language::Glsl | Language::Essl300 | Language::Hlsl | Language::Msl => {
            let (text, signatures) = match language {
                Language::Hlsl => hlsl::piece(&parsed, &interface),
                Language::Msl => msl::piece(&parsed, &interface),
                _ => glsl::piece(&source, &interface, language),
            }
            .map_err(failed)?;
            (header::header(decoder, language, &interface, &signatures) + &text).into_bytes()
        }
    };
    let answer = decoder.answer();
    let entry_point = (language == Language::Spirv).then_some(EntryPoint {
        name: spirv::ENTRY,
        workgroup: spirv::WORKGROUP,
        takes: answer.takes,
        gives: answer.gives,
    });
    Ok(Shader { decoder, language, interface, entry_point, bytes })
}
