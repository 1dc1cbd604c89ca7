// Calls `compute(at)` for every item, one per invocation. Appended to a shader that defines it over `input` and
// `output`.

struct Computation {
    count: u32,   // items
    stride: u32,  // invocations per row of workgroups
    reserved_0: u32,
    reserved_1: u32,
}

@group(0) @binding(0) var<uniform> computation: Computation;
@group(0) @binding(1) var<storage, read> input: array<f32>;
@group(0) @binding(2) var<storage, read_write> output: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.y * computation.stride + id.x;
    if at < computation.count {
        compute(at);
    }
}
