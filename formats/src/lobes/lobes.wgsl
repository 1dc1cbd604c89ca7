// Lobes of a BRDF: a few look-ups in a prefiltered environment that replace the integral over all directions.
//
// Layout: `formats/src/lobes/spec.md`. The CPU decoder `LobesPack::lookup` of the crate `brdfc-formats` performs the same
// steps in the same order.
//
// Usage: prepend this file and `environment.wgsl` to your own shader, move the bindings as needed, and sum over all lobes:
//
//     for (var k = 0u; k < lobes_count(); k += 1u) {
//         let lobe = lobes_lookup(outgoing, k);
//         let direction = lobe.direction.x * tangent + lobe.direction.y * bitangent + lobe.direction.z * normal;
//         radiance += lobe.weight * environment_radiance(direction, lobe.sharpness);
//     }
//
// outgoing is the unit vector to the viewer in the frame x = tangent, y = bitangent, z = normal, above the horizon. A
// lobe takes one filtered fetch in the environment, and loads two texels of its table.

// 528 bytes: `LobesHeader::uniform` of `brdfc-formats`.
struct LobesParameters {
    count: u32,  // number of lobes
    nodes: u32,  // number of view angles
    reserved_0: u32,
    reserved_1: u32,
    // Of each lobe: tilt along and across the plane of view, anchor (0 normal, 1 mirror direction, 2 viewer) and row, as
    // bits of integers.
    lobes: array<vec4<u32>, 32>,
}

struct LobeLookup {
    direction: vec3<f32>,
    sharpness: f32,
    weight: vec3<f32>,
}

@group(1) @binding(40) var<uniform> lobes_parameters: LobesParameters;
// Weights and sharpness: a column for each view angle. Texture of the KTX2 file.
@group(1) @binding(41) var lobes_weights: texture_2d<f32>;

// Number of lobes.
fn lobes_count() -> u32 {
    return lobes_parameters.count;
}

// Look-up of a lobe. The plane of view contains the normal and the outgoing direction.
fn lobes_lookup(outgoing: vec3<f32>, lobe: u32) -> LobeLookup {
    let words = lobes_parameters.lobes[lobe];
    let position = lobes_view_position(outgoing.z) * f32(lobes_parameters.nodes - 1u);
    let lower = min(u32(position), lobes_parameters.nodes - 2u);
    let share = position - f32(lower);
    let low = textureLoad(lobes_weights, vec2<u32>(lower, words.w), 0);
    let high = textureLoad(lobes_weights, vec2<u32>(lower + 1u, words.w), 0);
    let texel = low + share * (high - low);
    let direction = lobes_direction(outgoing, bitcast<vec2<f32>>(words.xy), words.z);
    return LobeLookup(direction, texel.w, texel.xyz);
}

// 0 at the normal, 1 at the horizon.
fn lobes_view_position(cosine: f32) -> f32 {
    return min(sqrt(max(1.0 - cosine, 0.0)), 1.0);
}

// Direction of a lobe in the local frame.
fn lobes_direction(outgoing: vec3<f32>, tilt: vec2<f32>, anchor: u32) -> vec3<f32> {
    let sine = sqrt(outgoing.x * outgoing.x + outgoing.y * outgoing.y);
    var azimuth = vec2<f32>(1.0, 0.0);
    if sine > 0.0 {
        azimuth = outgoing.xy / sine;
    }
    let length = sqrt(tilt.x * tilt.x + tilt.y * tilt.y + 1.0);
    let h = vec3<f32>(tilt.x / length, tilt.y / length, 1.0 / length);
    let projection = 2.0 * (h.x * sine + h.z * outgoing.z);
    var local = h;
    if anchor > 0u {
        local = vec3<f32>(projection * h.x - sine, projection * h.y, projection * h.z - outgoing.z);
    }
    if anchor == 2u {
        local = vec3<f32>(-local.x, -local.y, local.z);
    }
    return vec3<f32>(
        local.x * azimuth.x - local.y * azimuth.y,
        local.x * azimuth.y + local.y * azimuth.x,
        local.z,
    );
}
