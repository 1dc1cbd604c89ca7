// Functions that `evaluate.wgsl` calls, for wavelet packs.

fn log_value_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    return wavelet_brdf_log_value(wi, wo, level, hardware);
}

fn f_r_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    if hardware {
        return wavelet_brdf(wi, wo, level);
    }
    return wavelet_brdf_exact(wi, wo, level);
}

fn level_at(distance: f32) -> f32 {
    return wavelet_brdf_level_of_detail(distance);
}
