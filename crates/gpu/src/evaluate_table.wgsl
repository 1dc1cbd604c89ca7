// What `evaluate.wgsl` calls, of table packs, which have no levels of detail.

fn log_value_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    return table_brdf_log_value(wi, wo, hardware);
}

fn f_r_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    if hardware {
        return table_brdf(wi, wo);
    }
    return table_brdf_exact(wi, wo);
}

fn level_at(distance: f32) -> f32 {
    return 0.0;
}
