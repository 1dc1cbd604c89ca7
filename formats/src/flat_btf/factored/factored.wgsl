// Factored flat BTFs: a base of texels and a sum of components weighted per texel, and a coarse residual of shadows.
//
// File layout: `formats/src/flat_btf/factored/spec.md`. The CPU decoder `FactoredFlatBtf` of the crate `brdfc-formats`
// performs the same steps in the same order.
//
// Usage: append this file to `decoder.wgsl`, move the bindings as needed, and call
//
//     let place = factored_place(parameters, level_of_detail);
//     let base = factored_load(place);
//     let value = factored_shadowed(factored_value(base, view, light, views, lights), place, base, lights, lit);
//
// view and light are unit vectors; views and lights are the sampled directions that approximate them. lit is the share of
// the light that reaches the place, which rays determine. level_of_detail refers to the flat BTF's texels, 0 the finest;
// factored_mipmap_level computes it in a fragment shader, in uniform control flow. Without components,
// factored_base_colour is the value.
//
// With the sampler this takes a fetch per group of four components, two for the base, one per table, one for each blended
// light of a residual, and 3 ceil((groups + wide groups) / 4) loads per pair of a view and a light. Manual filtering takes
// 4 or 8 fetches instead of one.

const FACTORED_MAX_GROUPS: u32 = 16u;
// Layers of weights before those of the groups.
const FACTORED_BASE_LAYERS: u32 = 2u;
// Half angles and difference angles of the base's table.
const FACTORED_HALF_ANGLES: u32 = 48u;
const FACTORED_DIFFERENCE_ANGLES: u32 = 8u;
// Least distance of a look-up in the tables from their edge, in texels: a hair inside the centre of the first texel.
const FACTORED_TABLE_EDGE: f32 = 0.501953125;
const FACTORED_LARGEST_BASE: f32 = 65536.0;
const FACTORED_LARGEST_ALBEDO: f32 = 1024.0;
const FACTORED_LEAST_COSINES: f32 = 0.1;
// Above the cube root of any value that a flat BTF stores.
const FACTORED_LARGEST_ROOT: f32 = 41.0;

// Same fields and order as `FactoredParameters` of `brdfc-formats`. 1424 bytes.
struct FactoredParameters {
    size: u32,          // T: the flat BTF has T x T texels
    levels: u32,        // mipmap levels of the weights
    groups: u32,        // groups of four components; 0: the base alone is the value
    wide_groups: u32,   // number of groups with 16 bits in the basis, the others have 8
    residual: u32,      // R: the residual of shadows has R x R cells; 0: there is none
    chroma: u32,        // four signed bytes: minimum and maximum ratios of both opponent colours to lightness, times 48
    lowest_light: f32,  // cosine of the largest polar angle of a sampled light
    materials: u32,     // 0: texels have albedos, and share one table; 1 or 2: texels have a tint
    axes: u32,          // bit k: table k is over mirror angles, otherwise over half angles
    table_levels: u32,  // mipmap levels with tables of their own
    residual_octaves: f32,  // between texels and cells of the residual
    residual_levels: u32,   // mipmap levels of the residual
    albedos: array<vec4<f32>, 2>,   // diffuse albedos of the materials
    steps: array<vec4<f32>, 48>,    // three opponent colours, 16 groups each
    scales: array<vec4<f32>, 18>,   // of weights, the base's first
    lows: array<vec4<f32>, 18>,
}

// Tables of the base: difference angles, half angles of the materials, levels. Red, green and blue are T, alpha is A.
@group(1) @binding(22) var factored_tables: texture_3d<f32>;
@group(1) @binding(23) var<uniform> factored_parameters: FactoredParameters;
// The image `weights`: two layers of the base and a layer per group, with mipmaps.
@group(1) @binding(24) var factored_weights: texture_2d_array<f32>;
// The image `residual`: a layer per light, with mipmaps down to one cell; any 2D array without a residual.
@group(1) @binding(25) var factored_residual: texture_2d_array<f32>;
// The image `basis`; one texel without components.
@group(1) @binding(26) var factored_basis: texture_2d<u32>;
// Linear filter within and between mipmap levels; repeat.
@group(1) @binding(27) var factored_sampler: sampler;

// Three sampled directions and their weights; directions with weight 0 are not fetched.
struct FactoredWeights {
    indices: vec3<u32>,
    weights: vec3<f32>,
}

// A point of the flat BTF and the mipmap levels around a level of detail.
struct FactoredPlace {
    uv: vec2<f32>,
    level: u32,
    blend: f32,    // weight of the next coarser level
}

