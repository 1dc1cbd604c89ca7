//! Whole programs that draw, for both WebGPU and WebGL 2.

use serde::{Deserialize, Serialize};

/// A vertex and a fragment shader in GLSL ES 3.00, translated from one WGSL source.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TranslatedProgram {
    /// Lines of the vertex shader. Attributes have the locations of the WGSL.
    pub vertex: Vec<String>,
    /// Lines of the fragment shader.
    pub fragment: Vec<String>,
    /// Uniform blocks of both shaders.
    pub blocks: Vec<Named>,
    /// Textures. GLSL has no separate samplers.
    pub textures: Vec<Named>,
}

/// A vertex and a fragment shader.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Program {
    /// Both in WGSL, unchanged except for removed comments.
    pub wgsl: String,
    /// The vertex shader in GLSL ES 3.00. Attributes have the locations of the WGSL.
    pub vertex: String,
    /// The fragment shader in GLSL ES 3.00.
    pub fragment: String,
    /// Uniform blocks of both shaders in GLSL.
    pub blocks: Vec<Named>,
    /// Textures of the GLSL, which has no separate samplers.
    pub textures: Vec<Named>,
}

/// Name in the GLSL of a binding of the WGSL.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Named {
    /// Its group.
    pub group: u32,
    /// Its number.
    pub binding: u32,
    /// Its name.
    pub name: String,
    /// Sampler of a filtered texture, in the same group.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampler: Option<u32>,
}

impl Program {
    /// A source in WGSL with its translation.
    pub fn new(wgsl: &str, translated: &TranslatedProgram) -> Self {
        let text = |lines: &[String]| lines.iter().map(|line| format!("{line}\n")).collect();
        Self {
            wgsl: without_comments(wgsl),
            vertex: text(&translated.vertex),
            fragment: text(&translated.fragment),
            blocks: translated.blocks.clone(),
            textures: translated.textures.clone(),
        }
    }
}

/// Removes comments, indentation and empty lines.
fn without_comments(text: &str) -> String {
    let bare = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
    bare.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n")
}
