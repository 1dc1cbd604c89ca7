// Evaluates a polynomial wavelet tree at a list of queries, one per item. Goes between `formats/src/pwt/pwt.wgsl` and
// `items.wgsl`.

struct PwtQuery {
    place: vec4<f32>, // uv and level
    light: vec4<f32>,
    seen: vec4<f32>, // unit vector to the viewer, and the view of the sum
}

struct PwtAnswer {
    sum: vec4<f32>, // and the fetch count if the source is instrumented
    value: vec4<f32>,
}

@group(0) @binding(1) var<storage, read> queries: array<PwtQuery>;
@group(0) @binding(2) var<storage, read_write> answers: array<PwtAnswer>;

fn fetches() -> f32 {
    return 0.0;
}

fn compute(at: u32) {
    let uv = queries[at].place.xy;
    let level = queries[at].place.z;
    let light = queries[at].light.xyz;
    var weights = pwt_weights(light);
    let view = u32(queries[at].seen.w);
    let sum = pwt_sum(uv, level, view, &weights);
    let counted = fetches();
    let value = pwt_value(uv, level, queries[at].seen.xyz, light);
    answers[at] = PwtAnswer(vec4<f32>(sum, counted), vec4<f32>(value, 0.0));
}

