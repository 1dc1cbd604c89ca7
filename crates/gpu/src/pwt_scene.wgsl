// Draws a scene of one polynomial wavelet tree under point lights. Appended to `formats/src/pwt/pwt.wgsl` and `view.wgsl`;
// the CPU twin is `crates/render/src/pwt` with `shading_point.rs`.

struct PwtMaterial {
    repeat: u32, // images per unit of uv
    reserved_0: u32,
    reserved_1: u32,
    reserved_2: u32,
}

@group(2) @binding(0) var<uniform> material: PwtMaterial;

const PI: f32 = 3.14159274;

@fragment
fn shade(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    // v runs down in the image, and along the bitangent on the surface.
    let down = select(in.uv.y, 1.0 - in.uv.y, front);
    let uv = vec2<f32>(in.uv.x, down) * f32(material.repeat);
    let level = pwt_mipmap_level(dpdx(uv), dpdy(uv));
    let v = normalize(view.eye.xyz - in.position);
    let n = normalize(in.normal);
    let frame = turned_frame(select(-n, n, front), in.tangent, v);
    let wo = vec3<f32>(dot(v, frame[0]), dot(v, frame[1]), dot(v, frame[2]));
    var radiance = vec3<f32>(0.0);
    for (var k = 0u; k < view.light_count; k += 1u) {
        let to_light = lights[k].position.xyz - in.position;
        let distance_squared = dot(to_light, to_light);
        let l = to_light / sqrt(distance_squared);
        let wi = vec3<f32>(dot(l, frame[0]), dot(l, frame[1]), dot(l, frame[2]));
        radiance += pwt_value(uv, level, wo, wi) * lights[k].intensity.rgb / (PI * distance_squared);
    }
    return vec4<f32>(radiance, 1.0);
}
