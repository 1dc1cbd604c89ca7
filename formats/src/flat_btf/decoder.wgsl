// Flat BTFs: rays of sight and of light through the layers of a relief.
//
// After Hadim, Pacanowski, Granier and Schlick 2009, "Flat bidirectional texture functions", with a march in place of
// sampled indirections and shadows. File layout: `formats/src/flat_btf/spec.md`. The CPU decoder `FlatBtfDecoder` of
// the crate `brdfc-formats` performs the same steps in the same order.
//
// Usage: `value.wgsl` uses these functions. For the relief alone, prepend this file to your own shader, move the
// bindings as needed, and call
//
//     let surface = FlatBtfSurface(vec3<f32>(0.0), 0.0, FLAT_BTF_SQUARE); // a plane; for others see flat_btf_curvature
//     let point = flat_btf_seen(uv, view, surface, detail);       // the visible point of the relief
//     let parameters = flat_btf_parameters_at(point, detail);     // its parameters in the flat BTF
//     let reached = flat_btf_lit(point, normal, light, surface, detail); // 1 if the light reaches it, otherwise 0
//
// uv is in tiles and unbounded. view (to the viewer) and light (to the light) are unit vectors in the frame x =
// tangent, y = bitangent, z = normal. detail is the mipmap level of the layers, 0 the finest.
//
// With the sampler a ray of sight takes its steps + 1 + refine_steps fetches, a ray of light its steps + 1. Rays take fewer
// steps where they cross fewer texels. Manual filtering takes 4 or 8 fetches instead of one.

// Same fields and order as `FlatBtfParameters` of `brdfc-formats`. 64 bytes.
struct FlatBtfParameters {
    size: u32,          // M: the reference plane has M x M texels
    sheets: u32,        // of layers, 1: the base; 3: base, top, underside; 0: an indirection map, see vdim.wgsl
    levels: u32,        // mipmap levels of the layers, or levels of the map
    sight_steps: u32,   // maximum steps of a ray of sight: an application may change the three numbers of steps
    refine_steps: u32,
    both_steps: u32,    // maximum steps of a ray of sight and a ray of light together
    low: f32,           // lowest height of the texture, in tiles
    range: f32,         // highest less lowest height
    finer: f32,         // octaves by which texels of the plane are smaller than texels of the flat BTF
    polar_angles: u32,  // Z and R of an indirection map, 0 with layers
    azimuth_rows: u32,
    largest_angle: f32, // polar angle, radians
    lights: u32,        // lights with sampled shadows
    block: u32,         // texels per side of a block of compact samples; 0 for others
    largest_tangent: f32, // of the polar angle, for compact samples
    reserved: u32,
}

@group(1) @binding(15) var<uniform> flat_btf_parameters: FlatBtfParameters;
// Heights of the sheets, 0 to 1: base, top, underside. With mipmaps. Or heights for compact samples, over the parameters.
@group(1) @binding(16) var flat_btf_heights: texture_2d<f32>;
// A layer per sheet: parameters less the position of the texel, in tiles. With mipmaps; level k has as many texels as
// level k + 1 of the heights. Or bounds of compact samples: minima in layer 0, extents in layer 1.
@group(1) @binding(17) var flat_btf_displacements: texture_2d_array<f32>;
// Linear filter within and between mipmap levels; repeat.
@group(1) @binding(18) var flat_btf_sampler: sampler;

const FLAT_BTF_TEXELS_PER_STEP: f32 = 1.5;
// Least cosine of the polar angle of a ray: flatter rays are raised.
const FLAT_BTF_MIN_COSINE: f32 = 0.0625;
// Least number of steps of a ray that leaves a convex surface again, if the maximum allows.
const FLAT_BTF_MIN_PASSING_STEPS: f32 = 4.0;
// Least ratio of areas at two heights: a relief as high as the radius of a surface is not drawn right.
const FLAT_BTF_MIN_AREA_RATIO: f32 = 0.0625;
// Distance from the surface at which rays of light start, in texels.
const FLAT_BTF_RISE: f32 = 0.1;

// Stretch of square tiles along the tangent.
const FLAT_BTF_SQUARE: vec4<f32> = vec4<f32>(1.0, 0.0, 0.0, 1.0);

