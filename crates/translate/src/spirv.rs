//! SPIR-V: a compute shader that decodes a list of queries. Its words cannot be pasted into another shader.

use crate::parsed::Parsed;
use brdfc_formats::{Answer, PackKind};
use brdfc_shaders::{ENTRY, WORKGROUP};
use naga::ShaderStage;
use naga::back::spv::{Options, PipelineOptions, WriterFlags, write_vec};

/// The words of the module.
///
/// # Errors
/// Returns the writer's error.
pub(crate) fn module(decoder: PackKind, source: &str) -> Result<Vec<u32>, String> {
    let parsed = Parsed::new(&evaluation(decoder, source))?;
    let options = Options { lang_version: (1, 3), flags: WriterFlags::DEBUG, ..Options::default() };
    let pipeline = PipelineOptions { shader_stage: ShaderStage::Compute, entry_point: ENTRY.to_owned() };
    write_vec(&parsed.module, &parsed.info, &options, Some(&pipeline)).map_err(|error| error.to_string())
}

/// The decoder with an entry point that answers a list of queries, one per invocation.
fn evaluation(decoder: PackKind, source: &str) -> String {
    let Answer { body, of_struct, .. } = decoder.descriptor().answer;
    let (statement, answer) = match of_struct {
        Some(answer) => (format!("let answer = {body};"), answer.numbers_of("answer")),
        None => (String::new(), body.to_owned()),
    };
    format!(
        "{source}
struct Query {{ a: vec4<f32>, b: vec4<f32>, c: vec4<f32> }}
@group(0) @binding(0) var<storage, read> queries: array<Query>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size({WORKGROUP})
fn {ENTRY}(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x >= arrayLength(&queries) {{
        return;
    }}
    let a = queries[id.x].a;
    let b = queries[id.x].b;
    let c = queries[id.x].c;
    {statement}
    answers[id.x] = {answer};
}}
"
    )
}
