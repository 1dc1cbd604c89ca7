// Draws a scene of materials under point lights. Appended to the decoders of packs, `brdf.wgsl`,
// `view.wgsl`, `periodic.wgsl`, `surface.wgsl` and `environment.wgsl`; the CPU twin is `crates/render/src/shade.rs`, step by
// step.

@group(2) @binding(2) var environment: texture_2d<f32>;

@fragment
fn shade(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let to_eye = view.eye.xyz - in.position;
    let distance = length(to_eye);
    let v = to_eye / distance;
    let frame = shading_frame(in, front, v);
    let wo = vec3<f32>(dot(v, frame[0]), dot(v, frame[1]), dot(v, frame[2]));
    var level = view.level;
    if level < 0.0 {
        level = brdf_level_of_detail(distance);
    }

    // Equation 1 of Claustres et al. 2007.
    var radiance = vec3<f32>(0.0);
    for (var k = 0u; k < view.light_count; k += 1u) {
        let to_light = lights[k].position.xyz - in.position;
        let distance_squared = dot(to_light, to_light);
        let l = to_light / sqrt(distance_squared);
        let wi = vec3<f32>(dot(l, frame[0]), dot(l, frame[1]), dot(l, frame[2]));
        if wi.z > 0.0 {
            let f_r = brdf(wi, wo, level, view.hardware == 1u);
            radiance += f_r * lights[k].intensity.rgb * (wi.z / distance_squared);
        }
    }

    let fresnel = mirror_share(wo.z);
    if fresnel > 0.0 {
        let mirrored = 2.0 * dot(frame[2], v) * frame[2] - v;
        radiance = (1.0 - fresnel) * radiance + fresnel * environment_at(mirrored);
    }
    return vec4<f32>(radiance, 1.0);
}