// The surface that a relief covers, around a point that is drawn.
struct FlatBtfSurface {
    curvature: vec3<f32>, // along tangent and bitangent, per tile: uu, uv, vv; positive where convex
    height: f32,          // height of the point above the reference plane, in tiles
    stretch: vec4<f32>,   // change of u and v, in tiles, over one side of a tile along tangent and bitangent: ut, ub, vt, vb
}

// A point of the relief at the end of a ray of sight.
struct FlatBtfPoint {
    at: vec2<f32>,   // position over the reference plane in tiles, not wrapped
    height: f32,     // 0 to 1; below 0 if the ray passes the relief of a convex surface and leaves it again
    sheet: u32,      // 0 base, 1 top, 2 underside
    rise: f32,       // height above the point that is drawn, in its frame and in tiles
    steps: u32,      // steps that the ray took
}

// A ray over a surface, from t = 0 to `last`. Over a plane it is straight.
struct FlatBtfRay {
    start: vec2<f32>,
    across: vec2<f32>, // tiles that it crosses per unit of t at its start
    turn: vec2<f32>,   // half the change of that with t: tiles are longer, the higher above a convex surface
    height: f32,       // height at the start, 0 to 1
    climb: f32,        // change of the height with t
    bend: f32,         // half the change of that
    last: f32,
    passes: u32,       // 1: it leaves a convex surface again without having reached the lowest point
    back: f32,         // height of the start above the point that is drawn, in its frame and in tiles
}

// Position on a segment at which a ray enters the solid, 0 to 1; above 1 if it does not.
struct FlatBtfCrossing {
    share: f32,
    sheet: u32,
}

// Two neighbouring samples along one axis.
struct FlatBtfTap {
    lower: u32,
    upper: u32,
    weight: f32,   // of the upper sample
}

// The point of the relief that a distant eye sees behind the point uv of a surface.
fn flat_btf_seen(uv: vec2<f32>, view: vec3<f32>, surface: FlatBtfSurface, detail: f32) -> FlatBtfPoint {
    let ray = flat_btf_ray_of_sight(uv, flat_btf_slope(view), surface);
    let count = flat_btf_steps(ray, detail, flat_btf_parameters.sight_steps);
    var a = 0.0;
    var above = flat_btf_column(ray.start, detail);
    var b = ray.last;
    var below = above;
    var met = FlatBtfCrossing(2.0, 0u);
    var taken = count;
    for (var k = 1u; k <= count; k += 1u) {
        b = ray.last * (f32(k) / f32(count));
        below = flat_btf_column(flat_btf_at(ray, b), detail);
        met = flat_btf_crossing(flat_btf_height(ray, a), flat_btf_height(ray, b), above, below);
        if met.share <= 1.0 {
            taken = k;
            break;
        }
        if k < count {
            a = b;
            above = below;
        }
    }
    if met.share > 1.0 {
        if ray.passes == 1u {
            return FlatBtfPoint(flat_btf_at(ray, ray.last), -1.0, 0u, 0.0, taken);
        }
        // Rounding at the lowest height.
        met = FlatBtfCrossing(1.0, 0u);
    }
    for (var k = 0u; k < flat_btf_parameters.refine_steps; k += 1u) {
        let middle = a + (b - a) * met.share;
        let column = flat_btf_column(flat_btf_at(ray, middle), detail);
        let between = flat_btf_height(ray, middle);
        let first = flat_btf_crossing(flat_btf_height(ray, a), between, above, column);
        if first.share <= 1.0 {
            b = middle;
            below = column;
            met = first;
        } else {
            let second = flat_btf_crossing(between, flat_btf_height(ray, b), column, below);
            met.share = 0.0;
            if second.share <= 1.0 {
                met = second;
            }
            a = middle;
            above = column;
        }
    }
    let share = a + (b - a) * met.share;
    let rise = ray.back - share * flat_btf_parameters.range;
    return FlatBtfPoint(flat_btf_at(ray, share), flat_btf_height(ray, share), met.sheet, rise, taken);
}

