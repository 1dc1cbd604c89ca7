// Evaluates a flat BTF at a list of queries, one per item. Goes between `formats/src/flat_btf/decoder.wgsl` and
// `items.wgsl`.

struct FlatBtfQuery {
    uv: vec4<f32>,
    view: vec4<f32>,
    light: vec4<f32>,
    view_indices: vec4<u32>,
    view_weights: vec4<f32>,
    light_indices: vec4<u32>,
    light_weights: vec4<f32>,
}

struct FlatBtfAnswer {
    indirection: vec4<f32>,
    full: vec4<f32>,
    light: vec4<f32>,
}

@group(0) @binding(1) var<storage, read> queries: array<FlatBtfQuery>;
@group(0) @binding(2) var<storage, read_write> answers: array<FlatBtfAnswer>;

fn compute(at: u32) {
    let uv = queries[at].uv.xy;
    let view = queries[at].view.xyz;
    let views = FlatBtfWeights(queries[at].view_indices.xyz, queries[at].view_weights.xyz);
    let lights = FlatBtfWeights(queries[at].light_indices.xyz, queries[at].light_weights.xyz);
    let seen = flat_btf_indirection(uv, view);
    let full = flat_btf_full(uv, view, views, lights);
    let light = flat_btf_light_form(uv, view, queries[at].light.xyz);
    answers[at] = FlatBtfAnswer(vec4<f32>(seen, 0.0), vec4<f32>(full, 0.0), vec4<f32>(light, 0.0));
}