// Values of the base at a place: a diffuse and a glossy reflection under a normal.
struct FactoredBase {
    diffuse: vec3<f32>,
    gloss: f32,
    normal: vec3<f32>,
    level: u32,    // of the tables, and the share of the next
    blend: f32,
}

// Weights of all components.
var<private> factored_components: array<vec4<f32>, FACTORED_MAX_GROUPS>;

// Level of detail of a pixel from the differences of uv to the pixels on the right and below, dpdx(uv) and dpdy(uv):
// half the mean, in octaves, of both sides of its footprint. The longer side alone would blur across it, over texels
// that are hidden neighbours in a flat BTF; half of it keeps the shadows of the relief. With n x n samples per pixel
// subtract log2(n).
fn factored_mipmap_level(right: vec2<f32>, below: vec2<f32>) -> f32 {
    let across = right * f32(factored_parameters.size);
    let down = below * f32(factored_parameters.size);
    return 0.25 * log2(max(dot(across, across) * dot(down, down), 1e-20)) - 1.0;
}

// The texels around a point of the flat BTF.
fn factored_place(uv: vec2<f32>, level_of_detail: f32) -> FactoredPlace {
    let last = f32(factored_parameters.levels - 1u);
    let detail = min(max(level_of_detail, 0.0), last);
    return FactoredPlace(
        vec2<f32>(flat_btf_wrap(uv.x), flat_btf_wrap(uv.y)), u32(floor(detail)), detail - floor(detail));
}

// Loads the weights of all components, and the base.
fn factored_load(place: FactoredPlace) -> FactoredBase {
    for (var group = 0u; group < factored_parameters.groups; group += 1u) {
        factored_components[group] = factored_numbers(place, FACTORED_BASE_LAYERS + group);
    }
    return factored_base(place);
}

// Value in a view under a light before shadows, after factored_load of the place of the base.
fn factored_value(
    base: FactoredBase, view: vec3<f32>, light: vec3<f32>, views: FactoredWeights, lights: FactoredWeights
) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var v = 0u; v < 3u; v += 1u) {
        if views.weights[v] == 0.0 {
            continue;
        }
        for (var l = 0u; l < 3u; l += 1u) {
            if lights.weights[l] == 0.0 {
                continue;
            }
            let weight = views.weights[v] * lights.weights[l];
            sum += weight * factored_pair(views.indices[v], lights.indices[l]);
        }
    }
    let colour = factored_base_colour(base, view, flat_btf_raised(light, factored_parameters.lowest_light));
    return factored_from_opponent(factored_bounded(factored_to_opponent(colour) + sum));
}

// A value if lit of a light, 0 to 1, reaches the place: that share of it without a residual.
fn factored_shadowed(
    value: vec3<f32>, place: FactoredPlace, base: FactoredBase, lights: FactoredWeights, lit: f32
) -> vec3<f32> {
    if factored_parameters.residual == 0u {
        return value * lit;
    }
    let last = f32(factored_parameters.residual_levels - 1u);
    let detail = min(max(f32(place.level) + place.blend - factored_parameters.residual_octaves, 0.0), last);
    var roots = vec2<f32>(0.0);
    for (var l = 0u; l < 3u; l += 1u) {
        if lights.weights[l] != 0.0 {
            roots += lights.weights[l] * factored_residual_sample(place.uv, detail, lights.indices[l]);
        }
    }
    let scaled = roots * (255.0 / 180.0);
    let shares = scaled * scaled;
    return value * (lit * shares.x) + base.diffuse * ((1.0 - lit) * shares.y);
}

// Decodes the two layers of the base.
fn factored_base(place: FactoredPlace) -> FactoredBase {
    let albedo = min(max(factored_numbers(place, 0u), vec4<f32>(0.0)), vec4<f32>(FACTORED_LARGEST_ALBEDO));
    let slopes = factored_numbers(place, 1u);
    let slope = min(max(slopes.xz + slopes.yw, vec2<f32>(-1024.0)), vec2<f32>(1024.0));
    let scale = 2.0 / (1.0 + slope.x * slope.x + slope.y * slope.y);
    let last = factored_parameters.table_levels - 1u;
    let level = min(place.level, last);
    let blend = select(place.blend, 0.0, level == last);
    return FactoredBase(albedo.xyz, albedo.w, vec3<f32>(slope.x * scale, slope.y * scale, scale - 1.0), level, blend);
}

