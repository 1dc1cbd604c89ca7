//! Translated decoders in a browser: GLSL ES 3.00 by WebGL 2, WGSL by WebGPU, each compared with the CPU decoder at
//! 10,000 queries a pack; with exact weights, and once more with the sampler filtering.

use crate::texts::text;
use brdfc_formats::PackKind;
use brdfc_formats::bindings::Resource;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::Filter;
use brdfc_shaders::{BindingKind, Interface, Language, shader};
use brdfc_table::recipe::TableRecipe;
use brdfc_testing::browser::result_of_page;
use brdfc_testing::codecs::{cases, sampler_cases, table, wavelet};
use brdfc_testing::engines::{Case, SIDE, call, check, macros};
use brdfc_testing::sampler::{SamplerCase, check_sampler, check_shifted};
use brdfc_wavelet::recipe::Recipe;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::LazyLock;

fn glsl(decoder: PackKind) -> String {
    let (piece, macros, call) = (text(decoder, Language::Essl300), macros(Language::Essl300), call(decoder));
    format!(
        "#version 300 es\n{piece}
{macros}
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

/// Answers in a fragment shader: SwiftShader filters cube maps across edges in these, but not in compute shaders.
fn wgsl(decoder: PackKind) -> String {
    let piece = text(decoder, Language::Wgsl);
    let count = SIDE * SIDE;
    let call = call(decoder);
    // Packs bind the frame block even if no called function reads it. An automatic layout contains only bindings that
    // are read.
    let frame = if piece.contains("brdfc_frame") { "_ = brdfc_frame.blend;" } else { "" };
    format!(
        "{piece}
@group(0) @binding(0) var<storage, read> queries: array<vec4<f32>>;
@vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {{
    return vec4<f32>(select(-1.0, 3.0, index == 1u), select(1.0, -3.0, index == 2u), 0.0, 1.0);
}}
@fragment fn main(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {{
    {frame}
    let id = {SIDE}u * u32(position.y) + u32(position.x);
    let a = queries[id];
    let b = queries[{count}u + id];
    let c = queries[{}u + id];
    return {call};
}}
",
        2 * count
    )
}

/// A case with the shader that evaluates it.
struct Asked<'a> {
    case: &'a Case,
    shader: &'a str,
    interface: &'a Interface,
    /// True if the sampler filters.
    sampled: bool,
}

/// The list of the cases and the data that it points into.
fn page_of(api: &str, asked: &[Asked<'_>]) -> (Value, Vec<u8>) {
    let mut data: Vec<u8> = Vec::new();
    let mut add = |bytes: &[u8]| {
        let at = data.len().next_multiple_of(16);
        data.resize(at, 0);
        data.extend(bytes);
        json!({ "at": at, "length": bytes.len() })
    };
    let mut listed = Vec::new();
    for Asked { case, shader, interface, sampled } in asked {
        let mut resources = Vec::new();
        for (slot, name, resource) in case.bound() {
            let bound = interface.bindings.iter().find(|bound| bound.binding == slot).unwrap();
            assert_eq!(bound.name, name);
            let mut entry = match (resource, &bound.kind) {
                (Resource::Uniform(bytes), BindingKind::Uniform { bytes: size, .. }) => {
                    assert_eq!(bytes.len(), *size as usize, "{name}");
                    let mut entry = add(&bytes);
                    entry["kind"] = "uniform".into();
                    entry["block"] = interface.block_name(bound).into();
                    entry
                }
                (Resource::Sampler { repeats }, BindingKind::Sampler) => {
                    json!({ "kind": "sampler", "repeats": repeats })
                }
                (Resource::Texture(texels), BindingKind::Texture { dimension, .. }) => {
                    assert_eq!(texels.extent.dimension(), *dimension, "{name}");
                    let texels = texels.widened();
                    let mut entry = add(&texels.bytes);
                    entry["kind"] = "texture".into();
                    entry["size"] = json!(texels.extent.size());
                    entry["dimension"] = dimension.as_str().into();
                    entry["format"] = format!("{:?}", texels.format).into();
                    entry["texelBytes"] = texels.format.texel_bytes().into();
                    entry["levels"] = texels.levels.into();
                    // Texture parameters of WebGL, which has no separate samplers.
                    // Shaders cannot load texels of cube maps.
                    let sampler = texels.sampler.as_deref().filter(|_| *sampled || dimension == "cube");
                    entry["filtered"] = sampler.is_some().into();
                    entry["repeats"] = case.repeats(sampler).into();
                    entry
                }
                (resource, kind) => panic!("{name}: {resource:?} for {kind:?}"),
            };
            entry["binding"] = slot.into();
            entry["name"] = name.into();
            resources.push(entry);
        }
        let group = |k: usize| case.queries.iter().flat_map(move |query| query[k]);
        let queries: Vec<u8> = (0..3).flat_map(group).flat_map(f32::to_le_bytes).collect();
        let source = if api == "webgl2" { "glsl" } else { "wgsl" };
        let is_wide = |(_, _, resource): (u32, &str, Resource<'_>)| match resource {
            Resource::Texture(texels) => texels.clone().widened().format != texels.format,
            _ => false,
        };
        // The WGSL has a sampler for it, which accepts a texture of floats only with this feature.
        let feature = case.bound().any(is_wide).then_some("float32-filterable");
        listed.push(json!({
            "name": case.name,
            source: shader,
            "resources": resources,
            "queries": add(&queries),
            "feature": feature,
            "sampled": sampled,
        }));
    }
    (json!({ "api": api, "cases": listed }), data)
}

/// The page's answers to all cases; `None` without a browser.
fn answers(api: &str, asked: &[Asked<'_>]) -> Option<Vec<Vec<[f32; 4]>>> {
    let (list, data) = page_of(api, asked);
    let files = [
        ("", "text/html", include_bytes!("page.html").as_slice()),
        ("page.js", "text/javascript", include_bytes!("page.js")),
        ("cases.json", "application/json", list.to_string().into_bytes().leak()),
        ("data.bin", "application/octet-stream", &data),
    ];
    Some(numbers(&result_of_page(&files)?, asked.len()))
}

/// Parses the answers to this many cases from a page's post.
pub fn numbers(posted: &[u8], cases: usize) -> Vec<Vec<[f32; 4]>> {
    let text = String::from_utf8_lossy(&posted[..posted.len().min(2000)]);
    assert_eq!(posted.len(), cases * 16 * SIDE * SIDE, "{text}");
    let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let numbers: Vec<f32> = posted.chunks_exact(4).map(number).collect();
    let answers: Vec<[f32; 4]> = numbers.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect();
    answers.chunks(SIDE * SIDE).map(<[_]>::to_vec).collect()
}

/// Shaders of all decoders, with their bindings.
fn shaders(source: fn(PackKind) -> String) -> BTreeMap<&'static str, (String, Interface)> {
    let shader = |decoder: PackKind| (decoder.name(), (source(decoder), shader(decoder, Language::Wgsl).interface));
    PackKind::ALL.into_iter().map(shader).collect()
}

fn agrees(api: &str, source: fn(PackKind) -> String) {
    let (cases, shaders) = (cases(), shaders(source));
    let mut asked = Vec::new();
    for case in &cases {
        let (shader, interface) = &shaders[case.decoder.name()];
        asked.push(Asked { case, shader, interface, sampled: false });
    }
    let Some(found) = answers(api, &asked) else { return };
    check(api, &cases, &found);
}

/// Packs made by encoders, in which neighbouring texels are similar.
fn materials() -> Vec<SamplerCase> {
    let red = brdfc_testing::testdata("demo/red_plastic.binary");
    let opened = |input: &str| brdfc_source::open::open(input, None).unwrap().source;
    let mut all = Vec::new();
    for (name, input) in [("red plastic", red.as_str()), ("GGX, alpha 0.3", "synth:ggx?alpha=0.3")] {
        let source = opened(input);
        let recipe = TableRecipe { measure: false, ..TableRecipe::default() };
        all.push(table::sampler_case(name, &brdfc_table::encode::encode(source.as_ref(), &recipe, &()).unwrap().pack));
        for (bits, parameterisation) in [(8, Parameterisation::TangentPole), (16, Parameterisation::HalfDifference)] {
            let recipe = Recipe { bits, parameterisation, measure_off_grid: false, ..Recipe::default() };
            let pack = brdfc_wavelet::encode::encode(source.as_ref(), &recipe, &()).unwrap().pack;
            all.push(wavelet::sampler_case(&format!("{name}, {bits} bits"), &pack, Filter::Bilinear));
        }
    }
    all
}

/// Change to filtered look-ups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lookups {
    /// No change.
    AsTheyAre,
    /// Positions and levels have 8 fractional bits, as in GPUs. Software drivers have been observed to filter with all
    /// bits of a float.
    Rounded,
    /// Positions are off by half a texel.
    Shifted,
}

impl Lookups {
    const ALL: [Self; 3] = [Self::AsTheyAre, Self::Rounded, Self::Shifted];
}

/// Made-up packs and materials, with the bounds of each query. They take longer than the browser, and both APIs share
/// them.
static SAMPLED: LazyLock<[Vec<SamplerCase>; 2]> = LazyLock::new(|| [sampler_cases(), materials()]);

/// Compares filtering by the sampler with the CPU, with the bounds of each query.
fn agrees_by_sampler(api: &str, source: fn(PackKind) -> String, changed: fn(&str, &Interface, Lookups) -> String) {
    let [made_up, materials] = &*SAMPLED;
    let shaders = shaders(source);
    let changed = Lookups::ALL.map(|lookups| {
        let change = |(name, (shader, interface)): (&&'static str, &(String, Interface))| {
            (*name, if lookups == Lookups::AsTheyAre { shader.clone() } else { changed(shader, interface, lookups) })
        };
        shaders.iter().map(change).collect::<BTreeMap<_, _>>()
    });
    let mut asked = Vec::new();
    for changed in &changed {
        for SamplerCase { case, .. } in made_up.iter().chain(materials) {
            let name = case.decoder.name();
            asked.push(Asked { case, shader: &changed[name], interface: &shaders[name].1, sampled: true });
        }
    }
    let Some(found) = answers(api, &asked) else { return };
    for (lookups, found) in Lookups::ALL.into_iter().zip(found.chunks(made_up.len() + materials.len())) {
        let found = found.split_at(made_up.len());
        for (what, cases, found) in [("sampler", made_up, found.0), ("sampler, materials", materials, found.1)] {
            match lookups {
                Lookups::AsTheyAre => check_sampler(&format!("{api}, {what}"), cases, found),
                Lookups::Rounded => check_sampler(&format!("{api}, {what}, 8 bits"), cases, found),
                Lookups::Shifted => check_shifted(&format!("{api}, {what}"), cases, found),
            }
        }
    }
}

/// GLSL with changed look-ups.
fn glsl_changed(shader: &str, _: &Interface, lookups: Lookups) -> String {
    let changed = match lookups {
        Lookups::AsTheyAre => return shader.to_owned(),
        Lookups::Rounded => {
            "highp vec2 changed(highp vec2 at, ivec2 size) {
    return (round((at * vec2(size) - 0.5) * 256.0) / 256.0 + 0.5) / vec2(size);
}
highp vec3 changed(highp vec3 at, ivec3 size) {
    return (round((at * vec3(size) - 0.5) * 256.0) / 256.0 + 0.5) / vec3(size);
}
#define of_level(t, at, level) textureLod(t, changed(at, textureSize(t, int(level))), level)
#define textureLod(t, at, level) \
    mix(of_level(t, at, floor(level)), of_level(t, at, ceil(level)), round(fract(level) * 256.0) / 256.0)
"
        }
        Lookups::Shifted => {
            "highp vec2 changed(highp vec2 at, ivec2 size) { return at + vec2(0.5 / float(size.x), 0.0); }
highp vec3 changed(highp vec3 at, ivec3 size) { return at + vec3(0.5 / float(size.x), 0.0, 0.0); }
#define textureLod(t, at, level) textureLod(t, changed(at, textureSize(t, 0)), level)
"
        }
    };
    // Insert after the precision statements.
    let first = shader.find("\nstruct").unwrap();
    format!("{}\n{changed}{}", &shader[..first], &shader[first..])
}

/// WGSL with changed look-ups.
fn wgsl_changed(shader: &str, interface: &Interface, lookups: Lookups) -> String {
    let mut parts = shader.split("textureSampleLevel(");
    let mut text = parts.next().unwrap().to_owned();
    for part in parts {
        let (words, rest) = part.split_once(')').unwrap();
        let words: Vec<&str> = words.split(", ").collect();
        let [texture, sampler, at, between @ .., level] = &words[..] else { panic!("{part}") };
        let layer = between.iter().map(|layer| format!("{layer}, ")).collect::<String>();
        let bound = interface.bindings.iter().find(|bound| bound.name == *texture).unwrap();
        let BindingKind::Texture { dimension, .. } = &bound.kind else { panic!("{texture}") };
        let (vector, along) = if dimension == "3d" {
            ("vec3<f32>", "vec3<f32>(0.5, 0.0, 0.0)")
        } else {
            ("vec2<f32>", "vec2<f32>(0.5, 0.0)")
        };
        let size = |level: &str| format!("{vector}(textureDimensions({texture}, u32({level})))");
        let sample = |at: &str, level: &str| format!("textureSampleLevel({texture}, {sampler}, {at}, {layer}{level})");
        let rounded = |level: &str| {
            let size = size(level);
            sample(&format!("(round(({at} * {size} - 0.5) * 256.0) / 256.0 + 0.5) / {size}"), level)
        };
        text += &match lookups {
            Lookups::AsTheyAre => sample(at, level),
            Lookups::Rounded => {
                let [fine, coarse] = ["floor", "ceil"].map(|whole| rounded(&format!("{whole}({level})")));
                format!("mix({fine}, {coarse}, round(fract({level}) * 256.0) / 256.0)")
            }
            Lookups::Shifted => sample(&format!("{at} + {along} / {}", size("0")), level),
        };
        text += rest;
    }
    text
}

#[test]
fn webgl_2_agrees_with_the_cpu() {
    agrees("webgl2", glsl);
}

#[test]
fn webgpu_agrees_with_the_cpu() {
    agrees("webgpu", wgsl);
}

#[test]
fn webgl_2_agrees_where_the_sampler_filters() {
    agrees_by_sampler("webgl2", glsl, glsl_changed);
}

#[test]
fn webgpu_agrees_where_the_sampler_filters() {
    agrees_by_sampler("webgpu", wgsl, wgsl_changed);
}
