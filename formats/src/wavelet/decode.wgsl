// Wavelet BRDF packs: f_r of a direction pair at a continuous level of detail.
//
// After Claustres, Barthe and Paulin 2007, "Wavelet encoding of BRDFs for real-time rendering"; sections and equations
// refer to that paper. Layout: `formats/src/wavelet/spec.md`. The CPU decoder `WaveletDecoder` of the crate
// `brdfc-formats` performs the same steps in the same order.
//
// Usage: prepend this file to your own shader, move the bindings as needed, and call
//
//     let level = wavelet_brdf_level_of_detail(distance);
//     let f_r = wavelet_brdf(wi, wo, level);         // hardware filtering of the outer direction
//     let f_r = wavelet_brdf_exact(wi, wo, level);   // manual filtering: slower, the same bits as the CPU decoder
//
// wi (to the light) and wo (to the viewer) are unit vectors in the frame x = tangent, y = bitangent, z = normal. The
// result is linear RGB in 1/sr, 0 if a direction is at or below the horizon.
//
// One reconstruction takes 4 l + 1 texture fetches at level l; blended levels count as the finer one. There are two
// details per level, each read through the index map, and the scaling coefficient, which is always slice 1. Filter
// modes:
//
//     0 nearest    one reconstruction; the exact path takes the nearest cell of a slice, the hardware path filters it
//     1 slices     one reconstruction, slices filtered bilinearly (section 5.2)
//     2 bilinear   four reconstructions around the inner direction, blended (section 5.4.2)
//
// Energy-preserving packs have a tree for each level, whose scaling coefficient is read through the index map, too: one
// fetch more. Between levels both are reconstructed.

// Same fields and order as `WaveletBrdfParameters` of `brdfc-formats`. 48 bytes.
struct WaveletBrdfParameters {
    levels: u32,             // N: each hemisphere has 2^N x 2^N cells
    parameterisation: u32,   // 0 tangent-pole, 1 half-difference
    reserved_0: u32,
    channels: u32,           // 1 grey, 3 RGB
    mean: f32,               // μ, 1/sr
    bias: f32,               // ε
    scaling_scale: f32,      // of slice 1
    scaling_offset: f32,     // of slice 1
    slices: f32,             // depth of the 3D texture
    reserved_1: f32,
    trees: u32,              // levels of detail with trees of their own; 0 if the pack is not energy-preserving
    window: u32,             // stored outer cells: first column, first row, columns, rows, 8 bits each
}

@group(1) @binding(5) var<uniform> wavelet_brdf_parameters: WaveletBrdfParameters;
// Texture of the KTX2 file.
@group(1) @binding(6) var wavelet_brdf_slices: texture_3d<f32>;
// Texels of 32-bit floats, 2^N per row, coefficient k at (k mod 2^N, k / 2^N): slice, its scale, its offset, and 0. Trees
// of coarser levels follow the finest one.
@group(1) @binding(7) var wavelet_brdf_index: texture_2d<f32>;
// Linear filter, clamp to edge.
@group(1) @binding(8) var wavelet_brdf_sampler: sampler;

const WAVELET_BRDF_PI: f32 = 3.14159274;
const WAVELET_BRDF_HALF_PI: f32 = 1.57079637;
const WAVELET_BRDF_SQRT_2: f32 = 1.41421354;
const WAVELET_BRDF_LARGEST: f32 = 3.4028234e38;

// Two neighbouring cells along one axis.
struct WaveletBrdfTap {
    lower: u32,
    upper: u32,
    weight: f32,   // of the upper cell
    position: f32, // angle / π, in [0, 1]: the texture coordinate
}

// Position of a direction on its hemisphere.
struct WaveletBrdfTaps {
    column: WaveletBrdfTap,
    row: WaveletBrdfTap,
}

// Outer and inner hemisphere points of a direction pair.
struct WaveletBrdfAxes {
    outer: vec3<f32>,
    inner: vec3<f32>,
}