fn factored_dot(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Colour of the base in a view under an unshadowed light: linear RGB.
fn factored_base_colour(base: FactoredBase, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let cosine = min(factored_dot(base.normal, light), 1.0);
    if cosine <= 0.0 {
        return vec3<f32>(0.0);
    }
    let outgoing = min(max(factored_dot(base.normal, view), 0.0), 1.0);
    let geometry = cosine / max(cosine + outgoing, FACTORED_LEAST_COSINES);
    let first = factored_gloss(0u, base, cosine, view, light);
    if factored_parameters.materials == 0u {
        let gloss = base.gloss * geometry;
        return min(base.diffuse * cosine + gloss * first.xyz, vec3<f32>(FACTORED_LARGEST_BASE));
    }
    var value = factored_parameters.albedos[0].xyz * (first.w * cosine) + geometry * first.xyz;
    if factored_parameters.materials > 1u {
        let gloss = factored_gloss(1u, base, cosine, view, light);
        let second = factored_parameters.albedos[1].xyz * (gloss.w * cosine) + geometry * gloss.xyz;
        value = (1.0 - base.gloss) * value + base.gloss * second;
    }
    return min(max(base.diffuse * value, vec3<f32>(0.0)), vec3<f32>(FACTORED_LARGEST_BASE));
}

// Interpolates a table: T, and the factor A of the diffuse reflection of a material.
fn factored_gloss(table: u32, base: FactoredBase, cosine: f32, view: vec3<f32>, light: vec3<f32>) -> vec4<f32> {
    let sum = view + light;
    let length = sqrt(factored_dot(sum, sum));
    var scale = 0.0;
    if length > 1e-6 {
        scale = 1.0 / length;
    }
    var apart = base.normal - scale * sum;
    var share = 0.5;
    if ((factored_parameters.axes >> table) & 1u) == 1u {
        apart = view - (2.0 * cosine * base.normal - light);
        share = 0.25;
    }
    let angle = sqrt(sqrt(min(share * factored_dot(apart, apart), 1.0))) * f32(FACTORED_HALF_ANGLES - 1u);
    let difference = (1.0 - min(0.5 * length, 1.0)) * f32(FACTORED_DIFFERENCE_ANGLES - 1u);
    let row = f32(table * FACTORED_HALF_ANGLES) + angle;
    if brdfc_frame.sampler_filters == 1u {
        let at = vec3<f32>(difference, row, f32(base.level) + base.blend) + vec3<f32>(0.5);
        let size = vec3<f32>(textureDimensions(factored_tables));
        // The sampler repeats: rounding must not reach the other side.
        let inside = min(max(at, vec3<f32>(FACTORED_TABLE_EDGE)), size - vec3<f32>(FACTORED_TABLE_EDGE));
        return textureSampleLevel(factored_tables, factored_sampler, inside / size, 0.0);
    }
    let i = min(floor(angle), f32(FACTORED_HALF_ANGLES - 2u));
    let j = min(floor(difference), f32(FACTORED_DIFFERENCE_ANGLES - 2u));
    let first = vec3<u32>(u32(j), table * FACTORED_HALF_ANGLES + u32(i), base.level);
    let entry = factored_between(first, angle - i, difference - j);
    if base.blend > 0.0 {
        let coarse = factored_between(first + vec3<u32>(0u, 0u, 1u), angle - i, difference - j);
        return entry + base.blend * (coarse - entry);
    }
    return entry;
}

// Interpolates between four entries of a level.
fn factored_between(first: vec3<u32>, across: f32, along: f32) -> vec4<f32> {
    var entry = (1.0 - across) * (1.0 - along) * textureLoad(factored_tables, first, 0);
    entry += (1.0 - across) * along * textureLoad(factored_tables, first + vec3<u32>(1u, 0u, 0u), 0);
    entry += across * (1.0 - along) * textureLoad(factored_tables, first + vec3<u32>(0u, 1u, 0u), 0);
    entry += across * along * textureLoad(factored_tables, first + vec3<u32>(1u, 1u, 0u), 0);
    return entry;
}

// Sum of the components in a view under a light.
fn factored_pair(view: u32, light: u32) -> vec3<f32> {
    var opponent = vec3<f32>(0.0);
    for (var colour = 0u; colour < 3u; colour += 1u) {
        opponent[colour] = factored_sum(view, light, colour);
    }
    return opponent;
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

// Cube roots of non-negative numbers; 0 below 1e-18.
fn factored_cube_roots(x: vec3<f32>) -> vec3<f32> {
    let guess = bitcast<vec3<f32>>(bitcast<vec3<u32>>(x) / vec3<u32>(3u) + vec3<u32>(0x2a5137a0u));
    let first = factored_root_step(x, guess);
    return select(vec3<f32>(0.0), factored_root_step(x, first), x > vec3<f32>(1e-18));
}

fn factored_root_step(x: vec3<f32>, y: vec3<f32>) -> vec3<f32> {
    let cube = y * y * y;
    return y * (cube + 2.0 * x) / (2.0 * cube + x);
}

// Lightness and opponent colours of linear RGB.
fn factored_to_opponent(rgb: vec3<f32>) -> vec3<f32> {
    let xyz = vec3<f32>(
        0.433953 * rgb.x + 0.3762194 * rgb.y + 0.1898276 * rgb.z,
        0.2126729 * rgb.x + 0.7151522 * rgb.y + 0.072175 * rgb.z,
        0.0177566 * rgb.x + 0.10946796 * rgb.y + 0.8727754 * rgb.z);
    let root = factored_cube_roots(max(xyz, vec3<f32>(0.0)));
    return vec3<f32>(116.0 * root.y, 500.0 * (root.x - root.y), 200.0 * (root.y - root.z));
}

// Clamps a sum to the colours of the asset.
fn factored_bounded(opponent: vec3<f32>) -> vec3<f32> {
    let lightness = max(opponent.x, 0.0);
    let word = vec4<u32>(factored_parameters.chroma) << vec4<u32>(24u, 16u, 8u, 0u);
    let limit = vec4<f32>(bitcast<vec4<i32>>(word) >> vec4<u32>(24u)) * (1.0 / 48.0) * lightness;
    return vec3<f32>(
        lightness, min(max(opponent.y, limit.x), limit.y), min(max(opponent.z, limit.z), limit.w));
}

// Linear RGB of lightness and opponent colours.
fn factored_from_opponent(opponent: vec3<f32>) -> vec3<f32> {
    let y = opponent.x * (1.0 / 116.0);
    let x = y + opponent.y * (1.0 / 500.0);
    let z = y - opponent.z * (1.0 / 200.0);
    let sums = vec3<f32>(x, y, z);
    // NaN becomes 0.
    let root = select(vec3<f32>(0.0), min(sums, vec3<f32>(FACTORED_LARGEST_ROOT)), sums > vec3<f32>(0.0));
    let xyz = root * root * root;
    let rgb = vec3<f32>(
        3.0799556 * xyz.x + -1.537188 * xyz.y + -0.5427674 * xyz.z,
        -0.9212588 * xyz.x + 1.8760257 * xyz.y + 0.045232937 * xyz.z,
        0.052887354 * xyz.x + -0.20402668 * xyz.y + 1.1511394 * xyz.z);
    return max(rgb, vec3<f32>(0.0));
}

// Square roots of both shares of a light.
fn factored_residual_sample(uv: vec2<f32>, detail: f32, light: u32) -> vec2<f32> {
    if brdfc_frame.sampler_filters == 1u {
        return textureSampleLevel(factored_residual, factored_sampler, uv, light, detail).rg;
    }
    let level = u32(floor(detail));
    let fine = factored_residual_level(uv, level, light);
    let blend = detail - floor(detail);
    if blend > 0.0 {
        return fine + blend * (factored_residual_level(uv, level + 1u, light) - fine);
    }
    return fine;
}

// Decodes the four components of a layer.
fn factored_numbers(place: FactoredPlace, layer: u32) -> vec4<f32> {
    return factored_parameters.lows[layer] + factored_parameters.scales[layer] * factored_weight_sample(place, layer);
}

// Four components, 0 to 1 each.
fn factored_weight_sample(place: FactoredPlace, layer: u32) -> vec4<f32> {
    if brdfc_frame.sampler_filters == 1u {
        let detail = f32(place.level) + place.blend;
        return textureSampleLevel(factored_weights, factored_sampler, place.uv, layer, detail);
    }
    let fine = factored_weight_level(place.uv, place.level, layer);
    if place.blend > 0.0 {
        return fine + place.blend * (factored_weight_level(place.uv, place.level + 1u, layer) - fine);
    }
    return fine;
}

fn factored_residual_level(uv: vec2<f32>, level: u32, light: u32) -> vec2<f32> {
    let side = max(factored_parameters.residual >> level, 1u);
    let column = flat_btf_periodic_tap(uv.x, side);
    let row = flat_btf_periodic_tap(uv.y, side);
    var value = vec2<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let at = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        value = value + weight * textureLoad(factored_residual, at, light, level).rg;
    }
    return value;
}

fn factored_weight_level(uv: vec2<f32>, level: u32, layer: u32) -> vec4<f32> {
    let column = flat_btf_periodic_tap(uv.x, factored_side(level));
    let row = flat_btf_periodic_tap(uv.y, factored_side(level));
    var value = vec4<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let at = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        value = value + weight * textureLoad(factored_weights, at, layer, level);
    }
    return value;
}

// Texels per side of a mipmap level.
fn factored_side(level: u32) -> u32 {
    return max(factored_parameters.size >> level, 1u);
}
