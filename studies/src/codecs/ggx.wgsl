// The model of `Ggx` for the study of codecs. The constants KD, F0 and ALPHA are inserted before it.

fn stretched_length(w: vec3<f32>) -> f32 {
    let v = vec3<f32>(ALPHA * w.xy, w.z);
    return sqrt(dot(v, v));
}

fn f_r_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    if !(wi.z > 0.0 && wo.z > 0.0) {
        return vec3<f32>(0.0);
    }
    let h = normalize(wi + wo);
    let stretched = vec3<f32>(h.xy / ALPHA, h.z);
    let slope = dot(stretched, stretched);
    let distribution = 0.318309886 / (ALPHA.x * ALPHA.y * slope * slope);
    let masked = distribution / (2.0 * (wo.z * stretched_length(wi) + wi.z * stretched_length(wo)));
    let schlick = pow(1.0 - min(dot(h, wi), 1.0), 5.0);
    return 0.318309886 * KD + masked * (F0 + (1.0 - F0) * schlick);
}

fn log_value_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    return vec3<f32>(0.0);
}

fn level_at(distance: f32) -> f32 {
    return 0.0;
}