// Section 5.4.1: l = N - clamp(log2(α d), 0, N) at distance d from the viewer. N is the finest level.
fn wavelet_brdf_level_of_detail(distance: f32) -> f32 {
    let levels = f32(wavelet_brdf_parameters.levels);
    return levels - clamp(log2(brdfc_frame.distance_scale * distance), 0.0, levels);
}

// f_r with the sampler's bilinear filter in slices.
fn wavelet_brdf(wi: vec3<f32>, wo: vec3<f32>, level: f32) -> vec3<f32> {
    if !(wi.z > 0.0 && wo.z > 0.0) {
        return vec3<f32>(0.0);
    }
    return wavelet_brdf_from_log(wavelet_brdf_log_value(wi, wo, level, true));
}

// f_r with manual weights.
fn wavelet_brdf_exact(wi: vec3<f32>, wo: vec3<f32>, level: f32) -> vec3<f32> {
    if !(wi.z > 0.0 && wo.z > 0.0) {
        return vec3<f32>(0.0);
    }
    return wavelet_brdf_from_log(wavelet_brdf_log_value(wi, wo, level, false));
}

// Inverse of the log encoding of section 5.1: f = μ (exp(v) - ε), clamped to 0 and to the largest number.
fn wavelet_brdf_from_log(value: vec3<f32>) -> vec3<f32> {
    let f = wavelet_brdf_parameters.mean * (exp(value) - wavelet_brdf_parameters.bias);
    return select(vec3<f32>(0.0), min(f, vec3<f32>(WAVELET_BRDF_LARGEST)), f > vec3<f32>(0.0));
}

// Log-encoded value ln(f / μ + ε). Both directions are above the horizon.
fn wavelet_brdf_log_value(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    let axes = wavelet_brdf_axes(wi, wo);
    let outer = wavelet_brdf_taps(axes.outer, brdfc_frame.blend > 0u);
    let inner = wavelet_brdf_taps(axes.inner, brdfc_frame.blend == 2u);
    let cells = select(4u, 1u, brdfc_frame.blend == 0u);
    if brdfc_frame.blend < 2u {
        return wavelet_brdf_reconstruct(outer, cells, inner.column.lower, inner.row.lower, level, hardware);
    }
    var value = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let column = wavelet_brdf_cell(inner.column, k & 1u);
        let row = wavelet_brdf_cell(inner.row, k >> 1u);
        let weight = wavelet_brdf_cell_weight(inner.row, k >> 1u) * wavelet_brdf_cell_weight(inner.column, k & 1u);
        value += weight * wavelet_brdf_reconstruct(outer, cells, column, row, level, hardware);
    }
    return value;
}

// Value of an inner cell at a level of detail. Levels with trees of their own are blended between their values.
fn wavelet_brdf_reconstruct(
    outer: WaveletBrdfTaps,
    cells: u32,
    column: u32,
    row: u32,
    level: f32,
    hardware: bool,
) -> vec3<f32> {
    let levels = wavelet_brdf_parameters.levels;
    let trees = wavelet_brdf_parameters.trees;
    let clamped = clamp(level, 0.0, f32(levels));
    let whole = u32(floor(clamped));
    let fraction = clamped - floor(clamped);
    let is_finest = whole >= trees;
    var values: array<vec3<f32>, 2>;
    for (var k = 0u; k < select(2u, 1u, is_finest || fraction == 0.0); k += 1u) {
        let own = whole + k;
        let has_tree = own < trees;
        let depth = select(levels, own, has_tree);
        let first = select(0u, (1u << (2u * levels)) + ((1u << (2u * own)) - 1u) / 3u, has_tree);
        let at = vec2<u32>(column, row) >> vec2<u32>(levels - depth);
        values[k] = wavelet_brdf_path(first, depth, outer, cells, at, select(f32(own), clamped, is_finest), hardware);
    }
    if is_finest || fraction == 0.0 {
        return values[0];
    }
    return values[0] + fraction * (values[1] - values[0]);
}

