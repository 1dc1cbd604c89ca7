// Draws polynomial wavelet trees on a page.

// v points down in the image, and along the bitangent on the surface.
fn placed(uv: vec2<f32>, front: bool) -> vec2<f32> {
    return vec2<f32>(uv.x, select(uv.y, 1.0 - uv.y, front)) * view.repeat;
}

// The level of a whole pixel, for any number of samples.
fn level_at(distance: f32, right: vec2<f32>, below: vec2<f32>) -> f32 {
    let whole = exp2(view.octaves);
    return pwt_mipmap_level(right * whole, below * whole);
}

fn looked(in: Varying, front: bool, frame: mat3x3<f32>, uv: vec2<f32>, level: f32, wo: vec3<f32>) -> Look {
    return Look(in.position, false, false);
}

fn reflected(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    return pwt_value(uv, level, wo, wi) / PI;
}
