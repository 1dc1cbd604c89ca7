// Calls `compute(at)` for every item, one per invocation. Appended to a shader that defines it, and that declares its
// input and output as bindings 1 and 2 of group 0.

struct Computation {
    count: u32,   // items
    stride: u32,  // invocations per row of workgroups
    parameters: vec2<u32>,  // the same for all items; the shader defines their meaning
}

@group(0) @binding(0) var<uniform> computation: Computation;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.y * computation.stride + id.x;
    if at < computation.count {
        compute(at);
    }
}