// Section 5.3, synthesis (equation 2) along one path of a tree, whose coefficients start at `first`. Level j refines
// 2^j x 2^j cells to twice as many per axis: first the latitude detail with weight 2^-(N-j), then the longitude detail
// with weight √2 2^-(N-j). These weights combine the divisions by √2 of all levels; the sign depends on the half.
fn wavelet_brdf_path(
    first: u32,
    levels: u32,
    outer: WaveletBrdfTaps,
    cells: u32,
    at: vec2<u32>,
    level: f32,
    hardware: bool,
) -> vec3<f32> {
    let whole = u32(floor(level));
    let fraction = level - floor(level);
    let last = whole + select(0u, 1u, fraction > 0.0);
    var value = wavelet_brdf_coefficient(wavelet_brdf_scaling(first), outer, cells, hardware) * wavelet_brdf_weight(levels);
    for (var j = 0u; j < last; j += 1u) {
        let child_column = at.x >> (levels - j - 1u);
        let child_row = at.y >> (levels - j - 1u);
        let parent_column = child_column >> 1u;
        let parent_row = child_row >> 1u;
        let side = 1u << j;
        let of_level = first + side * side;
        let latitude = wavelet_brdf_entry(of_level + parent_row * side + parent_column);
        let longitude = wavelet_brdf_entry(of_level + side * side + child_row * side + parent_column);
        let weight = wavelet_brdf_weight(levels - j);
        let latitude_weight = select(-weight, weight, (child_row & 1u) == 0u);
        let longitude_weight = select(-(weight * WAVELET_BRDF_SQRT_2), weight * WAVELET_BRDF_SQRT_2, (child_column & 1u) == 0u);
        let a = wavelet_brdf_coefficient(latitude, outer, cells, hardware);
        let b = wavelet_brdf_coefficient(longitude, outer, cells, hardware);
        // The coarser value is an intermediate result of the finer one, so blending levels needs no second
        // reconstruction.
        let part = select(1.0, fraction, j == whole);
        value += part * (latitude_weight * a + longitude_weight * b);
    }
    return value;
}

// Exact 2^-n.
fn wavelet_brdf_weight(n: u32) -> f32 {
    return bitcast<f32>((127u - n) << 23u);
}

// Entry of the scaling coefficient of a tree. That of the finest tree is in slice 1.
fn wavelet_brdf_scaling(first: u32) -> vec4<f32> {
    if first > 0u {
        return wavelet_brdf_entry(first);
    }
    return vec4<f32>(1.0, wavelet_brdf_parameters.scaling_scale, wavelet_brdf_parameters.scaling_offset, 0.0);
}

// Figure 6: the compression map. Slice, scale and offset of a coefficient, all 0 if it was dropped.
fn wavelet_brdf_entry(coefficient: u32) -> vec4<f32> {
    let levels = wavelet_brdf_parameters.levels;
    let texel = vec2<u32>(coefficient & ((1u << levels) - 1u), coefficient >> levels);
    return textureLoad(wavelet_brdf_index, texel, 0);
}

