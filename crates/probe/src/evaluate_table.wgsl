// Functions that `evaluate.wgsl` calls, for table packs.

fn log_value_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    let values = table_brdf_log_values(wi, wo, level, hardware);
    return values.fine + values.coarse_weight * (values.coarse - values.fine);
}

fn f_r_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    return table_brdf_at(wi, wo, level, hardware);
}

fn level_at(distance: f32) -> f32 {
    return table_brdf_level_of_detail(distance);
}