// Fraction, 0 or 1, of the light of a distant source that reaches a point of the relief with a unit normal.
fn flat_btf_lit(
    point: FlatBtfPoint, normal: vec3<f32>, light: vec3<f32>, surface: FlatBtfSurface, detail: f32
) -> f32 {
    let rise = FLAT_BTF_RISE / f32(flat_btf_side(u32(floor(flat_btf_level(detail)))));
    let start = point.at + rise * flat_btf_tiles(surface, normal.xy);
    var column = flat_btf_column(start, detail);
    var height = point.height + rise * normal.z / flat_btf_parameters.range;
    // Steps may have left the point a little inside the solid.
    let above = rise / flat_btf_parameters.range;
    if point.sheet == 2u {
        height = min(height, column.z - above);
    } else {
        height = max(height, select(column.x, column.y, point.sheet == 1u) + above);
    }
    if height >= 1.0 {
        return 1.0;
    }
    let ray = flat_btf_ray_of_light(start, height, flat_btf_slope(light), surface);
    let both = flat_btf_parameters.both_steps;
    let count = flat_btf_steps(ray, detail, both - min(point.steps, both));
    var z = height;
    for (var k = 1u; k <= count; k += 1u) {
        let share = ray.last * (f32(k) / f32(count));
        let next = flat_btf_column(flat_btf_at(ray, share), detail);
        let end = flat_btf_height(ray, share);
        if flat_btf_crossing(z, end, column, next).share <= 1.0 {
            return 0.0;
        }
        z = end;
        column = next;
    }
    return 1.0;
}

// The ray of sight from the highest point of the relief down, or over a concave surface from its own highest point.
fn flat_btf_ray_of_sight(uv: vec2<f32>, slope: vec2<f32>, surface: FlatBtfSurface) -> FlatBtfRay {
    let range = flat_btf_parameters.range;
    let curvature = flat_btf_curvature_at(surface.curvature, surface.height);
    let turned = flat_btf_product(curvature, slope);
    let bend = slope.x * turned.x + slope.y * turned.y;
    let along = slope - surface.height * turned;
    let turn = flat_btf_product(curvature, along);
    // Back up.
    let highest = flat_btf_parameters.low + range - surface.height;
    var high = highest;
    if bend < 0.0 {
        high = min(highest, -0.5 / bend);
    }
    let squared = max(1.0 + 2.0 * bend * high, 0.0);
    let fall = sqrt(squared);
    let back = 2.0 * high / (1.0 + fall);
    let height = 1.0 - (highest - high) / range;
    let half_bend = 0.5 * bend * range;
    let discriminant = squared - 4.0 * half_bend * height;
    // Where it reaches the lowest height, or else the height of its start again.
    var last = 0.0;
    var passes = 0u;
    if discriminant < 0.0 {
        last = fall / half_bend;
        passes = 1u;
    } else {
        last = 2.0 * height / (fall + sqrt(discriminant));
    }
    let start = uv + back * flat_btf_tiles(surface, along - back * turn);
    let across = range * flat_btf_tiles(surface, 2.0 * back * turn - along);
    let bent = -(range * range * flat_btf_tiles(surface, turn));
    return FlatBtfRay(start, across, bent, height, -fall, half_bend, last, passes, back);
}

// The ray of light from a point up to the highest point of the relief, or over a concave surface to its own.
fn flat_btf_ray_of_light(start: vec2<f32>, height: f32, slope: vec2<f32>, surface: FlatBtfSurface) -> FlatBtfRay {
    let range = flat_btf_parameters.range;
    let above = flat_btf_parameters.low + height * range;
    let curvature = flat_btf_curvature_at(surface.curvature, above);
    let turned = flat_btf_product(curvature, slope);
    let along = slope - above * turned;
    let turn = flat_btf_product(curvature, along);
    let up = (1.0 - height) * range;
    let bend = 0.5 * (slope.x * turned.x + slope.y * turned.y) * up;
    let discriminant = 1.0 + 4.0 * bend;
    var last = 0.0;
    if discriminant < 0.0 {
        last = -0.5 / bend;
    } else {
        last = 2.0 / (1.0 + sqrt(discriminant));
    }
    let across = up * flat_btf_tiles(surface, along);
    let bent = -(up * up * flat_btf_tiles(surface, turn));
    return FlatBtfRay(start, across, bent, height, 1.0 - height, bend * (1.0 - height), last, 0u, 0.0);
}

