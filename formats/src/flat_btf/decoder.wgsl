// Flat BTFs: a BTF over the parameters of its meso-geometry, with a view-dependent indirection to them.
//
// After Hadim, Pacanowski, Granier and Schlick 2009, "Flat bidirectional texture functions"; sections and equations
// refer to that paper. File layout: `formats/src/flat_btf/spec.md`. The CPU decoder `FlatBtfDecoder` of the crate
// `brdfc-formats` performs the same steps in the same order.
//
// Usage: prepend this file to your own shader, move the bindings as needed, and call
//
//     let seen = flat_btf_indirection(uv, view);        // parameters and height of the visible surface point
//     let value = flat_btf_light_form(uv, view, light);  // normal map and diffuse colour
//     let value = flat_btf_full(uv, view, views, lights); // all sampled views and lights
//
// uv is in tiles and unbounded. view (to the viewer) and light (to the light) are unit vectors in the frame x =
// tangent, y = bitangent, z = normal. Values are linear RGB: radiance divided by that of a white diffuser that faces
// the light.
//
// The indirection takes 5 fetches with manual filtering and 2 with the sampler, or 24 and 12 with displacements; the
// light form takes 8 more; the full form takes 4 more for each pair of a view and a light whose weights are not 0.

// Same fields and order as `FlatBtfParameters` of `brdfc-formats`. 48 bytes.
struct FlatBtfParameters {
    size: u32,             // T: the flat BTF has T x T texels
    reference_size: u32,   // M: the reference plane has M x M texels
    zenith_samples: u32,   // Z, number of polar angles of the views
    azimuth_samples: u32,  // A, number of azimuths of the views
    largest_angle: f32,    // φ_max, radians
    atlas_columns: u32,    // lights in a row of the atlas
    reserved_2: u32,
    blocks: u32,           // N: the image `displacement` has N x N blocks; 0 with the image `indirection`
    largest_tangent: f32,  // largest tangent of a polar angle in displacements
    values: u32,           // form of the values: 0 none, 1 uncompressed views, 2 factored
    reserved_0: u32,
    reserved_1: u32,
}

// Three sampled directions and their weights; directions with weight 0 are not fetched.
struct FlatBtfWeights {
    indices: vec3<u32>,
    weights: vec3<f32>,
}

@group(1) @binding(15) var<uniform> flat_btf_parameters: FlatBtfParameters;
// M x M texels of two 32-bit floats, the image `reference`. Not filtered.
@group(1) @binding(16) var flat_btf_reference: texture_2d<f32>;
// The image `indirection`: direction, distance, height as halves. Or the image `displacement`: two bytes.
@group(1) @binding(17) var flat_btf_packed_indirection: texture_2d<f32>;
// Linear filter, clamp to edge.
@group(1) @binding(18) var flat_btf_sampler: sampler;
// The image `normal`.
@group(1) @binding(19) var flat_btf_normal: texture_2d<f32>;
// The image `diffuse`.
@group(1) @binding(20) var flat_btf_diffuse: texture_2d<f32>;
// One layer per view. Light l has the tile of T x T texels at column l mod atlas_columns, row l / atlas_columns.
@group(1) @binding(21) var flat_btf_values: texture_2d_array<f32>;
// N x N texels of four halves, the ranges of the image `displacement`; otherwise any 2D texture.
@group(1) @binding(22) var flat_btf_ranges: texture_2d<f32>;

// Maximum difference of neighbours on the same side of a silhouette, in units of their distance on the reference plane.
const FLAT_BTF_SAME_SIDE: f32 = 4.0;
const FLAT_BTF_PI: f32 = 3.14159274;
const FLAT_BTF_HALF_PI: f32 = 1.57079637;
const FLAT_BTF_TAU: f32 = 6.28318548;
// Distance of the sampler from the border of a block, in texels: coordinates have rounding errors, and a fetch that is
// rounded outwards would blend with the next block.
const FLAT_BTF_GUARD: f32 = 0.001953125;

// Two neighbouring samples along one axis.
struct FlatBtfTap {
    lower: u32,
    upper: u32,
    weight: f32,   // of the upper sample
}

// Equation 3: parameters, in [0, 1), and height in tiles of the surface point visible through a point of the reference
// plane.
fn flat_btf_indirection(uv: vec2<f32>, view: vec3<f32>) -> vec3<f32> {
    let size = flat_btf_parameters.reference_size;
    let i = min(u32(flat_btf_wrap(uv.x) * f32(size)), size - 1u);
    let j = min(u32(flat_btf_wrap(uv.y) * f32(size)), size - 1u);
    let position = flat_btf_view_position(view);
    if flat_btf_parameters.blocks > 0u {
        let found = flat_btf_smooth_reference(uv);
        let moved = flat_btf_displacement(uv, position, view);
        return vec3<f32>(flat_btf_wrap(found.x + moved.x), flat_btf_wrap(found.y + moved.y), 0.0);
    }
    let reference = textureLoad(flat_btf_reference, vec2<u32>(i, j), 0);
    let blended = flat_btf_block(i, j, size, position);
    // The blended direction is renormalised: directions are blended over azimuth, distances linearly.
    let length = sqrt(blended.x * blended.x + blended.y * blended.y);
    let scale = select(0.0, blended.z / length, length > 0.0);
    let u = flat_btf_wrap(reference.x + scale * blended.x);
    let v = flat_btf_wrap(reference.y + scale * blended.y);
    return vec3<f32>(u, v, blended.w);
}

