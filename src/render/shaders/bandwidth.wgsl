// Looks up bandwidth maps at a list of queries, one per invocation. Pasted behind `bandwidth.wgsl` of the formats.

struct Evaluation {
    count: u32,    // queries
    stride: u32,   // invocations per row of workgroups
    reserved_0: u32,
    reserved_1: u32,
}

struct BandwidthQuery {
    incoming: vec4<f32>,
    outgoing: vec4<f32>,
    direction: vec4<f32>,
    uv: vec4<f32>,
}

@group(0) @binding(0) var<uniform> evaluation: Evaluation;
@group(0) @binding(1) var<storage, read> queries: array<BandwidthQuery>;
@group(0) @binding(2) var<storage, read_write> answers: array<vec4<f32>>;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.y * evaluation.stride + id.x;
    if at >= evaluation.count {
        return;
    }
    let query = queries[at];
    let brdf = bandwidth_brdf(query.incoming.xyz, query.outgoing.xyz);
    let environment = bandwidth_environment(query.direction.xyz);
    answers[at] = vec4<f32>(brdf, environment, bandwidth_texture(query.uv.xy), 0.0);
}