// Curvature of the parallel surface at a height, in tiles.
fn flat_btf_curvature_at(c: vec3<f32>, height: f32) -> vec3<f32> {
    let along = 1.0 + height * c.x;
    let across = 1.0 + height * c.z;
    let determinant = max(along * across - height * c.y * (height * c.y), FLAT_BTF_MIN_AREA_RATIO);
    return vec3<f32>(
        (c.x * across - height * c.y * c.y) / determinant, c.y / determinant,
        (c.z * along - height * c.y * c.y) / determinant);
}

// Change of u and v, in tiles, over a distance along tangent and bitangent in sides of a tile.
fn flat_btf_tiles(surface: FlatBtfSurface, along: vec2<f32>) -> vec2<f32> {
    let s = surface.stretch;
    return vec2<f32>(s.x * along.x + s.y * along.y, s.z * along.x + s.w * along.y);
}

// Product of a symmetric matrix, uu, uv, vv, and a vector.
fn flat_btf_product(c: vec3<f32>, v: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(c.x * v.x + c.y * v.y, c.y * v.x + c.z * v.y);
}

// Position of a ray.
fn flat_btf_at(ray: FlatBtfRay, t: f32) -> vec2<f32> {
    return ray.start + t * ray.across + t * t * ray.turn;
}

// Height of a ray.
fn flat_btf_height(ray: FlatBtfRay, t: f32) -> f32 {
    return ray.height + t * ray.climb + t * t * ray.bend;
}

// Tangent of the polar angle of a ray, along tangent and bitangent.
fn flat_btf_slope(direction: vec3<f32>) -> vec2<f32> {
    return direction.xy / max(direction.z, FLAT_BTF_MIN_COSINE);
}

// Parameters of a point of the surface, in [0, 1).
fn flat_btf_parameters_at(point: FlatBtfPoint, detail: f32) -> vec2<f32> {
    let moved = flat_btf_displacement(point.at, point.sheet, detail);
    return vec2<f32>(flat_btf_wrap(point.at.x + moved.x), flat_btf_wrap(point.at.y + moved.y));
}

// Number of steps of a ray.
fn flat_btf_steps(ray: FlatBtfRay, detail: f32, most: u32) -> u32 {
    let across = ray.last * ray.across;
    let side = f32(flat_btf_side(u32(floor(flat_btf_level(detail)))));
    let texels = sqrt(across.x * across.x + across.y * across.y) * side;
    // A ray that starts and ends at the same height needs some in between.
    let least = select(1.0, FLAT_BTF_MIN_PASSING_STEPS, ray.passes == 1u);
    return u32(min(max(ceil(texels / FLAT_BTF_TEXELS_PER_STEP), least), f32(max(most, 1u))));
}

// First share of a segment of a ray, from height z to height w, inside the solid. Heights of columns are linear in
// between.
fn flat_btf_crossing(z: f32, w: f32, start: vec3<f32>, end: vec3<f32>) -> FlatBtfCrossing {
    var found = FlatBtfCrossing(flat_btf_above_zero(start.x - z, end.x - w).x, 0u);
    if flat_btf_parameters.sheets > 1u {
        let below_top = flat_btf_above_zero(start.y - z, end.y - w);
        let above_underside = flat_btf_above_zero(z - start.z, w - end.z);
        let first = max(below_top.x, above_underside.x);
        if first <= min(below_top.y, above_underside.y) && first < found.share {
            found = FlatBtfCrossing(first, select(2u, 1u, below_top.x >= above_underside.x));
        }
    }
    return found;
}

// First and last share of a segment at which a linear function is at least 0: 2 and -1 if nowhere.
fn flat_btf_above_zero(start: f32, end: f32) -> vec2<f32> {
    let zero = start / (start - end);
    let first = select(select(2.0, zero, end >= 0.0), 0.0, start >= 0.0);
    let last = select(select(-1.0, zero, start >= 0.0), 1.0, end >= 0.0);
    return vec2<f32>(first, last);
}

