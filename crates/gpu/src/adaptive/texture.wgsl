// Textures of materials at the points of a G-buffer. Appended to `curvature.wgsl` and `formats/src/bandwidth/map.wgsl`; the
// CPU twins are `crates/render/src/adaptive/texture.rs` and `crates/render/src/mipmaps.rs`.

// A texture at a point: factor on the BRDF, and bandwidth along the surface in cycles per metre.
struct TexturePoint {
    colour: vec3<f32>,
    bandwidth: f32,
}

fn texture_point(point: u32) -> TexturePoint {
    if job.material.texture_levels == 0u {
        return TexturePoint(vec3<f32>(1.0), 0.0);
    }
    // Coordinates go up, and rows of images down.
    let place = uv_of(point) * job.material.repeats * vec2<f32>(1.0, -1.0);
    let footprint = texture_footprint(point);
    return TexturePoint(texture_colour(place, footprint.y), bandwidth_texture(place) * footprint.x);
}

// Metres of the texture per metre of surface, and squared texels to a neighbour in the row or column: maxima over the
// neighbours.
fn texture_footprint(point: u32) -> vec2<f32> {
    let place = place_of(point);
    let last = min(place + vec2<u32>(1u), rendering.points - vec2<u32>(1u));
    let first = max(place, vec2<u32>(1u)) - vec2<u32>(1u);
    let uv = uv_of(point);
    var stretch_squared = -1.0;
    var texels_squared = 0.0;
    for (var row = first.y; row <= last.y; row += 1u) {
        for (var column = first.x; column <= last.x; column += 1u) {
            let neighbour = row * rendering.points.x + column;
            if neighbour == point || part_of(neighbour) != job.material.part {
                continue;
            }
            let length_squared = step_squared(point, neighbour);
            if length_squared < 0.0 {
                continue;
            }
            // Coordinates of closed surfaces jump by whole numbers at their seam.
            let turn = uv_of(neighbour) - uv;
            let repetitions = (turn - floor(turn + 0.5)) * job.material.repeats;
            let across = repetitions * job.material.metres;
            stretch_squared = max(stretch_squared, (across.x * across.x + across.y * across.y) / length_squared);
            if row == place.y || column == place.x {
                let texels = repetitions * vec2<f32>(job.material.texture_size);
                texels_squared = max(texels_squared, texels.x * texels.x + texels.y * texels.y);
            }
        }
    }
    return vec2<f32>(select(sqrt(stretch_squared), 1.0, stretch_squared < 0.0), texels_squared);
}

fn texture_colour(place: vec2<f32>, texels_squared: f32) -> vec3<f32> {
    let level = texture_level(texels_squared);
    var size = job.material.texture_size;
    var row = 0u;
    for (var finer = 0u; finer < u32(level); finer += 1u) {
        row += size.y;
        size = max(size / 2u, vec2<u32>(1u));
    }
    let finer = texture_of_level(place, row, size);
    let share = level - floor(level);
    if share == 0.0 {
        return finer;
    }
    let coarser = texture_of_level(place, row + size.y, max(size / 2u, vec2<u32>(1u)));
    return finer + share * (coarser - finer);
}

// The level of a footprint. The logarithm is linear between powers of two.
fn texture_level(texels_squared: f32) -> f32 {
    if texels_squared <= 1.0 {
        return 0.0;
    }
    let bits = bitcast<u32>(texels_squared);
    let exponent = i32(bits >> 23u) - 127;
    let beyond = bitcast<f32>((bits & 0x7fffffu) | 0x3f800000u) - 1.0;
    return min(0.5 * (f32(exponent) + beyond), f32(job.material.texture_levels - 1u));
}

// Bilinear look-up in the level of this size, whose first row is `row`.
fn texture_of_level(place: vec2<f32>, row: u32, size: vec2<u32>) -> vec3<f32> {
    let at = (place - floor(place)) * vec2<f32>(size) - 0.5;
    let lower = floor(at);
    let first = select(min(vec2<u32>(max(lower, vec2<f32>(0.0))), size - 1u), size - 1u, lower < vec2<f32>(0.0));
    let second = select(first + 1u, vec2<u32>(0u), first + 1u == size);
    let share = at - lower;
    let a = textureLoad(texture_colours, vec2<u32>(first.x, row + first.y), 0).xyz;
    let b = textureLoad(texture_colours, vec2<u32>(second.x, row + first.y), 0).xyz;
    let c = textureLoad(texture_colours, vec2<u32>(first.x, row + second.y), 0).xyz;
    let d = textureLoad(texture_colours, vec2<u32>(second.x, row + second.y), 0).xyz;
    let above = a + share.x * (b - a);
    return above + share.y * ((c + share.x * (d - c)) - above);
}

fn texture_luminance(colour: vec3<f32>) -> f32 {
    return 0.2126 * colour.x + 0.7152 * colour.y + 0.0722 * colour.z;
}
