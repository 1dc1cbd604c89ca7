// The surface that a relief covers around a point of a covered mesh; the CPU twin is `cover.rs`. Appended to
// `corner.wgsl` and to the decoder of a flat BTF.

struct CoveredSurface {
    flat_btf: FlatBtfSurface,
    side: f32,       // of a tile
    is_hidden: bool, // the back of a raised triangle, which is not drawn
    border: vec3<f32>, // distance from the open border, and its change along tangent and bitangent
}

// In uniform control flow. uv is in tiles.
fn covered_surface(in: Varying, front: bool, frame: mat3x3<f32>, uv: vec2<f32>) -> CoveredSurface {
    let sign = select(-1.0, 1.0, front);
    // Linear numbers: triangles may be smaller than a pixel, and derivatives extrapolate.
    let right = dpdx(in.base);
    let below = dpdy(in.base);
    let turn_right = dpdx(in.normal) * (sign / length(in.normal));
    let turn_below = dpdy(in.normal) * (sign / length(in.normal));
    let side = flat_btf_tile_side(right, below, dpdx(uv), dpdy(uv), frame[0], frame[1]);
    let curvature = flat_btf_curvature(right, below, turn_right, turn_below, frame[0], frame[1], side);
    let height = select(0.0, sign * in.raised_by / max(side, 1e-20), side > 0.0);
    let stretch = flat_btf_stretch(right, below, dpdx(uv), dpdy(uv), frame[0], frame[1], side);
    let border = border_around(in.border, dpdx(in.border), dpdy(in.border), right, below, frame);
    return CoveredSurface(FlatBtfSurface(curvature, height, stretch), side, in.raised_by > 0.0 && !front, border);
}

// Distance from the border, and its change along tangent and bitangent, from its changes to the pixels on the right and below.
fn border_around(
    border: f32, border_right: f32, border_below: f32, right: vec3<f32>, below: vec3<f32>, frame: mat3x3<f32>
) -> vec3<f32> {
    let a = vec2<f32>(dot(right, frame[0]), dot(right, frame[1]));
    let b = vec2<f32>(dot(below, frame[0]), dot(below, frame[1]));
    let determinant = a.x * b.y - a.y * b.x;
    if abs(determinant) <= 1e-6 * (dot(a, a) + dot(b, b)) {
        return vec3<f32>(border, 0.0, 0.0);
    }
    let along = vec2<f32>(border_right * b.y - border_below * a.y, border_below * a.x - border_right * b.x);
    // A distance does not change faster than the position.
    let gradient = along / determinant;
    return vec3<f32>(border, gradient / max(length(gradient), 1.0));
}

// True if the visible point is beyond the border, where no surface carries it.
fn is_outside(surface: CoveredSurface, sight: FlatBtfSight) -> bool {
    return surface.border.x + surface.side * dot(surface.border.yz, sight.moved) < 0.0;
}