// Filtered heights of a column: base, top, underside.
fn flat_btf_column(at: vec2<f32>, detail: f32) -> vec3<f32> {
    let level = flat_btf_level(detail);
    if brdfc_frame.sampler_filters == 1u {
        return textureSampleLevel(flat_btf_heights, flat_btf_sampler, at, level).xyz;
    }
    let finer = floor(level);
    let fine = flat_btf_column_of_level(at, u32(finer));
    let blend = level - finer;
    if blend > 0.0 {
        return fine + blend * (flat_btf_column_of_level(at, u32(finer) + 1u) - fine);
    }
    return fine;
}

// Filtered displacement of a sheet.
fn flat_btf_displacement(at: vec2<f32>, sheet: u32, detail: f32) -> vec2<f32> {
    let level = min(max(detail - 1.0, 0.0), f32(max(flat_btf_parameters.levels, 2u) - 2u));
    if brdfc_frame.sampler_filters == 1u {
        return textureSampleLevel(flat_btf_displacements, flat_btf_sampler, at, sheet, level).xy;
    }
    let finer = floor(level);
    let fine = flat_btf_displacement_of_level(at, sheet, u32(finer));
    let blend = level - finer;
    if blend > 0.0 {
        return fine + blend * (flat_btf_displacement_of_level(at, sheet, u32(finer) + 1u) - fine);
    }
    return fine;
}

fn flat_btf_column_of_level(at: vec2<f32>, level: u32) -> vec3<f32> {
    let column = flat_btf_periodic_tap(flat_btf_wrap(at.x), flat_btf_side(level));
    let row = flat_btf_periodic_tap(flat_btf_wrap(at.y), flat_btf_side(level));
    var heights = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let texel = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        heights = heights + weight * textureLoad(flat_btf_heights, texel, level).xyz;
    }
    return heights;
}

fn flat_btf_displacement_of_level(at: vec2<f32>, sheet: u32, level: u32) -> vec2<f32> {
    let column = flat_btf_periodic_tap(flat_btf_wrap(at.x), flat_btf_side(level + 1u));
    let row = flat_btf_periodic_tap(flat_btf_wrap(at.y), flat_btf_side(level + 1u));
    var moved = vec2<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let texel = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        moved = moved + weight * textureLoad(flat_btf_displacements, texel, sheet, level).xy;
    }
    return moved;
}

// Level of detail within the mipmap levels of the layers.
fn flat_btf_level(detail: f32) -> f32 {
    return min(max(detail, 0.0), f32(flat_btf_parameters.levels - 1u));
}

// Texels per side of a mipmap level of the layers.
fn flat_btf_side(level: u32) -> u32 {
    return max(flat_btf_parameters.size >> level, 1u);
}

// Raises a light to the height of the lowest sampled light if it is lower, with the same azimuth.
fn flat_btf_raised(light: vec3<f32>, lowest: f32) -> vec3<f32> {
    let length = sqrt(light.x * light.x + light.y * light.y);
    if light.z >= lowest || length <= 0.0 {
        return light;
    }
    let scale = sqrt(1.0 - lowest * lowest) / length;
    return vec3<f32>(light.x * scale, light.y * scale, lowest);
}

// Fractional part, in [0, 1). A tiny negative number has a fraction that rounds to 1.
fn flat_btf_wrap(x: f32) -> f32 {
    let fraction = x - floor(x);
    return select(0.0, fraction, fraction < 1.0);
}

// Texels around a parameter with period 1; texel centres are at (i + 1/2) / size.
fn flat_btf_periodic_tap(parameter: f32, size: u32) -> FlatBtfTap {
    let position = parameter * f32(size) - 0.5;
    let below = floor(position);
    let lower = select(min(u32(below), size - 1u), size - 1u, below < 0.0);
    let upper = select(lower + 1u, 0u, lower + 1u == size);
    return FlatBtfTap(lower, upper, position - below);
}

fn flat_btf_tap_sample(tap: FlatBtfTap, upper: u32) -> u32 {
    return select(tap.lower, tap.upper, upper == 1u);
}

fn flat_btf_tap_weight(tap: FlatBtfTap, upper: u32) -> f32 {
    return select(1.0 - tap.weight, tap.weight, upper == 1u);
}
