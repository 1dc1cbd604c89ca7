// Decoder of polynomial wavelet trees. Layout: formats/src/pwt/spec.md. Bindings are in group 1; any texture can be
// bound for those that a pack lacks. All functions have Rust versions in formats/src/pwt. It follows
// `direction_mesh.wgsl`, which blends the views of a BTF.

struct PwtParameters {
    size: vec2<f32>,          // columns and rows of the image
    extent: vec2<f32>,        // columns and rows of texels
    repeats: u32,             // 1: a tile
    coordinates: u32,         // coordinates of the light: 0 paraboloid, 1 projected, 2 hemisphere, 3 learned
    degree: u32,
    domain: u32,              // 0 linear, 1 display, 2 cube root, 3 logarithm
    epsilon: f32,
    textures: u32,
    levels: u32,              // coarsest mipmap level
    map_side: u32,            // texels per side of the light map; 0 without learned terms
    views: u32,
    reserved_0: u32,
    reserved_1: u32,
    reserved_2: u32,
    first_level: array<vec4<u32>, 2>, // per texture, number of times that the image was halved
    layers: array<vec4<u32>, 2>,      // per texture, for each view
    channels: array<vec4<u32>, 2>,    // per texture
    colour: array<vec4<f32>, 3>,
    triangle: array<vec4<f32>, 167>,
    components: array<vec4<f32>, 128>, // channel, term, scale, low
}

// Same fields and order as `PwtParameters` of `brdfc-formats`.
@group(1) @binding(9) var<uniform> pwt: PwtParameters;
@group(1) @binding(10) var pwt_texture_0: texture_2d_array<f32>; // first texture of the pack, with its mipmaps
@group(1) @binding(11) var pwt_texture_1: texture_2d_array<f32>; // second texture, or any
@group(1) @binding(12) var pwt_texture_2: texture_2d_array<f32>; // third texture, or any
@group(1) @binding(13) var pwt_texture_3: texture_2d_array<f32>; // fourth texture, or any
@group(1) @binding(45) var pwt_texture_4: texture_2d_array<f32>; // and so on
@group(1) @binding(46) var pwt_texture_5: texture_2d_array<f32>;
@group(1) @binding(47) var pwt_texture_6: texture_2d_array<f32>;
@group(1) @binding(48) var pwt_texture_7: texture_2d_array<f32>;
@group(1) @binding(14) var pwt_sampler: sampler; // linear within and between levels; repeat for tiles, otherwise clamp

@group(1) @binding(43) var pwt_light_map: texture_2d_array<f32>; // RGB of each learned term over the paraboloid, or any
@group(1) @binding(44) var pwt_light_map_sampler: sampler; // linear, clamp

const PWT_LARGEST: f32 = 65504.0;

// Linear RGB at a point of the image, 0 to 1 across it and down from its top. Level 0 is full resolution. `wo` and `wi`
// are unit vectors to the viewer and to the light; a pack of one view ignores `wo`.
fn pwt_value(uv: vec2<f32>, level: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    var weights = pwt_weights(wi);
    let seen = pwt_seen(wo);
    var value = vec3<f32>(0.0);
    for (var k = 0u; k < 3u; k++) {
        if seen.weights[k] > 0.0 {
            value += seen.weights[k] * pwt_linear(pwt_sum(uv, level, seen.indices[k], &weights));
        }
    }
    return value;
}

// Three views and their weights.
fn pwt_seen(wo: vec3<f32>) -> DirectionMeshWeights {
    if pwt.views == 1u {
        return DirectionMeshWeights(vec3<u32>(0u), vec3<f32>(1.0, 0.0, 0.0));
    }
    return direction_mesh_weights(wo, 0u);
}

// Mipmap level of a pixel, from the differences of uv to its neighbours.
fn pwt_mipmap_level(right: vec2<f32>, below: vec2<f32>) -> f32 {
    let across = right * pwt.size;
    let down = below * pwt.size;
    return max(0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-20)), 0.0);
}

// Weights of all terms under a light, in red, green and blue. For distant lights they are the same everywhere, so once per
// light is enough.
fn pwt_weights(wi: vec3<f32>) -> array<vec3<f32>, 36> {
    var weights: array<vec3<f32>, 36>;
    if pwt.coordinates == 3u {
        for (var k = 0u; k <= pwt.degree; k++) {
            weights[k] = pwt_learned(k, wi.xy / (1.0 + wi.z) * 0.5 + 0.5);
        }
        return weights;
    }
    var terms = pwt_evaluate(wi);
    let n = pwt.degree + 1u;
    let count = select(n * (n + 1u) / 2u, n * n, pwt.coordinates == 2u);
    var at = 0u;
    for (var k = 0u; k < count; k++) {
        var weight = 0.0;
        for (var j = 0u; j <= k; j++) {
            weight += pwt.triangle[at / 4u][at % 4u] * terms[j];
            at++;
        }
        weights[k] = vec3<f32>(weight);
    }
    return weights;
}

