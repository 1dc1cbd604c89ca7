// Draws packs of BRDFs on a page. `brdf` and `brdf_level_of_detail`, which precede it, call the decoder.

fn placed(uv: vec2<f32>, front: bool) -> vec2<f32> {
    return uv;
}

fn level_at(distance: f32, right: vec2<f32>, below: vec2<f32>) -> f32 {
    return brdf_level_of_detail(distance);
}

fn looked(in: Varying, front: bool, frame: mat3x3<f32>, uv: vec2<f32>, level: f32, wo: vec3<f32>) -> Look {
    return Look(in.position, false, false);
}

fn reflected(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    return wi.z * brdf(wi, wo, level);
}
