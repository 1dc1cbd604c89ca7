// Declarations that the shaders of scenes share: the camera and point lights. Appended to the renderer's `corner.wgsl`.

struct View {
    eye: vec4<f32>,
    right: vec4<f32>,    // divided by half the width of the image plane at distance 1
    up: vec4<f32>,       // divided by half its height
    forward: vec4<f32>,
    shift: vec2<f32>,    // in clip space: moves the sample to the pixel's centre
    level: f32,          // level of detail of wavelet packs; negative: follows the distance
    hardware: u32,       // 1: the sampler filters slices of wavelet packs
    light_count: u32,
    reserved_0: u32,
    reserved_1: u32,
    reserved_2: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> lights: array<PointLight>;

@vertex
fn project(corner: Corner) -> Varying {
    return projected(corner, view.eye.xyz, view.right.xyz, view.up.xyz, view.forward.xyz, view.shift);
}