// A learned term at a place of the light map, 0 to 1.
fn pwt_learned(term: u32, at: vec2<f32>) -> vec3<f32> {
    if brdfc_frame.sampler_filters == 1u {
        return textureSampleLevel(pwt_light_map, pwt_light_map_sampler, at, term, 0.0).rgb;
    }
    let last = vec2<i32>(i32(pwt.map_side) - 1);
    let position = at * f32(pwt.map_side) - 0.5;
    let lower = floor(position);
    let weight = position - lower;
    let first = clamp(vec2<i32>(lower), vec2<i32>(0), last);
    let next = clamp(vec2<i32>(lower) + 1, vec2<i32>(0), last);
    let a = textureLoad(pwt_light_map, first, term, 0).rgb;
    let b = textureLoad(pwt_light_map, vec2<i32>(next.x, first.y), term, 0).rgb;
    let c = textureLoad(pwt_light_map, vec2<i32>(first.x, next.y), term, 0).rgb;
    let d = textureLoad(pwt_light_map, next, term, 0).rgb;
    let upper = a + weight.x * (b - a);
    let under = c + weight.x * (d - c);
    return upper + weight.y * (under - upper);
}

// All polynomials of the light.
fn pwt_evaluate(wi: vec3<f32>) -> array<f32, 36> {
    if pwt.coordinates == 2u {
        return pwt_harmonics(wi.x, wi.y, max(wi.z, 0.0));
    }
    let scale = 1.0 + wi.z;
    if pwt.coordinates == 0u {
        return pwt_powers(wi.x / scale, wi.y / scale);
    }
    return pwt_powers(wi.x, wi.y);
}

fn pwt_powers(u: f32, v: f32) -> array<f32, 36> {
    var terms: array<f32, 36>;
    terms[0] = 1.0;
    var before = 0u;
    for (var degree = 1u; degree <= pwt.degree; degree++) {
        let first = before + degree;
        for (var k = 0u; k < degree; k++) {
            terms[first + k] = terms[before + k] * u;
        }
        terms[first + degree] = terms[first - 1u] * v;
        before = first;
    }
    return terms;
}

fn pwt_harmonics(x: f32, y: f32, z: f32) -> array<f32, 36> {
    var terms: array<f32, 36>;
    let shifted = 2.0 * z - 1.0;
    let scale = 2.0 * sqrt(z / (1.0 + z));
    let a = scale * x;
    let b = scale * y;
    var cosine = 1.0;
    var sine = 0.0;
    var diagonal = 1.0;
    for (var m = 0u; m <= pwt.degree; m++) {
        let order = f32(m);
        if m > 0u {
            let turned = cosine * a - sine * b;
            sine = cosine * b + sine * a;
            cosine = turned;
            diagonal *= 2.0 * order - 1.0;
        }
        var before = 0.0;
        var legendre = diagonal;
        for (var l = m; l <= pwt.degree; l++) {
            let middle = l * l + l;
            terms[middle + m] = legendre * cosine;
            if m > 0u {
                terms[middle - m] = legendre * sine;
            }
            let degree = f32(l);
            let next = (2.0 * degree + 1.0) * shifted * legendre - (degree + order) * before;
            before = legendre;
            legendre = next / (degree - order + 1.0);
        }
    }
    return terms;
}

// RGB of a view at a point, in the domain of the pack: one fetch per layer if the sampler filters.
fn pwt_sum(uv: vec2<f32>, level: f32, view: u32, weights: ptr<function, array<vec3<f32>, 36>>) -> vec3<f32> {
    let within = select(clamp(uv, vec2<f32>(0.0), vec2<f32>(1.0)), uv - floor(uv), pwt.repeats == 1u);
    let at = within * (pwt.size / pwt.extent);
    // The first learned term is 1 in every texel.
    var sum = select(vec3<f32>(0.0), (*weights)[0], pwt.coordinates == 3u);
    var first = 0u;
    for (var index = 0u; index < pwt.textures; index++) {
        let base = pwt.first_level[index / 4u][index % 4u];
        let own = clamp(level - f32(base), 0.0, f32(pwt.levels - base));
        for (var layer = 0u; layer < pwt.layers[index / 4u][index % 4u]; layer++) {
            let texel = pwt_sample(index, layer * pwt.views + view, at, own);
            for (var k = 0u; k < pwt.channels[index / 4u][index % 4u]; k++) {
                let component = pwt.components[first];
                let value = component.w + component.z * texel[k];
                sum += pwt.colour[u32(component.x)].rgb * (*weights)[u32(component.y)] * value;
                first++;
            }
        }
    }
    return sum;
}