// Parameters of the view along the normal, interpolated between texel centres on the same side of a silhouette as the
// texel that contains uv.
fn flat_btf_smooth_reference(uv: vec2<f32>) -> vec2<f32> {
    let size = flat_btf_parameters.reference_size;
    let column = flat_btf_periodic_tap(flat_btf_wrap(uv.x), size);
    let row = flat_btf_periodic_tap(flat_btf_wrap(uv.y), size);
    var around: array<vec2<f32>, 4>;
    for (var k = 0u; k < 4u; k += 1u) {
        let at = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        around[k] = textureLoad(flat_btf_reference, at, 0).xy;
    }
    let here = around[flat_btf_nearest_tap(column, row)];
    var found = here;
    for (var k = 0u; k < 4u; k += 1u) {
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        let difference = around[k] - here;
        let apart = difference - floor(difference + 0.5);
        if max(abs(apart.x), abs(apart.y)) <= FLAT_BTF_SAME_SIDE / f32(size) {
            found += weight * apart;
        }
    }
    return found;
}

// Displacement of the visible point, interpolated like the reference and rotated from the view's own frame.
fn flat_btf_displacement(uv: vec2<f32>, position: vec2<f32>, view: vec3<f32>) -> vec2<f32> {
    let blocks = flat_btf_parameters.blocks;
    let length = sqrt(view.x * view.x + view.y * view.y);
    let most = flat_btf_parameters.largest_tangent;
    var tangent = most;
    if view.z > 0.0 {
        tangent = min(length / view.z, most);
    }
    let scale = tangent + 0.25;
    let column = flat_btf_periodic_tap(flat_btf_wrap(uv.x), blocks);
    let row = flat_btf_periodic_tap(flat_btf_wrap(uv.y), blocks);
    var around: array<vec2<f32>, 4>;
    for (var k = 0u; k < 4u; k += 1u) {
        around[k] = flat_btf_in_view(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u), position);
    }
    let here = around[flat_btf_nearest_tap(column, row)];
    var found = here;
    for (var k = 0u; k < 4u; k += 1u) {
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        let difference = around[k] - here;
        if max(abs(difference.x), abs(difference.y)) * scale <= FLAT_BTF_SAME_SIDE / f32(blocks) {
            found += weight * difference;
        }
    }
    var cosine = 1.0;
    var sine = 0.0;
    if length > 0.0 {
        cosine = view.x / length;
        sine = view.y / length;
    }
    let x = scale * (found.x * cosine - found.y * sine);
    let y = scale * (found.x * sine + found.y * cosine);
    return vec2<f32>(x, y);
}

// Displacement of block (i, j) in a view: along and across its azimuth.
fn flat_btf_in_view(i: u32, j: u32, position: vec2<f32>) -> vec2<f32> {
    let shares = flat_btf_block(i, j, flat_btf_parameters.blocks, position);
    let range = textureLoad(flat_btf_ranges, vec2<u32>(i, j), 0);
    return vec2<f32>(range.x + range.y * shares.x, range.z + range.w * shares.y);
}

// Blend of the view samples of a block, with `blocks` blocks per side.
fn flat_btf_block(i: u32, j: u32, blocks: u32, position: vec2<f32>) -> vec4<f32> {
    if brdfc_frame.sampler_filters == 1u {
        return flat_btf_sampled_block(i, j, blocks, position);
    }
    return flat_btf_loaded_block(i, j, position);
}

// Equation 1: the BTF from all sampled views and lights.
fn flat_btf_full(uv: vec2<f32>, view: vec3<f32>, views: FlatBtfWeights, lights: FlatBtfWeights) -> vec3<f32> {
    let seen = flat_btf_indirection(uv, view);
    let column = flat_btf_periodic_tap(seen.x, flat_btf_parameters.size);
    let row = flat_btf_periodic_tap(seen.y, flat_btf_parameters.size);
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
            value += weight * flat_btf_sample(views.indices[v], lights.indices[l], column, row);
        }
    }
    return value;
}

// Section 3.5: the light form, a diffuse colour lit with a normal map.
fn flat_btf_light_form(uv: vec2<f32>, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let seen = flat_btf_indirection(uv, view);
    let column = flat_btf_periodic_tap(seen.x, flat_btf_parameters.size);
    let row = flat_btf_periodic_tap(seen.y, flat_btf_parameters.size);
    var normal = vec3<f32>(0.0);
    var diffuse = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let at = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        let normal_texel = textureLoad(flat_btf_normal, at, 0);
        let diffuse_texel = textureLoad(flat_btf_diffuse, at, 0);
        normal += weight * normal_texel.xyz;
        diffuse += weight * diffuse_texel.rgb;
    }
    let length = sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
    let scale = select(0.0, 1.0 / length, length > 0.0);
    let cosine = (normal.x * light.x + normal.y * light.y + normal.z * light.z) * scale;
    return diffuse * max(cosine, 0.0);
}

