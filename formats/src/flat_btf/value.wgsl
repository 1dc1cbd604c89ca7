// Flat BTFs in one call: the value between sampled views and lights.
//
// The CPU version is `FlatMaterial::value` of the crate `brdfc-render`.
//
// Usage: append this file to `decoder.wgsl`, `factored/factored.wgsl` and `direction_mesh.wgsl`, whose texture is the
// image `direction_mesh_words` of the file, and call
//
//     let level = factored_mipmap_level(dpdx(uv), dpdy(uv)); // in a fragment shader, in uniform control flow
//     let value = flat_btf_value(uv, level, view, light);
//
// uv is in tiles and unbounded; view and light are unit vectors in the frame x = tangent, y = bitangent, z = normal. A
// light of intensity I at the distance d adds value * I / (π d²) to the radiance: the value includes the cosine.

// Radiance divided by that of a white diffuser that faces the light: linear RGB, 0 below the horizon.
fn flat_btf_value(uv: vec2<f32>, level_of_detail: f32, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    if light.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    if flat_btf_parameters.values == 0u {
        return flat_btf_light_form(uv, view, light);
    }
    // First row of the lights' mesh, and cosine of the largest polar angle of a sampled light.
    let row = textureLoad(direction_mesh_words, vec2<u32>(0u, 0u), 0).x;
    let lowest_light = bitcast<f32>(textureLoad(direction_mesh_words, vec2<u32>(1u, 0u), 0).x);
    let seen_from = direction_mesh_weights(view, 1u);
    let lit_from = direction_mesh_weights(light, row);
    let views = FlatBtfWeights(seen_from.indices, seen_from.weights);
    let lights = FlatBtfWeights(lit_from.indices, lit_from.weights);
    var value: vec3<f32>;
    if flat_btf_parameters.values == 2u {
        value = factored_value(flat_btf_indirection(uv, view).xy, level_of_detail, view, light, views, lights);
    } else {
        value = flat_btf_full(uv, view, views, lights);
    }
    // Lights lower than all sampled ones are dimmed by the ratio of cosines.
    return value * min(light.z / lowest_light, 1.0);
}
