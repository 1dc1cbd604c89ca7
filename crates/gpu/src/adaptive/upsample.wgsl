// Interpolates a node from the coarser level. The CPU twin is `crates/render/src/adaptive/upsample.rs`, with
// `stands_for` and `upsampled` of `passes.rs`.

// Maximum distance of a parent from the node's tangent plane, in units of the distance between both.
const DEPTH: f32 = 0.25;
// Minimum sum of weights for interpolation.
const LEAST_WEIGHT: f32 = 1e-3;

// The surface at the point that a node stands for.
struct Guide {
    at: vec2<f32>,       // in points
    position: vec3<f32>,
    normal: vec3<f32>,
    cosine: f32,         // of the angle between normal and view
    across: vec2<f32>,   // direction of the normal in the image
    part: u32,
}

// The point that a node of a level stands for: the point in the middle of its square, or else the first on a surface.
fn stands_for(level: u32, index: u32) -> u32 {
    let own = rendering.levels[level];
    if level > 0u {
        let corner = vec2<u32>(index % own.x, index / own.x) << vec2<u32>(level);
        let middle = corner + vec2<u32>(1u << (level - 1u));
        if all(middle < rendering.points) {
            let point = middle.y * rendering.points.x + middle.x;
            if part_of(point) != NONE {
                return point;
            }
        }
    }
    return nodes[own.z + index].first;
}

// The weighted mean of the values around a node at the coarser level, and 1; 0 if no value fits.
fn upsampled(point: u32, index: u32, level: u32) -> vec4<f32> {
    let own = rendering.levels[level];
    let coarser = rendering.levels[level + 1u];
    let place = vec2<u32>(index % own.x, index / own.x);
    let spacing = f32(1u << (level + 1u));
    let here = guide_of(point);
    var sum = vec3<f32>(0.0);
    var total = 0.0;
    for (var k = 0u; k < 4u; k += 1u) {
        // The node's own parent, its neighbour in the row, in the column, in both.
        let column = parent(place.x, coarser.x, k & 1u);
        let row = parent(place.y, coarser.y, k >> 1u);
        if column == NONE || row == NONE {
            continue;
        }
        let node = row * coarser.x + column;
        let value = computed[coarser.z + node];
        if value.w == 0.0 {
            continue;
        }
        let w = weight(here, guide_of(stands_for(level + 1u, node)), spacing);
        sum += w * value.xyz;
        total += w;
    }
    if total > LEAST_WEIGHT {
        return vec4<f32>(sum / total, 1.0);
    }
    return vec4<f32>(0.0);
}

// Parent of a node along one axis, or the next one on the node's side of it; NONE outside the level.
fn parent(at: u32, size: u32, other: u32) -> u32 {
    let own = at / 2u;
    if other == 0u {
        return own;
    }
    if at % 2u == 0u {
        return select(own - 1u, NONE, own == 0u);
    }
    return select(NONE, own + 1u, own + 1u < size);
}

fn guide_of(point: u32) -> Guide {
    let place = place_of(point);
    let position = textureLoad(positions, place, 0);
    let normal = textureLoad(normals, place, 0).xyz;
    let cosine = clamp(product(normal, viewer_of(position.xyz).xyz), 0.0, 1.0);
    return Guide(vec2<f32>(place), position.xyz, normal, cosine, across_of(normal), u32(position.w) - 1u);
}

// The bilinear weight of the parent's point, times its similarity in depth and along the image; 0 for another part.
fn weight(here: Guide, there: Guide, spacing: f32) -> f32 {
    if here.part != there.part {
        return 0.0;
    }
    let step = there.position - here.position;
    let length_squared = product(step, step);
    let off = product(step, here.normal);
    var depth = 0.0;
    if length_squared > 0.0 {
        depth = off * off / (DEPTH * DEPTH * length_squared);
    }
    let v = (there.at - here.at) / spacing;
    let alpha = max(1.0 - abs(v.x), 0.0) * max(1.0 - abs(v.y), 0.0);
    let along = v.x * here.across.x + v.y * here.across.y;
    let sideways = v.y * here.across.x - v.x * here.across.y;
    return alpha * exp(-(depth + along * along + here.cosine * sideways * sideways));
}
