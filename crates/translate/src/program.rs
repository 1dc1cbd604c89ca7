//! Whole programs that draw.

use crate::parsed::Parsed;
use brdfc_shaders::{Named, TranslatedProgram};
use naga::back::glsl::{Options, PipelineOptions, ReflectionInfo, Version, Writer, WriterFlags};
use naga::proc::BoundsCheckPolicies;
use naga::{GlobalVariable, Handle, ShaderStage};

/// Translates WGSL with a vertex and a fragment entry point.
///
/// # Errors
/// Returns an error if the source does not parse or validate, or if GLSL ES 3.00 cannot express it.
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
    // The writer lists them in hash order.
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
