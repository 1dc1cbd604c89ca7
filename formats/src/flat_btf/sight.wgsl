// Flat BTFs: the point of the relief that a pixel shows, for every form of reflectance.
//
// The CPU version is `Sight` of the crate `brdfc-formats`.
//
// Usage: append this file to `decoder.wgsl` and `vdim.wgsl`. `value.wgsl` and `trees.wgsl` use it.

// Largest change of coordinates of a stretched tile: at the pole of a ball tiles have no width.
const FLAT_BTF_MAX_STRETCH: f32 = 16.0;

// A point of the surface as one view sees it.
struct FlatBtfSight {
    surface: FlatBtfSurface,
    view: vec3<f32>, // in the frame of the surface below the point
    level: f32,
    moved: vec2<f32>, // distance of the point along the surface from the one that is drawn, in sides of a tile
    slope: vec2<f32>, // tangent of the view's polar angle where it is drawn
    tilt: vec2<f32>, // x and y of that frame's normal in the frame that is drawn, with z = 1
    point: FlatBtfPoint,
    parameters: vec2<f32>, // of the point, not wrapped for indirection maps
}

// The point of the relief that a view sees behind the point uv of a surface.
fn flat_btf_sight(uv: vec2<f32>, level_of_detail: f32, view: vec3<f32>, surface: FlatBtfSurface) -> FlatBtfSight {
    let detail = level_of_detail + flat_btf_parameters.finer;
    var point = FlatBtfPoint(uv, 0.0, 0u, 0.0, 0u);
    var parameters = vec2<f32>(0.0);
    if flat_btf_parameters.sheets == 0u {
        // On the tangent plane.
        let seen = flat_btf_vdim_seen(uv, flat_btf_aligned(surface, view), detail);
        point.rise = seen.height;
        parameters = seen.parameters;
    } else {
        point = flat_btf_seen(uv, view, surface, detail);
        parameters = flat_btf_parameters_at(point, detail);
    }
    let moved = flat_btf_from_tiles(surface, point.at - uv);
    let tilt = flat_btf_product(surface.curvature, moved);
    return FlatBtfSight(
        surface, flat_btf_tilted(view, tilt), level_of_detail, moved, flat_btf_slope(view), tilt, point, parameters);
}

// True if the ray of sight passes the relief of a convex surface: nothing is to be drawn.
fn flat_btf_sight_passes(sight: FlatBtfSight) -> bool {
    return sight.point.height < 0.0;
}

// Position of the visible point less that of the point that is drawn, in the frame that is drawn and in tiles: along the
// line of sight.
fn flat_btf_sight_offset(sight: FlatBtfSight) -> vec3<f32> {
    return sight.point.rise * vec3<f32>(sight.slope, 1.0);
}

// Distance along tangent and bitangent, in sides of a tile, over a change of u and v: the inverse of flat_btf_tiles, 0 if there
// is none.
fn flat_btf_from_tiles(surface: FlatBtfSurface, tiles: vec2<f32>) -> vec2<f32> {
    let s = surface.stretch;
    let determinant = s.x * s.w - s.y * s.z;
    if determinant == 0.0 {
        return vec2<f32>(0.0);
    }
    return vec2<f32>((s.w * tiles.x - s.y * tiles.y) / determinant, (s.x * tiles.y - s.z * tiles.x) / determinant);
}

// A direction in the frame along u and v, to which sampled directions refer: the rotation, or for mirrored tiles the
// reflection, that is nearest to the stretch.
fn flat_btf_aligned(surface: FlatBtfSurface, v: vec3<f32>) -> vec3<f32> {
    let s = surface.stretch;
    let sign = select(1.0, -1.0, s.x * s.w - s.y * s.z < 0.0);
    let p = s.x + sign * s.w;
    let q = s.y - sign * s.z;
    let length = sqrt(p * p + q * q);
    if all(s == FLAT_BTF_SQUARE) || length == 0.0 {
        return v;
    }
    return vec3<f32>((p * v.x + q * v.y) / length, (p * v.y - q * v.x) * sign / length, v.z);
}

