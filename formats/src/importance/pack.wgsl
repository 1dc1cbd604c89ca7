// Directions drawn in proportion to a material's lobe.
//
// The layout of the file is described in `formats/src/importance/spec.md`; the CPU decoder with the same steps in
// the same order is `ImportancePack::sample` of the crate `brdfc-formats`.
//
// To use it: paste this file before your own shader, move the two bindings where they suit you, and sum over any N
// consecutive indices:
//
//     let drawn = importance_sample(outgoing, first + i);
//     sum += drawn.inverse_density * radiance(drawn.incoming) * f_r(drawn.incoming, outgoing) * drawn.incoming.z;
//
// sum / N is the reflected radiance. outgoing (to the viewer) and incoming (to the light) are unit vectors in the
// frame x = tangent, y = bitangent, z = normal. One fetch.

// 16 bytes: `ImportanceHeader::uniform` of `brdfc-formats`.
struct ImportanceParameters {
    polar: u32,     // P, polar angles of the outgoing direction
    azimuths: u32,  // A, its azimuths; 1: the material is isotropic
    samples: u32,   // M, samples of each outgoing direction
    reserved: u32,
}

struct ImportanceSample {
    incoming: vec3<f32>,
    // 1 / density per steradian of incoming directions; 0 where the sample is to be counted and to bring nothing.
    inverse_density: f32,
}

@group(1) @binding(35) var<uniform> importance_parameters: ImportanceParameters;
// M x (P A) texels of four 32-bit floats, as in the file. Not filtered.
@group(1) @binding(36) var importance_texels: texture_2d<f32>;

// The sample of this index, which wraps around; outgoing is a unit vector.
fn importance_sample(outgoing: vec3<f32>, index: u32) -> ImportanceSample {
    let at = vec2<u32>(index % importance_parameters.samples, importance_row(outgoing));
    let texel = textureLoad(importance_texels, at, 0);
    var half_vector = texel.xyz;
    if importance_is_isotropic() {
        half_vector = importance_turned(texel.xyz, outgoing);
    }
    let projection = outgoing.x * half_vector.x + outgoing.y * half_vector.y + outgoing.z * half_vector.z;
    let incoming = 2.0 * projection * half_vector - outgoing;
    if incoming.z <= 0.0 || outgoing.z <= 0.0 {
        return ImportanceSample(incoming, 0.0);
    }
    return ImportanceSample(incoming, 4.0 * projection / texel.w);
}

// Whether A is 1. From the texture, as lavapipe of Mesa 22.3 writes past its own memory where a compute shader has many uniform
// blocks and a late one decides a branch.
fn importance_is_isotropic() -> bool {
    return textureDimensions(importance_texels).y == importance_parameters.polar;
}

// Rows of isotropic materials are for outgoing directions over the tangent.
fn importance_turned(half_vector: vec3<f32>, outgoing: vec3<f32>) -> vec3<f32> {
    let length = sqrt(outgoing.x * outgoing.x + outgoing.y * outgoing.y);
    if length > 0.0 {
        let cosine = outgoing.x / length;
        let sine = outgoing.y / length;
        let x = cosine * half_vector.x - sine * half_vector.y;
        let y = sine * half_vector.x + cosine * half_vector.y;
        return vec3<f32>(x, y, half_vector.z);
    }
    return half_vector;
}

// The row of the outgoing directions around this one.
fn importance_row(outgoing: vec3<f32>) -> u32 {
    let root = sqrt(max(1.0 - outgoing.z, 0.0));
    let polar = min(u32(root * f32(importance_parameters.polar)), importance_parameters.polar - 1u);
    if importance_is_isotropic() {
        return polar;
    }
    // From 0 at the tangent by 1 at the bitangent to below 4.
    let length = abs(outgoing.x) + abs(outgoing.y);
    var turn = 0.0;
    if length > 0.0 {
        turn = abs(outgoing.y) / length;
    }
    if outgoing.x < 0.0 {
        turn = 2.0 - turn;
    }
    if outgoing.y < 0.0 {
        turn = 4.0 - turn;
    }
    let azimuth = min(u32(0.25 * turn * f32(importance_parameters.azimuths)), importance_parameters.azimuths - 1u);
    return polar * importance_parameters.azimuths + azimuth;
}
