// Draws what a prefiltered environment adds to a scene, below the mirrors of its surfaces. Appended to
// `formats/src/environment/environment.wgsl`, `formats/src/lobes/lobes.wgsl`, `view.wgsl`, `periodic.wgsl` and
// `surface.wgsl`; the CPU twin is `crates/render/src/lobes.rs`.

@fragment
fn shade(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let v = normalize(view.eye.xyz - in.position);
    let frame = shading_frame(in, front, v);
    let wo = vec3<f32>(dot(v, frame[0]), dot(v, frame[1]), dot(v, frame[2]));
    var radiance = vec3<f32>(0.0);
    for (var k = 0u; k < lobes_count(); k += 1u) {
        let lobe = lobes_lookup(wo, k);
        let direction = lobe.direction.x * frame[0] + lobe.direction.y * frame[1] + lobe.direction.z * frame[2];
        radiance += lobe.weight * environment_radiance(direction, lobe.sharpness);
    }
    return vec4<f32>((1.0 - mirror_share(wo.z)) * radiance, 1.0);
}
