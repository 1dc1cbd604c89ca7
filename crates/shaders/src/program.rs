//! Whole programs that draw, for WebGPU and for WebGL 2 alike.

use crate::parsed::Parsed;
use naga::back::glsl::{Options, PipelineOptions, ReflectionInfo, Version, Writer, WriterFlags};
use naga::proc::BoundsCheckPolicies;
use naga::{GlobalVariable, Handle, ShaderStage};
use serde::Serialize;

/// A vertex and a fragment shader.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Program {
    /// Both in WGSL, as they were given, without comments.
    pub wgsl: String,
    /// The vertex shader in GLSL ES 3.00. Attributes have the locations of the WGSL.
    pub vertex: String,
    /// The fragment shader in GLSL ES 3.00.
    pub fragment: String,
    /// Uniform blocks of the GLSL: those of both shaders.
    pub blocks: Vec<Named>,
    /// Textures of the GLSL, which has no samplers besides.
    pub textures: Vec<Named>,
}

/// What a binding of the WGSL is called in the GLSL.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Named {
    /// Its group.
    pub group: u32,
    /// Its number.
    pub binding: u32,
    /// Its name.
    pub name: String,
    /// Of a texture that is filtered, the sampler, which is of the same group.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampler: Option<u32>,
}

/// Translates WGSL with a vertex and a fragment entry point.
///
/// # Errors
/// What does not parse, is not valid, or cannot be said in GLSL ES 3.00.
pub fn program(wgsl: &str, vertex: &str, fragment: &str) -> Result<Program, String> {
    let parsed = Parsed::new(wgsl)?;
    let mut program = Program {
        wgsl: without_comments(wgsl),
        vertex: String::new(),
        fragment: String::new(),
        blocks: Vec::new(),
        textures: Vec::new(),
    };
    let stages = [(ShaderStage::Vertex, vertex), (ShaderStage::Fragment, fragment)];
    for (stage, entry_point) in stages {
        let options = Options {
            version: Version::Embedded { version: 300, is_webgl: true },
            writer_flags: WriterFlags::empty(),
            ..Options::default()
        };
        let pipeline = PipelineOptions { shader_stage: stage, entry_point: entry_point.to_owned(), multiview: None };
        let mut text = String::new();
        let policies = BoundsCheckPolicies::default();
        let mut writer = Writer::new(&mut text, &parsed.module, &parsed.info, &options, &pipeline, policies)
            .map_err(|error| error.to_string())?;
        let reflection = writer.write().map_err(|error| error.to_string())?;
        program.bind(&parsed, reflection);
        match stage {
            ShaderStage::Vertex => program.vertex = text,
            _ => program.fragment = text,
        }
    }
    // The writer says them in the order of a hash.
    program.blocks.sort();
    program.textures.sort();
    Ok(program)
}

impl Program {
    fn bind(&mut self, parsed: &Parsed, reflection: ReflectionInfo) {
        let bound = |handle: Handle<GlobalVariable>| parsed.module.global_variables[handle].binding;
        let named = |handle: Handle<GlobalVariable>, name: &str, sampler: Option<Handle<GlobalVariable>>| {
            let sampler = sampler.and_then(bound).map(|sampler| sampler.binding);
            bound(handle).map(|own| Named { group: own.group, binding: own.binding, name: name.to_owned(), sampler })
        };
        let blocks = reflection.uniforms.iter();
        self.blocks.extend(blocks.filter_map(|(handle, name)| named(*handle, name, None)));
        let textures = reflection.texture_mapping.iter();
        self.textures.extend(textures.filter_map(|(name, mapping)| named(mapping.texture, name, mapping.sampler)));
    }
}

/// Without comments, indentation and empty lines.
fn without_comments(text: &str) -> String {
    let bare = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
    bare.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWN: &str = "
@group(0) @binding(0) var<uniform> place: vec4<f32>; // where
@group(1) @binding(3) var colours: texture_2d<f32>;
@group(1) @binding(4) var smooth_: sampler;
@vertex fn corner(@location(2) at: vec2<f32>) -> @builtin(position) vec4<f32> { return vec4<f32>(at, 0.0, 1.0) + place; }
@fragment fn colour() -> @location(0) vec4<f32> { return textureSampleLevel(colours, smooth_, place.xy, 0.0); }
";

    #[test]
    fn bindings_are_told_by_their_names() {
        let made = program(DRAWN, "corner", "colour").unwrap();
        let bound = |all: &[Named]| all.iter().map(|one| (one.group, one.binding)).collect::<Vec<_>>();
        // A block has a name in each shader.
        assert_eq!((bound(&made.blocks), bound(&made.textures)), (vec![(0, 0), (0, 0)], vec![(1, 3)]));
        assert_eq!(made.textures[0].sampler, Some(4));
        for Named { name, .. } in &made.blocks {
            assert!(made.vertex.contains(name) || made.fragment.contains(name), "{name}");
        }
        assert!(made.fragment.contains(&format!("uniform highp sampler2D {};", made.textures[0].name)));
        assert!(made.vertex.contains("layout(location = 2) in vec2") && !made.wgsl.contains("// where"));
        assert_eq!(made, program(DRAWN, "corner", "colour").unwrap());
    }

    #[test]
    fn what_is_wrong_is_said() {
        assert!(program(DRAWN, "nothing", "colour").is_err());
        assert!(program("fn f() -> f32 { return 1u; }", "f", "f").unwrap_err().contains("return"));
    }
}
