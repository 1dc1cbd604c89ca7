// Draws flat BTFs on a page. Appended to `flat/cover.wgsl` and `flat/factors.wgsl` or `flat/trees.wgsl` of the renderer.

// On back faces v is negated, so that it follows the bitangent there, too.
fn placed(uv: vec2<f32>, front: bool) -> vec2<f32> {
    return select(vec2<f32>(uv.x, -uv.y), uv, front) * view.repeat;
}

fn level_at(distance: f32, right: vec2<f32>, below: vec2<f32>) -> f32 {
    return relief_level(right, below);
}

var<private> relief_seen_here: ReliefLook;

fn looked(in: Varying, front: bool, frame: mat3x3<f32>, uv: vec2<f32>, level: f32, wo: vec3<f32>) -> Look {
    let surface = covered_surface(in, front, frame, uv);
    let look = relief_look(uv, level, wo, surface.flat_btf);
    relief_seen_here = look;
    let sight = relief_sight(look);
    let at = in.position + frame * (surface.side * flat_btf_sight_offset(sight));
    return Look(at, surface.is_hidden || flat_btf_sight_passes(sight) || is_outside(surface, sight), true);
}

fn reflected(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    return relief_shade(relief_seen_here, wi) / PI;
}
