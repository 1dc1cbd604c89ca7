// Flat BTFs: the point of the surface that a pixel shows, and its value under each light.
//
// The CPU version is `FlatBtfLook` of the crate `brdfc-formats`.
//
// Usage: append this file to `decoder.wgsl`, `vdim.wgsl`, `shadows.wgsl`, `sight.wgsl`, `factored/factored.wgsl` and
// `direction_mesh.wgsl`, and call
//
//     let level = factored_mipmap_level(dpdx(uv), dpdy(uv)); // in a fragment shader, in uniform control flow
//     let surface = FlatBtfSurface(curvature, height, stretch); // see flat_btf_curvature and flat_btf_stretch; on a
//                                                               // plane zeros and FLAT_BTF_SQUARE
//     let look = flat_btf_look(uv, level, view, surface);    // once for a pixel
//     if flat_btf_passes(look) { discard; }                  // outside the outline of the relief
//     let at = position + frame * (side * flat_btf_offset(look)); // where distances to near lights begin
//     let value = flat_btf_shade(look, light);               // for each light
//
// uv is in tiles and unbounded; view and light are unit vectors in the frame x = tangent, y = bitangent, z = normal. A
// light of intensity I at the distance d adds value * I / (π d²) to the radiance: the value includes the cosine and
// the shadow. flat_btf_value does both steps on a plane.
//
// A relief of layers has its own outline if a mesh is drawn twice: moved along its normals to the highest and to the lowest point
// of the relief, by (low + range) and by low of flat_btf_parameters times the side of a tile there; of the first only the
// front. height is then that of the pixel, the distance by which it was moved over flat_btf_tile_side, negated on back
// faces.

// A point of the surface as one view sees it, with its reflectance.
struct FlatBtfLook {
    sight: FlatBtfSight,
    place: FactoredPlace,
    base: FactoredBase,
}

// The point of the relief that a view sees behind the point uv of a surface.
fn flat_btf_look(uv: vec2<f32>, level_of_detail: f32, view: vec3<f32>, surface: FlatBtfSurface) -> FlatBtfLook {
    let sight = flat_btf_sight(uv, level_of_detail, view, surface);
    let place = factored_place(sight.parameters, level_of_detail);
    var base = factored_load(place);
    base.normal = flat_btf_stretched(surface, base.normal);
    return FlatBtfLook(sight, place, base);
}

// True if the ray of sight passes the relief of a convex surface: nothing is to be drawn.
fn flat_btf_passes(look: FlatBtfLook) -> bool {
    return flat_btf_sight_passes(look.sight);
}

// Position of the visible point less that of the point that is drawn, in the frame that is drawn and in tiles: along the
// line of sight.
fn flat_btf_offset(look: FlatBtfLook) -> vec3<f32> {
    return flat_btf_sight_offset(look.sight);
}

// Radiance divided by that of a white diffuser that faces the light: linear RGB, 0 below the horizon. Use the last
// result of flat_btf_look, which also sets the weights of the components.
fn flat_btf_shade(look: FlatBtfLook, incoming: vec3<f32>) -> vec3<f32> {
    let light = flat_btf_tilted(incoming, look.sight.tilt);
    if light.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    var value = vec3<f32>(0.0);
    var dimmed = 1.0;
    var lights = FactoredWeights(vec3<u32>(0u), vec3<f32>(0.0));
    if factored_parameters.groups > 0u || flat_btf_parameters.lights > 0u {
        // First row of the lights' mesh.
        let row = textureLoad(direction_mesh_words, vec2<u32>(0u, 0u), 0).x;
        let lit_from = direction_mesh_weights(flat_btf_aligned(look.sight.surface, light), row);
        lights = FactoredWeights(lit_from.indices, lit_from.weights);
    }
    if factored_parameters.groups == 0u {
        value = factored_base_colour(look.base, look.sight.view, light);
    } else {
        // Cosine of the largest polar angle of a sampled light.
        let lowest_light = bitcast<f32>(textureLoad(direction_mesh_words, vec2<u32>(1u, 0u), 0).x);
        let seen_from = direction_mesh_weights(flat_btf_aligned(look.sight.surface, look.sight.view), 1u);
        let views = FactoredWeights(seen_from.indices, seen_from.weights);
        value = factored_value(look.base, look.sight.view, light, views, lights);
        // Lights lower than all sampled ones are dimmed by the ratio of cosines.
        dimmed = min(light.z / lowest_light, 1.0);
    }
    var lit = 0.0;
    if any(value != vec3<f32>(0.0)) && factored_dot(look.base.normal, light) > 0.0 {
        lit = flat_btf_reached(look, light, lights);
    }
    return factored_shadowed(value, look.place, look.base, lights, lit) * dimmed;
}

// Share, 0 to 1, of a light above the normal that reaches the visible point. light is in the frame below the point.
fn flat_btf_reached(look: FlatBtfLook, light: vec3<f32>, lights: FactoredWeights) -> f32 {
    if flat_btf_parameters.sheets > 0u {
        let detail = look.sight.level + flat_btf_parameters.finer;
        return flat_btf_lit(look.sight.point, look.base.normal, light, look.sight.surface, detail);
    }
    if flat_btf_parameters.lights == 0u {
        return 1.0;
    }
    var lit = 0.0;
    for (var l = 0u; l < 3u; l += 1u) {
        if lights.weights[l] != 0.0 {
            let place = look.place;
            lit = lit + lights.weights[l] * flat_btf_shadow(place.uv, place.level, place.blend, lights.indices[l]);
        }
    }
    return lit;
}

// Both steps on a plane, for a single light.
fn flat_btf_value(uv: vec2<f32>, level_of_detail: f32, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let plane = FlatBtfSurface(vec3<f32>(0.0), 0.0, FLAT_BTF_SQUARE);
    return flat_btf_shade(flat_btf_look(uv, level_of_detail, view, plane), light);
}