fn pwt_sample(index: u32, layer: u32, at: vec2<f32>, own: f32) -> vec4<f32> {
    if brdfc_frame.sampler_filters == 1u {
        switch index {
            case 0u: { return textureSampleLevel(pwt_texture_0, pwt_sampler, at, layer, own); }
            case 1u: { return textureSampleLevel(pwt_texture_1, pwt_sampler, at, layer, own); }
            case 2u: { return textureSampleLevel(pwt_texture_2, pwt_sampler, at, layer, own); }
            case 3u: { return textureSampleLevel(pwt_texture_3, pwt_sampler, at, layer, own); }
            case 4u: { return textureSampleLevel(pwt_texture_4, pwt_sampler, at, layer, own); }
            case 5u: { return textureSampleLevel(pwt_texture_5, pwt_sampler, at, layer, own); }
            case 6u: { return textureSampleLevel(pwt_texture_6, pwt_sampler, at, layer, own); }
            default: { return textureSampleLevel(pwt_texture_7, pwt_sampler, at, layer, own); }
        }
    }
    let finer = u32(own);
    let blend = own - f32(finer);
    // A loop, as some compilers of WebGL take minutes if the filter is called twice.
    var levels: array<vec4<f32>, 2>;
    for (var k = 0u; k < select(1u, 2u, blend > 0.0); k++) {
        levels[k] = pwt_filtered(index, layer, at, finer + k);
    }
    return levels[0] + blend * (levels[1] - levels[0]);
}

// A level, filtered along columns first.
fn pwt_filtered(index: u32, layer: u32, at: vec2<f32>, level: u32) -> vec4<f32> {
    let side = vec2<u32>(pwt.extent) >> vec2<u32>(pwt.first_level[index / 4u][index % 4u] + level);
    let position = at * vec2<f32>(side) - 0.5;
    let lower = floor(position);
    let weight = position - lower;
    let first = pwt_texel_at(vec2<i32>(lower), vec2<i32>(side));
    let last = pwt_texel_at(vec2<i32>(lower) + 1, vec2<i32>(side));
    let a = pwt_load(index, layer, first, level);
    let b = pwt_load(index, layer, vec2<i32>(last.x, first.y), level);
    let c = pwt_load(index, layer, vec2<i32>(first.x, last.y), level);
    let d = pwt_load(index, layer, last, level);
    let upper = a + weight.x * (b - a);
    let under = c + weight.x * (d - c);
    return upper + weight.y * (under - upper);
}

fn pwt_texel_at(texel: vec2<i32>, side: vec2<i32>) -> vec2<i32> {
    if pwt.repeats == 1u {
        return ((texel % side) + side) % side;
    }
    return clamp(texel, vec2<i32>(0), side - 1);
}

fn pwt_load(index: u32, layer: u32, texel: vec2<i32>, level: u32) -> vec4<f32> {
    switch index {
        case 0u: { return textureLoad(pwt_texture_0, texel, layer, level); }
        case 1u: { return textureLoad(pwt_texture_1, texel, layer, level); }
        case 2u: { return textureLoad(pwt_texture_2, texel, layer, level); }
        case 3u: { return textureLoad(pwt_texture_3, texel, layer, level); }
        case 4u: { return textureLoad(pwt_texture_4, texel, layer, level); }
        case 5u: { return textureLoad(pwt_texture_5, texel, layer, level); }
        case 6u: { return textureLoad(pwt_texture_6, texel, layer, level); }
        default: { return textureLoad(pwt_texture_7, texel, layer, level); }
    }
}

// Converts a value from the domain of the pack to linear RGB.
fn pwt_linear(value: vec3<f32>) -> vec3<f32> {
    var linear = value;
    switch pwt.domain {
        case 0u: {}
        case 1u: {
            let high = pow(max((value + 0.055) / 1.055, vec3<f32>(0.0)), vec3<f32>(2.4));
            linear = select(high, value / 12.92, value <= vec3<f32>(0.04045));
        }
        case 2u: { linear = value * value * value; }
        default: { linear = exp(min(value, vec3<f32>(80.0))) - pwt.epsilon; }
    }
    // NaN becomes 0.
    return select(vec3<f32>(0.0), min(linear, vec3<f32>(PWT_LARGEST)), linear > vec3<f32>(0.0));
}
