// Draws flat BTFs on a page.

// On back faces v is negated, so that it follows the bitangent there, too.
fn placed(uv: vec2<f32>, front: bool) -> vec2<f32> {
    return select(vec2<f32>(uv.x, -uv.y), uv, front) * view.repeat;
}

fn level_at(distance: f32, right: vec2<f32>, below: vec2<f32>) -> f32 {
    return factored_mipmap_level(right, below);
}

fn reflected(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    return flat_btf_value(uv, level, wo, wi) / PI;
}
