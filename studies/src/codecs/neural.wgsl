// The model of `NeuralBrdf` for the study of codecs. Its layers are inserted below.

fn f_r_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    if !(wi.z > 0.0 && wo.z > 0.0) {
        return vec3<f32>(0.0);
    }
    let h = normalize(wi + wo);
    let sine = length(h.xy);
    var azimuth = vec2<f32>(1.0, 0.0);
    if sine > 1e-6 {
        azimuth = h.xy / sine;
    }
    // The incident direction in the frame of the half vector.
    let along = dot(azimuth, wi.xy);
    let x = along * h.z - wi.z * sine;
    let y = azimuth.x * wi.y - azimuth.y * wi.x;
    let v0_0 = vec4<f32>(sine, 0.0, h.z, x);
    let v0_1 = vec4<f32>(y, dot(h, wi), 0.0, 0.0);
    // LAYERS
    return max(exp(v3_0.xyz) - 1.0, vec3<f32>(0.0));
}

fn log_value_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    return vec3<f32>(0.0);
}

fn level_at(distance: f32) -> f32 {
    return 0.0;
}
