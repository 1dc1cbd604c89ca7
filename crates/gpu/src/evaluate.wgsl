// Evaluates a pack at a list of direction pairs, one per invocation. Appended to the decoder of its codec and
// `evaluate_wavelet.wgsl` or `evaluate_table.wgsl`.

struct Evaluation {
    level: f32,      // level of detail; a negative one is minus the distance that it follows from
    hardware: u32,   // 1: the sampler filters slices, 0: manual weights
    count: u32,      // pairs
    stride: u32,     // invocations per row of workgroups
}

struct Pair {
    incoming: vec4<f32>,
    outgoing: vec4<f32>,
}

struct Values {
    log_value: vec4<f32>, // ln(f / μ + ε), and the fetch count where the source was instrumented
    f_r: vec4<f32>,
}

@group(0) @binding(0) var<uniform> evaluation: Evaluation;
@group(0) @binding(1) var<storage, read> pairs: array<Pair>;
@group(0) @binding(2) var<storage, read_write> values: array<Values>;

fn fetches() -> f32 {
    return 0.0;
}

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.y * evaluation.stride + id.x;
    if at >= evaluation.count {
        return;
    }
    let wi = pairs[at].incoming.xyz;
    let wo = pairs[at].outgoing.xyz;
    var log_value = vec3<f32>(0.0);
    var f_r = vec3<f32>(0.0);
    var level = evaluation.level;
    if level < 0.0 {
        level = level_at(-level);
    }
    if wi.z > 0.0 && wo.z > 0.0 {
        log_value = log_value_of(wi, wo, level, evaluation.hardware == 1u);
    }
    f_r = f_r_of(wi, wo, level, evaluation.hardware == 1u);
    values[at] = Values(vec4<f32>(log_value, fetches()), vec4<f32>(f_r, 0.0));
}
