// Factored flat BTFs on a GPU: shadows of texels and lights, times a sum of components with weights of texels.
//
// The layout of the files is described in `formats/src/flat_btf/factored/spec.md`; the CPU decoder with the same steps in
// the same order is `FactoredFlatBtf` of the crate `brdfc-formats`.
//
// To use it: paste it behind `decoder.wgsl`, whose binding 6 may then be any 2D array, move the five bindings where they
// suit you, and call
//
//     let seen = flat_btf_indirection(uv, view);
//     let value = factored_value(seen.xy, level_of_detail, views, lights);
//
// level_of_detail is that of the flat BTF's texels, 0 the finest; factored_mipmap_level finds it in a fragment shader, where
// control flow is uniform. Values are those of flat_btf_full.
//
// With the sampler this costs a fetch per group of four components and one per light, and 3 ceil((groups + wide groups) / 4)
// loads per pair of a view and a light. Manual filtering fetches 4 or 8 times for one.

const FACTORED_MAX_GROUPS: u32 = 16u;
// Beyond the cube root of every value that a flat BTF stores.
const FACTORED_LARGEST_ROOT: f32 = 41.0;

// The same fields, in the same order, as `FactoredParameters` of `brdfc-formats`. 1312 bytes.
struct FactoredParameters {
    size: u32,          // T: the flat BTF has T x T texels
    levels: u32,        // mipmap levels of weights and shadows
    groups: u32,        // groups of four components
    wide_groups: u32,   // of which so many have 16 bits in the basis, the others 8
    shadowed: u32,      // 0: every texel is lit by every light
    hardware: u32,      // 1: the sampler filters, 0: manual weights
    reserved: vec2<u32>,
    steps: array<vec4<f32>, 48>,    // three opponent colours, 16 groups each
    scales: array<vec4<f32>, 16>,   // of weights
    lows: array<vec4<f32>, 16>,
}

@group(1) @binding(8) var<uniform> factored_parameters: FactoredParameters;
// The file `weights`, a layer per group, with mipmaps.
@group(1) @binding(9) var factored_weights: texture_2d_array<f32>;
// The file `shadow`, a layer per light, with mipmaps; without shadows any 2D array.
@group(1) @binding(10) var factored_shadow: texture_2d_array<f32>;
// The file `basis`.
@group(1) @binding(11) var factored_basis: texture_2d<u32>;
// Linear filter, also between mipmap levels; repeats.
@group(1) @binding(12) var factored_sampler: sampler;

// A point of the flat BTF and the mipmap levels around a level of detail.
struct FactoredPlace {
    uv: vec2<f32>,
    level: u32,
    blend: f32,    // share of the next coarser level
}

// The weights of all components.
var<private> factored_components: array<vec4<f32>, FACTORED_MAX_GROUPS>;

// The level of detail of a pixel, from how uv changes to the pixels on the right and below: dpdx(uv) and dpdy(uv).
fn factored_mipmap_level(right: vec2<f32>, below: vec2<f32>) -> f32 {
    let across = right * f32(factored_parameters.size);
    let down = below * f32(factored_parameters.size);
    return max(0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-20)), 0.0);
}

fn factored_value(uv: vec2<f32>, level_of_detail: f32, views: FlatBtfWeights, lights: FlatBtfWeights) -> vec3<f32> {
    let last = f32(factored_parameters.levels - 1u);
    let detail = min(max(level_of_detail, 0.0), last);
    let place = FactoredPlace(
        vec2<f32>(flat_btf_wrap(uv.x), flat_btf_wrap(uv.y)), u32(floor(detail)), detail - floor(detail));
    for (var group = 0u; group < factored_parameters.groups; group += 1u) {
        let texel = factored_weight_sample(place, group);
        factored_components[group] = factored_parameters.lows[group] + factored_parameters.scales[group] * texel;
    }
    var shadows = vec3<f32>(0.0);
    for (var l = 0u; l < 3u; l += 1u) {
        if lights.weights[l] != 0.0 {
            shadows[l] = factored_lit(place, lights.indices[l]);
        }
    }
    var value = vec3<f32>(0.0);
    for (var v = 0u; v < 3u; v += 1u) {
        if views.weights[v] == 0.0 {
            continue;
        }
        for (var l = 0u; l < 3u; l += 1u) {
            if lights.weights[l] == 0.0 {
                continue;
            }
            let weight = views.weights[v] * lights.weights[l];
            value += weight * (shadows[l] * factored_colour(views.indices[v], lights.indices[l]));
        }
    }
    return value;
}

// What the components show in a view under a light that arrives in full.
fn factored_colour(view: u32, light: u32) -> vec3<f32> {
    var opponent = vec3<f32>(0.0);
    for (var colour = 0u; colour < 3u; colour += 1u) {
        opponent[colour] = factored_sum(view, light, colour);
    }
    return factored_from_opponent(opponent);
}

