// Parameters of a rendering. It follows the renderer's `corner.wgsl`.

struct View {
    eye: vec4<f32>,
    right: vec4<f32>,    // divided by half the width of the image plane at distance 1
    up: vec4<f32>,       // divided by half its height
    forward: vec4<f32>,
    sines: vec4<f32>,    // of the elevations that the material covers: the viewer's lowest and highest, then the lights'
    azimuth: vec2<f32>,  // cosine and sine of the angle by which the environment is turned
    level: f32,          // of detail; negative: from the distance, or from the size of a pixel
    octaves: f32,        // log2 of the samples along a pixel's side
    repeat: f32,         // tiles per unit of uv
    light_count: u32,
    lights: array<PointLight, 8>,
}

@group(0) @binding(0) var<uniform> view: View;

// A direction in the frame of the environment, which is turned about the vertical.
fn in_environment(direction: vec3<f32>) -> vec3<f32> {
    let c = view.azimuth.x;
    let s = view.azimuth.y;
    return vec3<f32>(c * direction.x - s * direction.z, direction.y, s * direction.x + c * direction.z);
}
