// Projection of a mesh's corners to pixels; the CPU twin is `camera.rs`.

struct PointLight {
    position: vec4<f32>,
    intensity: vec4<f32>, // W/sr
}

const NEAR: f32 = 0.01;

struct Corner {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec3<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) raised_by: f32, // height above the surface, where a relief covers it
    @location(5) border: f32, // distance from the open border, where a relief covers it
}

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec3<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) raised_by: f32,
    @location(5) border: f32,
    @location(6) base: vec3<f32>, // the point of the surface below
}

// Pinhole projection with reversed, infinite depth. `right` and `up` are divided by half the width and height of the
// image plane at distance 1; `shift` is that of the image, in clip space.
fn projected(corner: Corner, eye: vec3<f32>, right: vec3<f32>, up: vec3<f32>, forward: vec3<f32>, shift: vec2<f32>) -> Varying {
    let r = corner.position - eye;
    let w = dot(forward, r);
    let at = vec2<f32>(dot(right, r), dot(up, r)) + shift * w;
    let base = corner.position - corner.raised_by * corner.normal;
    return Varying(
        vec4<f32>(at, NEAR, w), corner.position, corner.normal, corner.tangent, corner.uv, corner.raised_by, corner.border, base);
}

