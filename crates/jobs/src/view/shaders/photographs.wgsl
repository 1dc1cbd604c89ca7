// Draws the photographs that are nearest to the lights of a page: sRGB levels with mipmaps, each times the brightness of its light.

@group(1) @binding(0) var photograph_0: texture_2d<f32>;
@group(1) @binding(1) var photograph_1: texture_2d<f32>;
@group(1) @binding(2) var photograph_2: texture_2d<f32>;

// Number of lights that were added, which is the number of the next photograph.
var<private> photographs_added: u32 = 0u;

// v points down in the image, and along the bitangent on the surface.
fn placed(uv: vec2<f32>, front: bool) -> vec2<f32> {
    return vec2<f32>(uv.x, select(uv.y, 1.0 - uv.y, front));
}

// The level of a whole pixel, for any number of samples.
fn level_at(distance: f32, right: vec2<f32>, below: vec2<f32>) -> f32 {
    let size = vec2<f32>(textureDimensions(photograph_0)) * exp2(view.octaves);
    let across = right * size;
    let down = below * size;
    return max(0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-20)), 0.0);
}

fn looked(in: Varying, front: bool, frame: mat3x3<f32>, uv: vec2<f32>, level: f32, wo: vec3<f32>) -> Look {
    return Look(in.position, false, false);
}

fn reflected(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    let number = photographs_added;
    photographs_added += 1u;
    let size = textureDimensions(photograph_0);
    let coarsest = floor(log2(f32(max(size.x, size.y)) + 0.5));
    let within = min(level, coarsest);
    let finer = floor(within);
    let fine = photograph_bilinear(number, uv, i32(finer));
    let coarse = photograph_bilinear(number, uv, i32(min(finer + 1.0, coarsest)));
    return mix(fine, coarse, within - finer) / PI;
}

fn photograph_bilinear(number: u32, uv: vec2<f32>, level: i32) -> vec3<f32> {
    let size = max(vec2<i32>(textureDimensions(photograph_0)) >> vec2<u32>(u32(level)), vec2<i32>(1));
    let at = clamp(uv, vec2<f32>(0.0), vec2<f32>(1.0)) * vec2<f32>(size) - 0.5;
    let first = vec2<i32>(floor(at));
    let share = at - floor(at);
    let low = max(first, vec2<i32>(0));
    let high = min(first + 1, size - 1);
    let above = mix(
        photograph_texel(number, low, level), photograph_texel(number, vec2<i32>(high.x, low.y), level), share.x);
    let below = mix(
        photograph_texel(number, vec2<i32>(low.x, high.y), level), photograph_texel(number, high, level), share.x);
    return mix(above, below, share.y);
}

// Linear RGB of a texel.
fn photograph_texel(number: u32, at: vec2<i32>, level: i32) -> vec3<f32> {
    var c = vec3<f32>(0.0);
    if number == 0u {
        c = textureLoad(photograph_0, at, level).rgb;
    } else if number == 1u {
        c = textureLoad(photograph_1, at, level).rgb;
    } else {
        c = textureLoad(photograph_2, at, level).rgb;
    }
    return select(pow((c + 0.055) / 1.055, vec3<f32>(2.4)), c / 12.92, c <= vec3<f32>(0.04045));
}