// Coefficient at the outer direction: offset + scale * texel. Slice 0 is all zero, so no branch is needed.
fn wavelet_brdf_coefficient(entry: vec4<f32>, outer: WaveletBrdfTaps, cells: u32, hardware: bool) -> vec3<f32> {
    let window = wavelet_brdf_window();
    if hardware {
        let depth = (entry.x + 0.5) / wavelet_brdf_parameters.slices;
        let n = f32(1u << wavelet_brdf_parameters.levels);
        let position = vec2<f32>(outer.column.position, outer.row.position) * n - vec2<f32>(window.xy);
        let at = vec3<f32>(position / vec2<f32>(window.zw), depth);
        let texel = textureSampleLevel(wavelet_brdf_slices, wavelet_brdf_sampler, at, 0.0);
        return vec3<f32>(entry.z) + entry.y * wavelet_brdf_colour(texel);
    }
    var value = vec3<f32>(0.0);
    for (var k = 0u; k < cells; k += 1u) {
        let cell = vec2<u32>(wavelet_brdf_cell(outer.column, k & 1u), wavelet_brdf_cell(outer.row, k >> 1u));
        let stored = clamp(cell, window.xy, window.xy + window.zw - 1u) - window.xy;
        let weight = wavelet_brdf_cell_weight(outer.row, k >> 1u) * wavelet_brdf_cell_weight(outer.column, k & 1u);
        let texel = textureLoad(wavelet_brdf_slices, vec3<u32>(stored, u32(entry.x)), 0);
        value += weight * (vec3<f32>(entry.z) + entry.y * wavelet_brdf_colour(texel));
    }
    return value;
}

// Stored outer cells: first column, first row, columns, rows. Cells outside the window of a cropped pack are clamped to
// it.
fn wavelet_brdf_window() -> vec4<u32> {
    return (vec4<u32>(wavelet_brdf_parameters.window) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u);
}

// Grey packs have the same value in all channels.
fn wavelet_brdf_colour(texel: vec4<f32>) -> vec3<f32> {
    return select(texel.rgb, texel.rrr, wavelet_brdf_parameters.channels == 1u);
}

fn wavelet_brdf_cell(tap: WaveletBrdfTap, upper: u32) -> u32 {
    return select(tap.lower, tap.upper, upper == 1u);
}

fn wavelet_brdf_cell_weight(tap: WaveletBrdfTap, upper: u32) -> f32 {
    return select(1.0 - tap.weight, tap.weight, upper == 1u);
}

// Section 4.1: the pole of the grid is the bitangent; x = sin φ cos θ, y = cos φ, z = sin φ sin θ.
fn wavelet_brdf_taps(direction: vec3<f32>, filtered: bool) -> WaveletBrdfTaps {
    let x = direction.x;
    let z = max(direction.z, 0.0);
    let longitude = wavelet_brdf_atan2(z, x);
    let colatitude = wavelet_brdf_atan2(sqrt(x * x + z * z), direction.y);
    return WaveletBrdfTaps(wavelet_brdf_tap(longitude, filtered), wavelet_brdf_tap(colatitude, filtered));
}

// Cells around an angle in [0, π], with centres at (i + 1/2) π / n; or the nearest cell.
fn wavelet_brdf_tap(angle: f32, filtered: bool) -> WaveletBrdfTap {
    let n = 1u << wavelet_brdf_parameters.levels;
    let relative = angle / WAVELET_BRDF_PI;
    let position = relative * f32(n);
    if !filtered {
        let cell = min(u32(position), n - 1u);
        return WaveletBrdfTap(cell, cell, 0.0, relative);
    }
    let centred = clamp(position - 0.5, 0.0, f32(n - 1u));
    let lower = u32(centred);
    return WaveletBrdfTap(lower, min(lower + 1u, n - 1u), centred - f32(lower), relative);
}

// Outer and inner hemisphere points: light and viewer, or the half vector h and the light in the frame that the
// shortest rotation from h to the normal gives.
fn wavelet_brdf_axes(i: vec3<f32>, o: vec3<f32>) -> WaveletBrdfAxes {
    if wavelet_brdf_parameters.parameterisation == 0u {
        return WaveletBrdfAxes(i, o);
    }
    let sum = i + o;
    let h = sum / sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    let s = (h.x * i.x + h.y * i.y) / (1.0 + h.z) + i.z;
    let z = h.x * i.x + h.y * i.y + h.z * i.z;
    return WaveletBrdfAxes(h, vec3<f32>(i.x - h.x * s, i.y - h.y * s, z));
}
