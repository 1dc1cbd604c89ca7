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
// lobe takes one filtered fetch in the environment, two if its sharpness is between 0 and 1, and loads two texels of its
// table; four if the material is anisotropic.

// 528 bytes: `LobesHeader::uniform` of `brdfc-formats`.
struct LobesParameters {
    count: u32,     // number of lobes
    nodes: u32,     // number of view angles
    azimuths: u32,  // number of view azimuths, 1 if the material is isotropic
    scale: f32,     // factor of all weights
    // Of each lobe: tilt along and across the plane of view, or along tangent and bitangent; anchor (0 normal, 1 mirror
    // direction, 2 viewer) and row, as bits of integers.
    lobes: array<vec4<u32>, 32>,
}

struct LobeLookup {
    direction: vec3<f32>,
    sharpness: f32,
    weight: vec3<f32>,
}

@group(1) @binding(41) var<uniform> lobes_parameters: LobesParameters;
// Weights and sharpness: a column for each view angle. Texture of the KTX2 file.
@group(1) @binding(42) var lobes_weights: texture_2d<f32>;

// Number of lobes.
fn lobes_count() -> u32 {
    return lobes_parameters.count;
}

// Look-up of a lobe.
fn lobes_lookup(outgoing: vec3<f32>, lobe: u32) -> LobeLookup {
    let words = lobes_parameters.lobes[lobe];
    let position = lobes_view_position(outgoing.z) * f32(lobes_parameters.nodes - 1u);
    let azimuths = lobes_parameters.azimuths;
    let first = words.w * azimuths;
    var axis = vec2<f32>(1.0, 0.0);
    var texel = vec4<f32>(0.0);
    if azimuths == 1u {
        axis = lobes_plane_of_view(outgoing);
        texel = lobes_weight(position, first);
    } else {
        let turn = lobes_view_azimuth(outgoing) * f32(azimuths);
        let before = min(u32(turn), azimuths - 1u);
        let low = lobes_weight(position, first + before);
        let high = lobes_weight(position, first + (before + 1u) % azimuths);
        texel = low + (turn - f32(before)) * (high - low);
    }
    let direction = lobes_direction(outgoing, bitcast<vec2<f32>>(words.xy), words.z, axis);
    return LobeLookup(direction, texel.w, lobes_parameters.scale * texel.xyz);
}

// Weights without the scale and sharpness between two view angles, in a row of the texture.
fn lobes_weight(position: f32, row: u32) -> vec4<f32> {
    let lower = min(u32(position), lobes_parameters.nodes - 2u);
    let low = textureLoad(lobes_weights, vec2<u32>(lower, row), 0);
    let high = textureLoad(lobes_weights, vec2<u32>(lower + 1u, row), 0);
    return low + (position - f32(lower)) * (high - low);
}

// 0 at the normal, 1 at the horizon.
fn lobes_view_position(cosine: f32) -> f32 {
    return min(sqrt(max(1.0 - cosine, 0.0)), 1.0);
}

// 0 to 1 for a turn from the tangent over the bitangent.
fn lobes_view_azimuth(outgoing: vec3<f32>) -> f32 {
    let sum = abs(outgoing.x) + abs(outgoing.y);
    var along = 1.0;
    if sum > 0.0 {
        along = outgoing.x / sum;
    }
    return 0.25 * select(3.0 + along, 1.0 - along, outgoing.y >= 0.0);
}

// Unit vector from the normal along the plane of view; above the normal, the tangent.
fn lobes_plane_of_view(outgoing: vec3<f32>) -> vec2<f32> {
    let sine = sqrt(outgoing.x * outgoing.x + outgoing.y * outgoing.y);
    if sine > 0.0 {
        return outgoing.xy / sine;
    }
    return vec2<f32>(1.0, 0.0);
}

// Direction of a lobe in the local frame. The first slope of its tilt is along the axis.
fn lobes_direction(outgoing: vec3<f32>, tilt: vec2<f32>, anchor: u32, axis: vec2<f32>) -> vec3<f32> {
    let length = sqrt(tilt.x * tilt.x + tilt.y * tilt.y + 1.0);
    let h = vec3<f32>(
        (axis.x * tilt.x - axis.y * tilt.y) / length,
        (axis.y * tilt.x + axis.x * tilt.y) / length,
        1.0 / length,
    );
    if anchor == 0u {
        return h;
    }
    let projection = 2.0 * (h.x * outgoing.x + h.y * outgoing.y + h.z * outgoing.z);
    let mirrored = projection * h - outgoing;
    return select(mirrored, vec3<f32>(-mirrored.xy, mirrored.z), anchor == 2u);
}
