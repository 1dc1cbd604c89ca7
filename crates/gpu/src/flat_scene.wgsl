// Draws a scene of one flat BTF under point lights. Appended to its decoder, to `view.wgsl`, and to `flat/cover.wgsl` and
// `flat/factors.wgsl` or `flat/trees.wgsl` of the renderer; the CPU twin is `crates/render/src/flat` with
// `shading_point.rs`.

struct FlatMaterial {
    repeat: u32,        // tiles per unit of uv
    finer: f32,         // octaves by which a sample covers less than its pixel
    reserved_0: u32,
    reserved_1: u32,
}

@group(2) @binding(0) var<uniform> material: FlatMaterial;

const PI: f32 = 3.14159274;

@fragment
fn shade(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let of_pixel = relief_level(dpdx(in.uv) * f32(material.repeat), dpdy(in.uv) * f32(material.repeat));
    let level = of_pixel - material.finer;
    let v = normalize(view.eye.xyz - in.position);
    let n = select(-1.0, 1.0, front) * normalize(in.normal);
    let frame = turned_frame(n, in.tangent, v);
    // On back faces v is negated, so that it runs along the bitangent there, too.
    let uv = select(vec2<f32>(in.uv.x, -in.uv.y), in.uv, front) * f32(material.repeat);
    let wo = vec3<f32>(dot(v, frame[0]), dot(v, frame[1]), dot(v, frame[2]));
    let surface = covered_surface(in, front, frame, uv);
    let look = relief_look(uv, level, wo, surface.flat_btf);
    let sight = relief_sight(look);
    if surface.is_hidden || flat_btf_sight_passes(sight) || is_outside(surface, sight) {
        discard;
    }
    let at = in.position + frame * (surface.side * flat_btf_sight_offset(sight));
    var radiance = vec3<f32>(0.0);
    for (var k = 0u; k < view.light_count; k += 1u) {
        let to_light = lights[k].position.xyz - at;
        let distance_squared = dot(to_light, to_light);
        let l = to_light / sqrt(distance_squared);
        let wi = vec3<f32>(dot(l, frame[0]), dot(l, frame[1]), dot(l, frame[2]));
        radiance += relief_shade(look, wi) * lights[k].intensity.rgb / (PI * distance_squared);
    }
    return vec4<f32>(radiance, 1.0);
}
