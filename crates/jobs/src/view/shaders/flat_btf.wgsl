// Draws flat BTFs on a page.

// On back faces v is negated, so that it follows the bitangent there, too.
fn placed(uv: vec2<f32>, front: bool) -> vec2<f32> {
    return select(vec2<f32>(uv.x, -uv.y), uv, front) * view.repeat;
}

fn level_at(distance: f32, right: vec2<f32>, below: vec2<f32>) -> f32 {
    return factored_mipmap_level(right, below);
}

var<private> flat_btf_seen_here: FlatBtfLook;

fn looked(in: Varying, front: bool, frame: mat3x3<f32>, uv: vec2<f32>, level: f32, wo: vec3<f32>) -> Look {
    let surface = covered_surface(in, front, frame, uv);
    let look = flat_btf_look(uv, level, wo, surface.flat_btf);
    flat_btf_seen_here = look;
    let at = in.position + frame * (surface.side * flat_btf_offset(look));
    return Look(at, surface.is_hidden || flat_btf_passes(look) || is_outside(surface, look), true);
}

fn reflected(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    return flat_btf_shade(flat_btf_seen_here, wi) / PI;
}
