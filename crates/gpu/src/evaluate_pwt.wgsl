// Evaluates a polynomial wavelet tree at a list of queries, one per invocation. Appended to `formats/src/pwt/pwt.wgsl`.

struct Evaluation {
    count: u32,    // queries
    stride: u32,   // invocations per row of workgroups
    reserved_0: u32,
    reserved_1: u32,
}

struct PwtQuery {
    place: vec4<f32>, // uv and level
    light: vec4<f32>,
}

struct PwtAnswer {
    channels: vec4<f32>, // and the fetch count where the source was instrumented
    value: vec4<f32>,
}

@group(0) @binding(0) var<uniform> evaluation: Evaluation;
@group(0) @binding(1) var<storage, read> queries: array<PwtQuery>;
@group(0) @binding(2) var<storage, read_write> answers: array<PwtAnswer>;

fn fetches() -> f32 {
    return 0.0;
}

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.y * evaluation.stride + id.x;
    if at >= evaluation.count {
        return;
    }
    let uv = queries[at].place.xy;
    let level = queries[at].place.z;
    let light = queries[at].light.xyz;
    var weights = pwt_weights(light);
    let channels = pwt_channels(uv, level, &weights);
    let counted = fetches();
    let value = pwt_value(uv, level, light);
    answers[at] = PwtAnswer(vec4<f32>(channels, counted), vec4<f32>(value, 0.0));
}
