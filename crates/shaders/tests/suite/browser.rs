//! Translated decoders in a browser: GLSL ES 3.00 by WebGL 2, WGSL by WebGPU, each against the CPU decoder at 10,000 queries a
//! pack.

use crate::texts::text;
use brdfc_shaders::resources::{Contents, Resource, size_of};
use brdfc_shaders::{BindingKind, Decoder, Interface, Language, translate};
use brdfc_testing::browser::result_of_page;
use brdfc_testing::engines::{Case, SIDE, cases, check};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// What a user of the piece calls.
pub fn call(decoder: Decoder) -> &'static str {
    match decoder {
        Decoder::Table => "vec4(table_brdf_at(a.xyz, b.xyz, a.w, b.w == 1.0), 0.0)",
        Decoder::Wavelet => {
            "vec4(b.w == 1.0 ? wavelet_brdf(a.xyz, b.xyz, a.w) : wavelet_brdf_exact(a.xyz, b.xyz, a.w), 0.0)"
        }
        Decoder::FlatBtf => "vec4(flat_btf_value(a.xy, a.z, b.xyz, c.xyz), 0.0)",
        Decoder::Pwt => "vec4(pwt_value(a.xy, a.z, b.xyz), 0.0)",
        Decoder::Bandwidth => {
            "vec4(bandwidth_brdf(a.xyz, b.xyz), bandwidth_environment(a.xyz), bandwidth_texture(c.xy), 0.0)"
        }
        Decoder::Importance => {
            "vec4(importance_sample(a.xyz, uint(a.w)).incoming, importance_sample(a.xyz, uint(a.w)).inverse_density)"
        }
    }
}

fn glsl(decoder: Decoder) -> String {
    let piece = text(decoder, Language::Essl300);
    let call = call(decoder);
    format!(
        "#version 300 es\n{piece}
uniform highp sampler2D query_a;
uniform highp sampler2D query_b;
uniform highp sampler2D query_c;
out highp vec4 answer;
void main() {{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 a = texelFetch(query_a, at, 0);
    vec4 b = texelFetch(query_b, at, 0);
    vec4 c = texelFetch(query_c, at, 0);
    answer = {call};
}}
"
    )
}

fn wgsl(decoder: Decoder) -> String {
    let piece = text(decoder, Language::Wgsl);
    let count = SIDE * SIDE;
    let call = call(decoder).replace("vec4(", "vec4<f32>(").replace("uint(", "u32(");
    let call = match decoder {
        Decoder::Wavelet => {
            "vec4<f32>(select(wavelet_brdf_exact(a.xyz, b.xyz, a.w), wavelet_brdf(a.xyz, b.xyz, a.w), b.w == 1.0), 0.0)"
        }
        _ => &call,
    };
    format!(
        "{piece}
@group(0) @binding(0) var<storage, read> queries: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x < {count}u {{
        let a = queries[id.x];
        let b = queries[{count}u + id.x];
        let c = queries[{}u + id.x];
        answers[id.x] = {call};
    }}
}}
",
        2 * count
    )
}