// A unit normal of the relief on square tiles, as it is on stretched tiles.
fn flat_btf_stretched(surface: FlatBtfSurface, normal: vec3<f32>) -> vec3<f32> {
    let s = surface.stretch;
    if all(s == FLAT_BTF_SQUARE) {
        return normal;
    }
    let turned = vec3<f32>(s.x * normal.x + s.z * normal.y, s.y * normal.x + s.w * normal.y, normal.z);
    return turned / sqrt(turned.x * turned.x + turned.y * turned.y + turned.z * turned.z);
}

// A direction in the frame of a normal whose x and y are `tilt`, with z = 1.
fn flat_btf_tilted(v: vec3<f32>, tilt: vec2<f32>) -> vec3<f32> {
    if all(tilt == vec2<f32>(0.0)) {
        return v;
    }
    let turned = vec3<f32>(v.x - v.z * tilt.x, v.y - v.z * tilt.y, v.z + v.x * tilt.x + v.y * tilt.y);
    return turned / sqrt(turned.x * turned.x + turned.y * turned.y + turned.z * turned.z);
}

// Side of a tile, from the changes of position and of coordinates in tiles to the pixels on the right and below: dpdx and
// dpdy in a fragment shader. tangent and bitangent are unit vectors.
fn flat_btf_tile_side(
    right: vec3<f32>, below: vec3<f32>, tiles_right: vec2<f32>, tiles_below: vec2<f32>, tangent: vec3<f32>,
    bitangent: vec3<f32>
) -> f32 {
    let area = dot(right, tangent) * dot(below, bitangent) - dot(right, bitangent) * dot(below, tangent);
    let covered = tiles_right.x * tiles_below.y - tiles_right.y * tiles_below.x;
    return sqrt(abs(area) / max(abs(covered), 1e-20));
}

// Curvature of a surface for FlatBtfSurface, from the changes of position and unit normal likewise, and the side of a
// tile.
fn flat_btf_curvature(
    right: vec3<f32>, below: vec3<f32>, normal_right: vec3<f32>, normal_below: vec3<f32>, tangent: vec3<f32>,
    bitangent: vec3<f32>, side: f32
) -> vec3<f32> {
    let a = vec2<f32>(dot(right, tangent), dot(right, bitangent));
    let b = vec2<f32>(dot(below, tangent), dot(below, bitangent));
    let p = vec2<f32>(dot(normal_right, tangent), dot(normal_right, bitangent));
    let q = vec2<f32>(dot(normal_below, tangent), dot(normal_below, bitangent));
    let determinant = a.x * b.y - a.y * b.x;
    // Relative to the steps: edge-on there is no curvature.
    if abs(determinant) <= 1e-6 * (dot(a, a) + dot(b, b)) {
        return vec3<f32>(0.0);
    }
    let along_u = (p * b.y - q * a.y) / determinant;
    let along_v = (q * a.x - p * b.x) / determinant;
    return vec3<f32>(along_u.x, 0.5 * (along_u.y + along_v.x), along_v.y) * side;
}

// Stretch of tiles for FlatBtfSurface, from the changes of position and of coordinates in tiles likewise, and the side of
// a tile.
fn flat_btf_stretch(
    right: vec3<f32>, below: vec3<f32>, tiles_right: vec2<f32>, tiles_below: vec2<f32>, tangent: vec3<f32>,
    bitangent: vec3<f32>, side: f32
) -> vec4<f32> {
    let a = vec2<f32>(dot(right, tangent), dot(right, bitangent));
    let b = vec2<f32>(dot(below, tangent), dot(below, bitangent));
    let determinant = a.x * b.y - a.y * b.x;
    let covered = tiles_right.x * tiles_below.y - tiles_right.y * tiles_below.x;
    if abs(determinant) <= 1e-6 * (dot(a, a) + dot(b, b)) || abs(covered) <= 1e-20 {
        return FLAT_BTF_SQUARE;
    }
    let along_t = (tiles_right * b.y - tiles_below * a.y) * (side / determinant);
    let along_b = (tiles_below * a.x - tiles_right * b.x) * (side / determinant);
    let most = vec4<f32>(FLAT_BTF_MAX_STRETCH);
    return clamp(vec4<f32>(along_t.x, along_b.x, along_t.y, along_b.y), -most, most);
}
