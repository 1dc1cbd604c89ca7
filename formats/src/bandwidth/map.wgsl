// Maps of local bandwidth: rate of variation of BRDF lobes, environments or textures.
//
// After Bagher, Soler, Subr, Belcour and Holzschuch 2012, "Interactive rendering of acquired materials on dynamic
// geometry using bandwidth prediction", section 2.4. Layout: `formats/src/bandwidth/spec.md`. The CPU look-ups of
// `BandwidthMap` of the crate `brdfc-formats` perform the same steps in the same order.
//
// Usage: prepend this file to your own shader, move the bindings as needed, and call
//
//     let rho = bandwidth_brdf(wi, wo);         // cycles per radian of the outgoing direction
//     let light = bandwidth_environment(d);     // cycles per radian of the direction
//     let spatial = bandwidth_texture(uv);      // cycles per metre
//
// wi and wo are unit vectors in the frame x = tangent, y = bitangent, z = normal; d is any vector in the frame of the
// environment. For a missing map, bind a texture of one texel and a block of zeros. Functions that a shader does not
// call need no bindings.

// 16 bytes: `BandwidthMap::uniform` of `brdfc-formats`, one block per map.
struct BandwidthParameters {
    scale: f32,   // factor of texel values
    tiles: u32,   // 1 if a texture repeats
    reserved_0: u32,
    reserved_1: u32,
}

@group(1) @binding(29) var<uniform> bandwidth_brdf_parameters: BandwidthParameters;
// Texture of the KTX2 file.
@group(1) @binding(30) var bandwidth_brdf_map: texture_2d<f32>;
@group(1) @binding(31) var<uniform> bandwidth_environment_parameters: BandwidthParameters;
// Texture of the KTX2 file.
@group(1) @binding(32) var bandwidth_environment_map: texture_2d<f32>;
@group(1) @binding(33) var<uniform> bandwidth_texture_parameters: BandwidthParameters;
// Texture of the KTX2 file.
@group(1) @binding(34) var bandwidth_texture_map: texture_2d<f32>;

const BANDWIDTH_PI: f32 = 3.14159274;
const BANDWIDTH_HALF_PI: f32 = 1.57079637;
const BANDWIDTH_TAU: f32 = 6.28318548;
const BANDWIDTH_CELLS: u32 = 16u;

// Bandwidth of a lobe, in cycles per radian of the outgoing direction.
fn bandwidth_brdf(incoming: vec3<f32>, outgoing: vec3<f32>) -> f32 {
    return bandwidth_brdf_cells(bandwidth_cell(incoming), bandwidth_cell(outgoing));
}

// The same for directions whose cells are known.
fn bandwidth_brdf_cells(incoming: vec2<u32>, outgoing: vec2<u32>) -> f32 {
    let at = incoming * BANDWIDTH_CELLS + outgoing;
    return textureLoad(bandwidth_brdf_map, at, 0).x * bandwidth_brdf_parameters.scale;
}

// Bandwidth of an environment, in cycles per radian of a direction in its frame.
fn bandwidth_environment(direction: vec3<f32>) -> f32 {
    let at = bandwidth_environment_texel(direction);
    return textureLoad(bandwidth_environment_map, at, 0).x * bandwidth_environment_parameters.scale;
}

// Column and row in the map, also valid for other images of the same size.
fn bandwidth_environment_texel(direction: vec3<f32>) -> vec2<u32> {
    let size = textureDimensions(bandwidth_environment_map);
    let sine = sqrt(direction.x * direction.x + direction.z * direction.z);
    let turn = bandwidth_azimuth(direction.x, direction.z) / BANDWIDTH_TAU;
    let fall = bandwidth_atan2(sine, direction.y) / BANDWIDTH_PI;
    return vec2<u32>(bandwidth_index(turn, size.x), bandwidth_index(fall, size.y));
}

// Bandwidth of a texture; v follows its rows.
fn bandwidth_texture(uv: vec2<f32>) -> f32 {
    let size = textureDimensions(bandwidth_texture_map);
    var inside = uv;
    if bandwidth_texture_parameters.tiles == 1u {
        inside = uv - floor(uv);
    }
    let at = vec2<u32>(bandwidth_index(inside.x, size.x), bandwidth_index(inside.y, size.y));
    return textureLoad(bandwidth_texture_map, at, 0).x * bandwidth_texture_parameters.scale;
}

// Cell of a direction about the normal: azimuth, polar angle.
fn bandwidth_cell(direction: vec3<f32>) -> vec2<u32> {
    let sine = sqrt(direction.x * direction.x + direction.y * direction.y);
    let turn = bandwidth_azimuth(direction.x, direction.y) / BANDWIDTH_TAU;
    let fall = bandwidth_atan2(sine, direction.z) / BANDWIDTH_HALF_PI;
    return vec2<u32>(bandwidth_index(turn, BANDWIDTH_CELLS), bandwidth_index(fall, BANDWIDTH_CELLS));
}

// Index of the part of [0, 1], divided into `count` equal parts, that contains a fraction; clamped at the ends.
fn bandwidth_index(share: f32, count: u32) -> u32 {
    let at = select(0.0, share * f32(count), share > 0.0);
    return u32(min(at, f32(count) - 1.0));
}

// Angle of (x, y), 0 to 2π.
fn bandwidth_azimuth(x: f32, y: f32) -> f32 {
    let half_turn = bandwidth_atan2(abs(y), x);
    return select(half_turn, BANDWIDTH_TAU - half_turn, y < 0.0);
}