// One opponent colour: components in order, each its weight times its step times an integer.
fn factored_sum(view: u32, light: u32, colour: u32) -> f32 {
    let wide = 2u * factored_parameters.wide_groups;
    let words = factored_parameters.groups + factored_parameters.wide_groups;
    let first = (light * 3u + colour) * ((words + 3u) / 4u);
    var sum = 0.0;
    var texel = vec4<u32>(0u);
    var even = vec2<f32>(0.0);
    for (var k = 0u; k < words; k += 1u) {
        if (k & 3u) == 0u {
            texel = textureLoad(factored_basis, vec2<u32>(first + k / 4u, view), 0);
        }
        let word = bitcast<i32>(texel[k & 3u]);
        var group = k - factored_parameters.wide_groups;
        var integers = vec4<f32>((vec4<i32>(word) << vec4<u32>(24u, 16u, 8u, 0u)) >> vec4<u32>(24u));
        if k < wide {
            let pair = vec2<f32>((vec2<i32>(word) << vec2<u32>(16u, 0u)) >> vec2<u32>(16u));
            if (k & 1u) == 0u {
                even = pair;
                continue;
            }
            group = k / 2u;
            integers = vec4<f32>(even, pair);
        }
        let scaled = factored_components[group]
            * factored_parameters.steps[colour * FACTORED_MAX_GROUPS + group];
        sum = sum + scaled.x * integers.x;
        sum = sum + scaled.y * integers.y;
        sum = sum + scaled.z * integers.z;
        sum = sum + scaled.w * integers.w;
    }
    return sum;
}

// Linear RGB of lightness and opponent colours.
fn factored_from_opponent(opponent: vec3<f32>) -> vec3<f32> {
    let y = opponent.x * (1.0 / 116.0);
    let x = y + opponent.y * (1.0 / 500.0);
    let z = y - opponent.z * (1.0 / 200.0);
    let root = min(max(vec3<f32>(x, y, z), vec3<f32>(0.0)), vec3<f32>(FACTORED_LARGEST_ROOT));
    let xyz = root * root * root;
    let rgb = vec3<f32>(
        3.0799556 * xyz.x + -1.537188 * xyz.y + -0.5427674 * xyz.z,
        -0.9212588 * xyz.x + 1.8760257 * xyz.y + 0.045232937 * xyz.z,
        0.052887354 * xyz.x + -0.20402668 * xyz.y + 1.1511394 * xyz.z);
    return max(rgb, vec3<f32>(0.0));
}

// How much of a light arrives.
fn factored_lit(place: FactoredPlace, light: u32) -> f32 {
    if factored_parameters.shadowed == 0u {
        return 1.0;
    }
    if factored_parameters.hardware == 1u {
        let detail = f32(place.level) + place.blend;
        return textureSampleLevel(factored_shadow, factored_sampler, place.uv, light, detail).r;
    }
    let fine = factored_shadow_level(place.uv, place.level, light);
    if place.blend > 0.0 {
        return fine + place.blend * (factored_shadow_level(place.uv, place.level + 1u, light) - fine);
    }
    return fine;
}

// Four weights, 0 to 1 each.
fn factored_weight_sample(place: FactoredPlace, group: u32) -> vec4<f32> {
    if factored_parameters.hardware == 1u {
        let detail = f32(place.level) + place.blend;
        return textureSampleLevel(factored_weights, factored_sampler, place.uv, group, detail);
    }
    let fine = factored_weight_level(place.uv, place.level, group);
    if place.blend > 0.0 {
        return fine + place.blend * (factored_weight_level(place.uv, place.level + 1u, group) - fine);
    }
    return fine;
}

fn factored_shadow_level(uv: vec2<f32>, level: u32, light: u32) -> f32 {
    let column = flat_btf_periodic_tap(uv.x, factored_side(level));
    let row = flat_btf_periodic_tap(uv.y, factored_side(level));
    var value = 0.0;
    for (var k = 0u; k < 4u; k += 1u) {
        let at = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        value = value + weight * textureLoad(factored_shadow, at, light, level).r;
    }
    return value;
}

fn factored_weight_level(uv: vec2<f32>, level: u32, group: u32) -> vec4<f32> {
    let column = flat_btf_periodic_tap(uv.x, factored_side(level));
    let row = flat_btf_periodic_tap(uv.y, factored_side(level));
    var value = vec4<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let at = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        value = value + weight * textureLoad(factored_weights, at, group, level);
    }
    return value;
}

// Texels on a side of a mipmap level.
fn factored_side(level: u32) -> u32 {
    return max(factored_parameters.size >> level, 1u);
}
