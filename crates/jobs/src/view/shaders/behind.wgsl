// Draws the environment behind a material, with one triangle. It follows the decoder of environments, the renderer's
// `corner.wgsl`, and `view.wgsl`.

// At least the sharpness of the finest level.
const UNFILTERED: f32 = 32.0;

struct Behind {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>, // -1 to 1 across the image
}

@vertex
fn project(@builtin(vertex_index) corner: u32) -> Behind {
    let at = vec2<f32>(select(-1.0, 3.0, corner == 1u), select(-1.0, 3.0, corner == 2u));
    return Behind(vec4<f32>(at, NEAR, 1.0), at);
}

@fragment
fn shade(in: Behind) -> @location(0) vec4<f32> {
    let direction = view.forward.xyz + in.at.x * half_of(view.right.xyz) + in.at.y * half_of(view.up.xyz);
    return vec4<f32>(environment_radiance(in_environment(direction), UNFILTERED), 1.0);
}

// Half the image plane at distance 1, along an axis that is divided by its length.
fn half_of(axis: vec3<f32>) -> vec3<f32> {
    return axis / dot(axis, axis);
}
