// Light that lobes reflect from the environment of a page.

fn lit_by_environment(frame: mat3x3<f32>, wo: vec3<f32>) -> vec3<f32> {
    var radiance = vec3<f32>(0.0);
    for (var k = 0u; k < lobes_count(); k += 1u) {
        let lobe = lobes_lookup(wo, k);
        radiance += lobe.weight * environment_radiance(in_environment(frame * lobe.direction), lobe.sharpness);
    }
    return radiance;
}
