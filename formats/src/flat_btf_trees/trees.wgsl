// Flat BTFs whose reflectance is polynomial wavelet trees: the value of a point of the surface under each light.
//
// After Baril, Boubekeur, Gioia and Schlick 2008, "Polynomial wavelet trees for bidirectional texture functions". The CPU
// version is `FlatTrees` of the crate `brdfc-formats`. Layout: `formats/src/flat_btf_trees/spec.md`.
//
// Usage: append this file to `decoder.wgsl`, `vdim.wgsl` and `sight.wgsl` of flat BTFs, `direction_mesh.wgsl` and `pwt.wgsl`,
// and call
//
//     let level = flat_trees_mipmap_level(dpdx(uv), dpdy(uv)); // in a fragment shader, in uniform control flow
//     let surface = FlatBtfSurface(curvature, height, stretch); // see flat_btf_curvature and flat_btf_stretch; on a
//                                                               // plane zeros and FLAT_BTF_SQUARE
//     let sight = flat_btf_sight(uv, level, view, surface);    // once for a pixel
//     if flat_btf_sight_passes(sight) { discard; }             // outside the outline of the relief
//     let at = position + frame * (side * flat_btf_sight_offset(sight)); // where distances to near lights begin
//     let value = flat_trees_shade(sight, light);              // for each light
//
// Arguments, values and outlines are those of `value.wgsl` of flat BTFs. flat_trees_value does both steps on a plane.

// Same fields and order as `FlatTreesParameters` of `brdfc-formats`. 16 bytes.
struct FlatTreesParameters {
    has_shadows: u32,   // 1: the trees contain the shadows of the relief; 0: rays of light find them
    lowest_light: f32,  // cosine of the largest polar angle of a fitted light
    reserved_0: u32,
    reserved_1: u32,
}

@group(1) @binding(49) var<uniform> flat_trees_parameters: FlatTreesParameters;

// Level of detail of a pixel from the differences of uv to the pixels on the right and below, dpdx(uv) and dpdy(uv):
// half the mean, in octaves, of both sides of its footprint. With n x n samples per pixel subtract log2(n).
fn flat_trees_mipmap_level(right: vec2<f32>, below: vec2<f32>) -> f32 {
    let across = right * pwt.size;
    let down = below * pwt.size;
    return 0.25 * log2(max(dot(across, across) * dot(down, down), 1e-20)) - 1.0;
}

// Radiance divided by that of a white diffuser that faces the light: linear RGB, 0 below the horizon.
fn flat_trees_shade(sight: FlatBtfSight, incoming: vec3<f32>) -> vec3<f32> {
    let light = flat_btf_tilted(incoming, sight.tilt);
    if light.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let uv = vec2<f32>(flat_btf_wrap(sight.parameters.x), flat_btf_wrap(sight.parameters.y));
    let view = flat_btf_aligned(sight.surface, sight.view);
    let raised = flat_btf_raised(flat_btf_aligned(sight.surface, light), flat_trees_parameters.lowest_light);
    let value = pwt_value(uv, sight.level, view, raised);
    var lit = 1.0;
    if any(value != vec3<f32>(0.0)) && flat_trees_parameters.has_shadows == 0u && flat_btf_parameters.sheets > 0u {
        // Trees have no normals: the ray starts above the point.
        let detail = sight.level + flat_btf_parameters.finer;
        lit = flat_btf_lit(sight.point, vec3<f32>(0.0, 0.0, 1.0), light, sight.surface, detail);
    }
    // Lights lower than all fitted ones are dimmed by the ratio of cosines.
    return value * lit * min(light.z / flat_trees_parameters.lowest_light, 1.0);
}

// Both steps on a plane, for a single light.
fn flat_trees_value(uv: vec2<f32>, level_of_detail: f32, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let plane = FlatBtfSurface(vec3<f32>(0.0), 0.0, FLAT_BTF_SQUARE);
    return flat_trees_shade(flat_btf_sight(uv, level_of_detail, view, plane), light);
}
