// Flat BTFs: the point of the surface that a pixel shows, and its value under each light.
//
// The CPU version is `FlatMaterial::value` of the crate `brdfc-render`.
//
// Usage: append this file to `decoder.wgsl`, `factored/factored.wgsl` and `direction_mesh.wgsl`, and call
//
//     let level = factored_mipmap_level(dpdx(uv), dpdy(uv)); // in a fragment shader, in uniform control flow
//     let look = flat_btf_look(uv, level, view);             // once for a pixel
//     let value = flat_btf_shade(look, light);               // for each light
//
// uv is in tiles and unbounded; view and light are unit vectors in the frame x = tangent, y = bitangent, z = normal. A
// light of intensity I at the distance d adds value * I / (π d²) to the radiance: the value includes the cosine and
// the shadow. flat_btf_value does both steps.

// A point of the surface as one view sees it.
struct FlatBtfLook {
    view: vec3<f32>,
    level: f32,
    point: FlatBtfPoint,
    place: FactoredPlace,
    base: FactoredBase,
}

// The point of the surface that a view sees behind the point uv of the reference plane.
fn flat_btf_look(uv: vec2<f32>, level_of_detail: f32, view: vec3<f32>) -> FlatBtfLook {
    let detail = level_of_detail + flat_btf_parameters.finer;
    let point = flat_btf_seen(uv, view, detail);
    let place = factored_place(flat_btf_parameters_at(point, detail), level_of_detail);
    return FlatBtfLook(view, level_of_detail, point, place, factored_load(place));
}

// Radiance divided by that of a white diffuser that faces the light: linear RGB, 0 below the horizon. Use the last
// result of flat_btf_look, which also sets the weights of the components.
fn flat_btf_shade(look: FlatBtfLook, light: vec3<f32>) -> vec3<f32> {
    if light.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    var value = vec3<f32>(0.0);
    if factored_parameters.groups == 0u {
        value = factored_base_colour(look.base, look.view, light);
    } else {
        // First row of the lights' mesh, and cosine of the largest polar angle of a sampled light.
        let row = textureLoad(direction_mesh_words, vec2<u32>(0u, 0u), 0).x;
        let lowest_light = bitcast<f32>(textureLoad(direction_mesh_words, vec2<u32>(1u, 0u), 0).x);
        let seen_from = direction_mesh_weights(look.view, 1u);
        let lit_from = direction_mesh_weights(light, row);
        let views = FactoredWeights(seen_from.indices, seen_from.weights);
        let lights = FactoredWeights(lit_from.indices, lit_from.weights);
        value = factored_value(look.place, look.base, look.view, light, views, lights);
        // Lights lower than all sampled ones are dimmed by the ratio of cosines.
        value = value * min(light.z / lowest_light, 1.0);
    }
    if flat_btf_parameters.casts_shadows == 0u || all(value == vec3<f32>(0.0)) {
        return value;
    }
    let detail = look.level + flat_btf_parameters.finer;
    return value * flat_btf_lit(look.point, look.base.normal, light, detail);
}

// Both steps, for a single light.
fn flat_btf_value(uv: vec2<f32>, level_of_detail: f32, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    return flat_btf_shade(flat_btf_look(uv, level_of_detail, view), light);
}
