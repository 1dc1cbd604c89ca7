// Evaluates a pack at a list of direction pairs, one per item. Goes after the decoder of its codec and
// `evaluate_wavelet.wgsl` or `evaluate_table.wgsl`, before `items.wgsl`.

struct Pair {
    incoming: vec4<f32>,
    outgoing: vec4<f32>,
}

struct Values {
    log_value: vec4<f32>, // ln(f / μ + ε), and the fetch count if the source is instrumented
    f_r: vec4<f32>,
}

@group(0) @binding(1) var<storage, read> pairs: array<Pair>;
@group(0) @binding(2) var<storage, read_write> values: array<Values>;

fn fetches() -> f32 {
    return 0.0;
}

// Number of the active change that a test made to a shader, from 1; 0 for none.
var<private> change: u32 = 0u;

// The parameters are a level of detail (negative: minus the distance that determines it), and flags: the last bit is 1
// if the sampler filters slices, 0 for manual weights; the bits above are the change.
fn compute(at: u32) {
    let wi = pairs[at].incoming.xyz;
    let wo = pairs[at].outgoing.xyz;
    var log_value = vec3<f32>(0.0);
    var f_r = vec3<f32>(0.0);
    var level = bitcast<f32>(computation.parameters.x);
    let hardware = (computation.parameters.y & 1u) == 1u;
    change = computation.parameters.y >> 1u;
    if level < 0.0 {
        level = level_at(-level);
    }
    if wi.z > 0.0 && wo.z > 0.0 {
        log_value = log_value_of(wi, wo, level, hardware);
    }
    f_r = f_r_of(wi, wo, level, hardware);
    values[at] = Values(vec4<f32>(log_value, fetches()), vec4<f32>(f_r, 0.0));
}

