// Directions drawn in proportion to a material's lobe.
//
// Layout: `formats/src/importance/spec.md`. The CPU decoder `ImportancePack::sample` of the crate `brdfc-formats`
// performs the same steps in the same order.
//
// Usage: prepend this file to your own shader, move the two bindings as needed, and sum over any N consecutive indices:
//
//     let drawn = importance_sample(outgoing, first + i);
//     sum += drawn.inverse_density * radiance(drawn.incoming) * f_r(drawn.incoming, outgoing) * drawn.incoming.z;
//
// sum / N is the reflected radiance. outgoing (to the viewer) and incoming (to the light) are unit vectors in the
// frame x = tangent, y = bitangent, z = normal. It takes one fetch.

// 16 bytes: `ImportanceHeader::uniform` of `brdfc-formats`.
struct ImportanceParameters {
    polar: u32,     // P, number of polar angles of the outgoing direction
    azimuths: u32,  // A, number of azimuths; 1: the material is isotropic
    samples: u32,   // M, samples per outgoing direction
    reserved: u32,
}

struct ImportanceSample {
    incoming: vec3<f32>,
    // 1 / density per steradian of incoming directions; 0 if the sample counts but contributes nothing.
    inverse_density: f32,
}

@group(1) @binding(35) var<uniform> importance_parameters: ImportanceParameters;
// M x (P A) texels of four 32-bit floats, as in the file. Not filtered.
@group(1) @binding(36) var importance_texels: texture_2d<f32>;

// Sample with this index, modulo M; outgoing is a unit vector.
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

// Returns true if A is 1. Reads the texture, because lavapipe of Mesa 22.3 writes out of bounds if a compute shader has
// many uniform blocks and a late one decides a branch.
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

// Row of the cell that contains an outgoing direction.
fn importance_row(outgoing: vec3<f32>) -> u32 {
    let root = sqrt(max(1.0 - outgoing.z, 0.0));
    let polar = min(u32(root * f32(importance_parameters.polar)), importance_parameters.polar - 1u);
    if importance_is_isotropic() {
        return polar;
    }
    // 0 at the tangent, 1 at the bitangent, below 4 in total.
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