// One view and light, filtered over the flat BTF with period 1.
fn flat_btf_sample(view: u32, light: u32, column: FlatBtfTap, row: FlatBtfTap) -> vec3<f32> {
    let columns = flat_btf_parameters.atlas_columns;
    let origin = vec2<u32>(light % columns, light / columns) * flat_btf_parameters.size;
    var value = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let at = origin + vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        let texel = textureLoad(flat_btf_values, at, view, 0);
        value += weight * texel.rgb;
    }
    return value;
}

// Position of a view among the samples of a block: polar angle in columns, azimuth in rows.
fn flat_btf_view_position(view: vec3<f32>) -> vec2<f32> {
    let angle = flat_btf_atan2(sqrt(view.x * view.x + view.y * view.y), view.z);
    let polar = min(angle, flat_btf_parameters.largest_angle);
    let half_azimuth = flat_btf_atan2(abs(view.y), view.x);
    let azimuth = select(half_azimuth, FLAT_BTF_TAU - half_azimuth, view.y < 0.0);
    let column = polar / flat_btf_parameters.largest_angle * f32(flat_btf_parameters.zenith_samples - 1u);
    let row = azimuth / FLAT_BTF_TAU * f32(flat_btf_parameters.azimuth_samples);
    return vec2<f32>(column, row);
}

// Four view samples around a position, blended with manual weights.
fn flat_btf_loaded_block(i: u32, j: u32, position: vec2<f32>) -> vec4<f32> {
    let column = flat_btf_block_tap(position.x, flat_btf_parameters.zenith_samples - 1u);
    let row = flat_btf_block_tap(position.y, flat_btf_parameters.azimuth_samples);
    let corner = vec2<u32>(i * flat_btf_parameters.zenith_samples, j * (flat_btf_parameters.azimuth_samples + 1u));
    var value = vec4<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let at = corner + vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        let texel = textureLoad(flat_btf_packed_indirection, at, 0);
        value += weight * texel;
    }
    return value;
}

// The same with the sampler. With t = φ / φ_max and N = `blocks` this is the paper's u = (i + α t + β) / N with α = (Z
// - 1) / Z and β = 1 / 2Z; for the azimuth α = A / (A + 1) and β = 1 / 2(A + 1).
fn flat_btf_sampled_block(i: u32, j: u32, blocks: u32, position: vec2<f32>) -> vec4<f32> {
    let samples = vec2<f32>(f32(flat_btf_parameters.zenith_samples), f32(flat_btf_parameters.azimuth_samples + 1u));
    let inside = clamp(position, vec2<f32>(FLAT_BTF_GUARD), samples - (1.0 + FLAT_BTF_GUARD));
    let texels = vec2<f32>(f32(i), f32(j)) * samples + inside + 0.5;
    let at = texels / (f32(blocks) * samples);
    let value = textureSampleLevel(flat_btf_packed_indirection, flat_btf_sampler, at, 0.0);
    return value;
}

// Fractional part, in [0, 1). A tiny negative number has a fraction that rounds to 1.
fn flat_btf_wrap(x: f32) -> f32 {
    let fraction = x - floor(x);
    return select(0.0, fraction, fraction < 1.0);
}

// Samples around a position from 0 to last.
fn flat_btf_block_tap(position: f32, last: u32) -> FlatBtfTap {
    let lower = min(u32(position), last - 1u);
    return FlatBtfTap(lower, lower + 1u, position - f32(lower));
}

// Texels around a parameter with period 1; texel centres are at (i + 1/2) / size.
fn flat_btf_periodic_tap(parameter: f32, size: u32) -> FlatBtfTap {
    let position = parameter * f32(size) - 0.5;
    let below = floor(position);
    let lower = select(min(u32(below), size - 1u), size - 1u, below < 0.0);
    let upper = select(lower + 1u, 0u, lower + 1u == size);
    return FlatBtfTap(lower, upper, position - below);
}

// Index of the nearest of four samples, rows outside.
fn flat_btf_nearest_tap(column: FlatBtfTap, row: FlatBtfTap) -> u32 {
    return select(0u, 1u, column.weight >= 0.5) + select(0u, 2u, row.weight >= 0.5);
}

fn flat_btf_tap_sample(tap: FlatBtfTap, upper: u32) -> u32 {
    return select(tap.lower, tap.upper, upper == 1u);
}

fn flat_btf_tap_weight(tap: FlatBtfTap, upper: u32) -> f32 {
    return select(1.0 - tap.weight, tap.weight, upper == 1u);
}
