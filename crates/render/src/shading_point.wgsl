// Local frames of surfaces; the CPU twin is `shading_point.rs`.

// Minimum cosine between normal and viewer, to which shading normals are bent.
const LOWEST_VIEW: f32 = 0.02;

// Tangent, bitangent and normal around a unit normal, which is turned towards the viewer at outlines.
fn turned_frame(normal: vec3<f32>, tangent: vec3<f32>, v: vec3<f32>) -> mat3x3<f32> {
    var n = normal;
    let cosine = dot(n, v);
    if cosine < LOWEST_VIEW {
        n = normalize(n + v * (LOWEST_VIEW - cosine));
    }
    let t = normalize(tangent - n * dot(n, tangent));
    return mat3x3<f32>(t, cross(n, t), n);
}
