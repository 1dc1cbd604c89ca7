//! SPIR-V of 'brdfc shader', and SPIR-V that glslang makes from HLSL, on the installed Vulkan driver: unchecked and unmodified by
//! wgpu, as an engine would pass it. Each is compared with the CPU decoder at 10,000 queries per pack. Also the WGSL of a codec
//! that exists nowhere else, with the loader that binds all of them.

mod device;
mod loader;

use brdfc_formats::PackKind;
use brdfc_formats::bindings::PackFile;
use brdfc_shaders::{Language, shader};
use brdfc_testing::codecs::cases;
use brdfc_testing::engines::{Case, SIDE, call, check, macros};
use brdfc_testing::gradient;
use device::Vulkan;
use std::process::Command;

/// Words of a file of SPIR-V.
fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect()
}

/// Evaluates all cases by the modules of their decoders.
fn answers(vulkan: &Vulkan, cases: &[Case], module: impl Fn(PackKind) -> (Vec<u32>, [u32; 2])) -> Vec<Vec<[f32; 4]>> {
    cases
        .iter()
        .map(|case| {
            let (words, groups) = module(case.decoder);
            let module = vulkan.spirv(&words, groups[1], &case.bindings);
            vulkan.evaluate(&module, groups, &case.queries, (&case.bindings, case.frame))
        })
        .collect()
}

#[test]
fn spirv_agrees_with_the_cpu() {
    let Some(vulkan) = Vulkan::open() else { return };
    let cases = cases();
    // As `EntryPoint` specifies: queries in group 0, the pack in group 1.
    let module = |decoder| (words(&shader(decoder, Language::Spirv).bytes), [0, 1]);
    check("SPIR-V", &cases, &answers(&vulkan, &cases, module));
}

/// Code that a user of the snippet writes. Registers without a space are in group 0.
fn hlsl(decoder: PackKind) -> String {
    let piece = String::from_utf8(shader(decoder, Language::Hlsl).bytes).unwrap();
    let (macros, call) = (macros(Language::Hlsl), call(decoder));
    format!(
        "{piece}
{macros}
struct Query {{ float4 a; float4 b; float4 c; }};
StructuredBuffer<Query> queries : register(t0, space1);
RWStructuredBuffer<float4> answers : register(u1, space1);
[numthreads(64, 1, 1)] void evaluate(uint3 id : SV_DispatchThreadID) {{
    uint count, stride;
    queries.GetDimensions(count, stride);
    if (id.x < count) {{
        float4 a = queries[id.x].a, b = queries[id.x].b, c = queries[id.x].c;
        answers[id.x] = {call};
    }}
}}
"
    )
}

#[test]
fn hlsl_agrees_with_the_cpu() {
    let Some(vulkan) = Vulkan::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (source, compiled) = (folder.path().join("shader.hlsl"), folder.path().join("shader.spv"));
    let compile = |decoder: PackKind| {
        std::fs::write(&source, hlsl(decoder)).unwrap();
        let mut glslang = Command::new("glslangValidator");
        glslang.args(["-D", "-V", "-S", "comp", "-e", "evaluate"]).arg("-o").arg(&compiled).arg(&source);
        let output = glslang.output()?;
        assert!(output.status.success(), "{}: {}", decoder.name(), String::from_utf8_lossy(&output.stdout));
        Ok::<_, std::io::Error>(words(&std::fs::read(&compiled)?))
    };
    let mut modules = Vec::new();
    for decoder in PackKind::ALL {
        match compile(decoder) {
            Ok(words) => modules.push((decoder, words)),
            Err(error) => {
                println!("skipped: no HLSL is compiled: glslangValidator: {error}");
                return;
            }
        }
    }
    let module = |decoder| (modules.iter().find(|(other, _)| *other == decoder).unwrap().1.clone(), [1, 0]);
    let cases = cases();
    check("HLSL", &cases, &answers(&vulkan, &cases, module));
}

#[test]
fn a_codec_that_exists_nowhere_else_agrees_with_the_cpu() {
    let Some(vulkan) = Vulkan::open() else { return };
    let PackFile { bindings, .. } = PackFile::from_bytes(&gradient::file()).unwrap();
    assert_eq!(bindings.decoder, "gradient");
    let module = vulkan.wgsl(format!(
        "{}
@group(0) @binding(0) var<storage, read> queries: array<array<vec4<f32>, 3>>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64) fn evaluate(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x < {}u {{
        let a = queries[id.x][0];
        answers[id.x] = {};
    }}
}}
",
        gradient::wgsl(),
        SIDE * SIDE,
        gradient::CALL
    ));
    let queries = gradient::queries();
    gradient::check("wgpu", &vulkan.evaluate(&module, [0, 1], &queries, (&bindings.all, gradient::FRAME)));
}
