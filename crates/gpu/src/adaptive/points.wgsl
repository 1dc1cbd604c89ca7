// The points of a G-buffer, and declarations that all steps of adaptive shading share. The CPU twin is
// `crates/render/src/gbuffer.rs`.

// A frame and its camera. Levels of the pyramid are finest first.
struct Rendering {
    eye: vec4<f32>,
    right: vec4<f32>,           // unit vectors
    up: vec4<f32>,
    points: vec2<u32>,          // columns and rows of the G-buffer
    pixels: vec2<u32>,          // of the rendering
    sub: u32,                   // points per pixel and axis
    coarsest: u32,              // level
    reserved_0: u32,
    reserved_1: u32,
    levels: array<vec4<u32>, 20>, // width, height, index of the first node
}

// `Settings`, and values computed on the way.
struct Settings {
    field_of_view: vec2<f32>,   // radians, across and down
    directions: u32,
    white: f32,
    caution: f32,
    largest: f32,               // bandwidth of a pixel
    scale: f32,                 // from deviation to samples
    fewest: u32,
    most: u32,
    antialiasing_levels: u32,
    reserved_0: u32,
    reserved_1: u32,
}

// A part and its material, besides its pack and maps.
struct Material {
    part: u32,                  // index
    albedo: f32,
    level: f32,                 // level of detail of the pack; negative: follows the distance
    hardware: u32,              // 1: the sampler filters the pack
    texture_size: vec2<u32>,    // texels of the finest level
    texture_levels: u32,        // 0: no texture
    reserved: u32,
    repeats: vec2<f32>,         // of the texture, per unit of u and v
    metres: vec2<f32>,          // size of the texture
}

// Range of one dispatch: `count` items from `first` on, of a level or for a material where that matters. The material
// has no uniform block of its own, because with eight of them in a shader llvmpipe of Mesa 22 corrupts memory.
struct Job {
    first: u32,
    count: u32,
    stride: u32,                // invocations per row of workgroups
    level: u32,
    material: Material,
}

// A pixel of a level.
struct Node {
    finest: i32,                // finest level that any of its points needs
    samples: u32,               // maximum over its points
    first: u32,                 // its first point on a surface, or NONE
}

@group(0) @binding(0) var<uniform> rendering: Rendering;
@group(0) @binding(1) var<uniform> settings: Settings;
@group(0) @binding(2) var<uniform> job: Job;
@group(0) @binding(3) var positions: texture_2d<f32>;
@group(0) @binding(4) var normals: texture_2d<f32>;
@group(0) @binding(5) var tangents: texture_2d<f32>;

// Per point: bandwidth in the rendering, deviation, curvature, angular bandwidth.
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> nodes: array<Node>;
// Per node: its radiance, and 1 if it has one.
@group(0) @binding(8) var<storage, read_write> computed: array<vec4<f32>>;
// Per node of the current level: outcome, samples, the point it stands for, its part.
@group(0) @binding(9) var<storage, read_write> outcomes: array<vec4<u32>>;
// Point, first sample, samples.
@group(0) @binding(10) var<storage, read_write> slices: array<vec4<u32>>;
// Node, first slice, slices, samples.
@group(0) @binding(11) var<storage, read_write> gathers: array<vec4<u32>>;
// Per slice: its sum. Per stretch of points: the sum of deviations.
@group(0) @binding(12) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> image: array<vec4<f32>>;

const NONE: u32 = 0xffffffffu;
// Level of points that show no surface.
const ANY_LEVEL: i32 = 0x7fffffff;

// Index of an invocation within the job; `job.count` or more if it has no item.
fn within_job(id: vec3<u32>) -> u32 {
    return id.y * job.stride + id.x;
}

fn place_of(point: u32) -> vec2<u32> {
    return vec2<u32>(point % rendering.points.x, point / rendering.points.x);
}

// Part that a point shows; NONE for the background.
fn part_of(point: u32) -> u32 {
    return u32(textureLoad(positions, place_of(point), 0).w) - 1u;
}

fn position_of(point: u32) -> vec3<f32> {
    return textureLoad(positions, place_of(point), 0).xyz;
}

fn uv_of(point: u32) -> vec2<f32> {
    return vec2<f32>(textureLoad(normals, place_of(point), 0).w, textureLoad(tangents, place_of(point), 0).w);
}

fn normal_of(point: u32) -> vec3<f32> {
    return textureLoad(normals, place_of(point), 0).xyz;
}

// Unit vector to the viewer, and the viewer's distance.
fn viewer_of(position: vec3<f32>) -> vec4<f32> {
    let to_eye = rendering.eye.xyz - position;
    let distance = sqrt(product(to_eye, to_eye));
    return vec4<f32>(to_eye / distance, distance);
}

// Direction of a normal in the image, across and down.
fn across_of(normal: vec3<f32>) -> vec2<f32> {
    let projected = vec2<f32>(product(normal, rendering.right.xyz), -product(normal, rendering.up.xyz));
    let length = sqrt(projected.x * projected.x + projected.y * projected.y);
    return select(vec2<f32>(1.0, 0.0), projected / length, length > 1e-9);
}

// Tangent, bitangent and normal of a point.
struct LocalFrame {
    tangent: vec3<f32>,
    bitangent: vec3<f32>,
    normal: vec3<f32>,
}

fn frame_of(point: u32) -> LocalFrame {
    let n = normal_of(point);
    let t = textureLoad(tangents, place_of(point), 0).xyz;
    let b = vec3<f32>(n.y * t.z - n.z * t.y, n.z * t.x - n.x * t.z, n.x * t.y - n.y * t.x);
    return LocalFrame(t, b, n);
}

fn into_frame(frame: LocalFrame, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(product(v, frame.tangent), product(v, frame.bitangent), product(v, frame.normal));
}

fn into_world(frame: LocalFrame, v: vec3<f32>) -> vec3<f32> {
    return v.x * frame.tangent + v.y * frame.bitangent + v.z * frame.normal;
}

// The scalar product, summed in the order of the CPU.
fn product(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
