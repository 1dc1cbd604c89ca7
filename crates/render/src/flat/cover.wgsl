// The surface that a relief covers around a point of a covered mesh; the CPU twin is `cover.rs`. Appended to
// `corner.wgsl` and to the decoder that ends with `formats/src/flat_btf/value.wgsl`.

struct CoveredSurface {
    flat_btf: FlatBtfSurface,
    side: f32,       // of a tile
    is_hidden: bool, // the back of a raised triangle, which is not drawn
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
    return CoveredSurface(FlatBtfSurface(curvature, height), side, in.raised_by > 0.0 && !front);
}
