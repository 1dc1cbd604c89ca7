// How a page draws table packs.

fn placed(uv: vec2<f32>, front: bool) -> vec2<f32> {
    return uv;
}

fn level_at(distance: f32, right: vec2<f32>, below: vec2<f32>) -> f32 {
    return table_brdf_level_of_detail(distance);
}

fn reflected(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    return wi.z * table_brdf_at(wi, wo, level, true);
}
