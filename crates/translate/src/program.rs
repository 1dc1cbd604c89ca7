//! Whole programs that draw.

use crate::parsed::Parsed;
use brdfc_shaders::{Named, TranslatedProgram};
use naga::back::glsl::{Options, PipelineOptions, ReflectionInfo, Version, Writer, WriterFlags};
use naga::proc::BoundsCheckPolicies;
use naga::{GlobalVariable, Handle, ShaderStage};

/// Translates WGSL with a vertex and a fragment entry point.
///
/// # Errors
/// What does not parse, is not valid, or cannot be said in GLSL ES 3.00.
pub fn program(wgsl: &str, vertex: &str, fragment: &str) -> Result<TranslatedProgram, String> {
    let parsed = Parsed::new(wgsl)?;
    let mut program = TranslatedProgram::default();
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
        bind(&mut program, &parsed, reflection);
        let lines = text.lines().map(str::to_owned).collect();
        match stage {
            ShaderStage::Vertex => program.vertex = lines,
            _ => program.fragment = lines,
        }
    }
    // The writer says them in the order of a hash.
    program.blocks.sort();
    program.textures.sort();
    Ok(program)
}

fn bind(program: &mut TranslatedProgram, parsed: &Parsed, reflection: ReflectionInfo) {
    let bound = |handle: Handle<GlobalVariable>| parsed.module.global_variables[handle].binding;
    let named = |handle: Handle<GlobalVariable>, name: &str, sampler: Option<Handle<GlobalVariable>>| {
        let sampler = sampler.and_then(bound).map(|sampler| sampler.binding);
        bound(handle).map(|own| Named { group: own.group, binding: own.binding, name: name.to_owned(), sampler })
    };
    let blocks = reflection.uniforms.iter();
    program.blocks.extend(blocks.filter_map(|(handle, name)| named(*handle, name, None)));
    let textures = reflection.texture_mapping.iter();
    program.textures.extend(textures.filter_map(|(name, mapping)| named(mapping.texture, name, mapping.sampler)));
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
        let contains = |lines: &[String], text: &str| lines.iter().any(|line| line.contains(text));
        let bound = |all: &[Named]| all.iter().map(|one| (one.group, one.binding)).collect::<Vec<_>>();
        // A block has a name in each shader.
        assert_eq!((bound(&made.blocks), bound(&made.textures)), (vec![(0, 0), (0, 0)], vec![(1, 3)]));
        assert_eq!(made.textures[0].sampler, Some(4));
        for Named { name, .. } in &made.blocks {
            assert!(contains(&made.vertex, name) || contains(&made.fragment, name), "{name}");
        }
        assert!(contains(&made.fragment, &format!("uniform highp sampler2D {};", made.textures[0].name)));
        assert!(contains(&made.vertex, "layout(location = 2) in vec2"));
        assert_eq!(made, program(DRAWN, "corner", "colour").unwrap());
    }

    #[test]
    fn what_is_wrong_is_said() {
        assert!(program(DRAWN, "nothing", "colour").is_err());
        assert!(program("fn f() -> f32 { return 1u; }", "f", "f").unwrap_err().contains("return"));
    }
}
