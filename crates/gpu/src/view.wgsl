// What the shaders of scenes have in common: the camera, point lights, and the way from corners to pixels. The CPU twin
// is `crates/render/src/camera.rs` with `shading_point.rs`.

struct View {
    eye: vec4<f32>,
    right: vec4<f32>,    // divided by half the width of the image plane at distance 1
    up: vec4<f32>,       // divided by half its height
    forward: vec4<f32>,
    shift: vec2<f32>,    // of the image, in clip space: moves the wanted sample to the pixel's centre
    level: f32,          // of detail of wavelet packs; negative: follows the distance
    hardware: u32,       // 1: the sampler filters slices of wavelet packs
    light_count: u32,
    reserved_0: u32,
    reserved_1: u32,
    reserved_2: u32,
}

struct PointLight {
    position: vec4<f32>,
    intensity: vec4<f32>, // W/sr
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> lights: array<PointLight>;

const NEAR: f32 = 0.01;

struct Corner {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec3<f32>,
    @location(3) uv: vec2<f32>,
}

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec3<f32>,
    @location(3) uv: vec2<f32>,
}

// Pinhole projection with reversed, infinite depth.
@vertex
fn project(corner: Corner) -> Varying {
    let r = corner.position - view.eye.xyz;
    let w = dot(view.forward.xyz, r);
    let x = dot(view.right.xyz, r) + view.shift.x * w;
    let y = dot(view.up.xyz, r) + view.shift.y * w;
    return Varying(vec4<f32>(x, y, NEAR, w), corner.position, corner.normal, corner.tangent, corner.uv);
}
