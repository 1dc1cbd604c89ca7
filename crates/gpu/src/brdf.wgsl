// Packs of either codec in one shader, by the bindings that are not empty. Appended to `formats/src/wavelet/decode.wgsl`
// and `formats/src/table/decode.wgsl`; the CPU twin is `BrdfDecoder` of the crate `brdfc-formats`.

// f_r at a level of detail; `hardware`: the sampler filters.
fn brdf(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    if table_brdf_parameters.layers > 0u {
        return table_brdf_at(wi, wo, level, hardware);
    }
    if hardware {
        return wavelet_brdf(wi, wo, level);
    }
    return wavelet_brdf_exact(wi, wo, level);
}

// The level of detail at a distance from the viewer.
fn brdf_level_of_detail(distance: f32) -> f32 {
    if table_brdf_parameters.layers > 0u {
        return table_brdf_level_of_detail(distance);
    }
    return wavelet_brdf_level_of_detail(distance);
}