/// The list of the cases and the bytes that it points into.
fn page_of(api: &str, cases: &[Case], shaders: &BTreeMap<&'static str, (String, Interface)>) -> (Value, Vec<u8>) {
    let mut data: Vec<u8> = Vec::new();
    let mut add = |bytes: &[u8]| {
        let at = data.len().next_multiple_of(16);
        data.resize(at, 0);
        data.extend(bytes);
        json!({ "at": at, "length": bytes.len() })
    };
    let mut listed = Vec::new();
    for case in cases {
        let (shader, interface) = &shaders[case.decoder.name()];
        let mut resources = Vec::new();
        for resource in &case.resources {
            let bound = interface.bindings.iter().find(|bound| bound.binding == resource.binding).unwrap();
            let mut entry = match (&resource.contents, &bound.kind) {
                (Contents::Uniform(bytes), BindingKind::Uniform { block, bytes: size, .. }) => {
                    assert_eq!(bytes.len(), *size as usize, "{}", bound.name);
                    let mut entry = add(bytes);
                    entry["kind"] = "uniform".into();
                    entry["block"] = block.as_str().into();
                    entry
                }
                (Contents::Sampler { repeats }, BindingKind::Sampler) => {
                    json!({ "kind": "sampler", "repeats": repeats })
                }
                (Contents::Texture(texels), BindingKind::Texture { dimension, .. }) => {
                    let texels = texels.clone().widened();
                    let mut entry = add(&texels.bytes);
                    entry["kind"] = "texture".into();
                    entry["size"] = json!(size_of(texels.extent));
                    entry["dimension"] = (*dimension).into();
                    entry["format"] = format!("{:?}", texels.format).into();
                    entry["texelBytes"] = texels.format.texel_bytes().into();
                    entry["levels"] = texels.levels.into();
                    // The shader filters.
                    entry["filtered"] = false.into();
                    entry
                }
                (contents, kind) => panic!("{}: {contents:?} for {kind:?}", bound.name),
            };
            entry["binding"] = resource.binding.into();
            entry["name"] = bound.name.as_str().into();
            resources.push(entry);
        }
        let group = |k: usize| case.queries.iter().flat_map(move |query| query[k]);
        let queries: Vec<u8> = (0..3).flat_map(group).flat_map(f32::to_le_bytes).collect();
        let source = if api == "webgl2" { "glsl" } else { "wgsl" };
        let is_wide = |resource: &Resource| match &resource.contents {
            Contents::Texture(texels) => texels.clone().widened().format != texels.format,
            _ => false,
        };
        // The WGSL has a sampler for it, which a texture of floats takes by this feature alone.
        let feature = case.resources.iter().any(is_wide).then_some("float32-filterable");
        listed.push(json!({
            "name": case.name,
            source: shader,
            "resources": resources,
            "queries": add(&queries),
            "feature": feature,
        }));
    }
    (json!({ "api": api, "cases": listed }), data)
}

/// The answers to all cases by the page, or `None` where there is no browser.
fn answers(
    api: &str,
    cases: &[Case],
    shaders: &BTreeMap<&'static str, (String, Interface)>,
) -> Option<Vec<Vec<[f32; 4]>>> {
    let (list, data) = page_of(api, cases, shaders);
    let files = [
        ("", "text/html", include_bytes!("page.html").as_slice()),
        ("page.js", "text/javascript", include_bytes!("page.js")),
        ("cases.json", "application/json", list.to_string().into_bytes().leak()),
        ("data.bin", "application/octet-stream", &data),
    ];
    Some(numbers(&result_of_page(&files)?, cases.len()))
}

/// Answers to so many cases from what a page posts.
pub fn numbers(posted: &[u8], cases: usize) -> Vec<Vec<[f32; 4]>> {
    let text = String::from_utf8_lossy(&posted[..posted.len().min(2000)]);
    assert_eq!(posted.len(), cases * 16 * SIDE * SIDE, "{text}");
    let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let numbers: Vec<f32> = posted.chunks_exact(4).map(number).collect();
    let answers: Vec<[f32; 4]> = numbers.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect();
    answers.chunks(SIDE * SIDE).map(<[_]>::to_vec).collect()
}

fn agrees(api: &str, source: fn(Decoder) -> String) {
    let cases = cases();

    let shader =
        |decoder: Decoder| (decoder.name(), (source(decoder), translate(decoder, Language::Wgsl).unwrap().interface));
    let shaders: BTreeMap<_, _> = Decoder::ALL.into_iter().map(shader).collect();
    let Some(found) = answers(api, &cases, &shaders) else { return };
    check(api, &cases, &found);
}

#[test]
fn webgl_2_agrees_with_the_cpu() {
    agrees("webgl2", glsl);
}

#[test]
fn webgpu_agrees_with_the_cpu() {
    agrees("webgpu", wgsl);
}
