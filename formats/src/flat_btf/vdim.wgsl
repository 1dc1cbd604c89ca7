// Flat BTFs: view-dependent indirection maps (VDIM).
//
// After sections 3.4 and 3.5 of Hadim, Pacanowski, Granier and Schlick 2009, "Flat bidirectional texture functions". The
// CPU versions are `Vdim` and `CompactSamples` of the crate `brdfc-formats`.
//
// Usage: append this file to `decoder.wgsl`. With the sampler a map takes 2 fetches, with compact samples 5.

// M x M texels: parameters that the view along the normal sees less the centre of the texel, in tiles. Only loaded: filtered
// references would not match the map, whose texels are not filtered.
@group(1) @binding(19) var flat_btf_reference: texture_2d<f32>;
// A block of Z x R views for each texel: direction (x, y) and length of the displacement, in tiles, and the height of the
// visible point, in tiles. A mipmap level has the blocks of larger texels. Compact samples have two numbers for a block of
// texels: displacements along and across the azimuth of the view, between the bounds of the block.
@group(1) @binding(20) var flat_btf_vdim: texture_2d<f32>;

const FLAT_BTF_PI: f32 = 3.14159274;
const FLAT_BTF_HALF_PI: f32 = 1.57079637;
const FLAT_BTF_TAU: f32 = 6.28318548;
// Distance from the border of a block, in texels, that the sampler keeps: a coordinate that is rounded outwards would blend
// with the next block. Samplers have weights of 8 bits.
const FLAT_BTF_GUARD: f32 = 0.001953125;
// Compact displacements are divided by the tangent of the polar angle plus this number.
const FLAT_BTF_TANGENT_BIAS: f32 = 0.25;

// What a view sees through a point of the reference plane.
struct FlatBtfSeen {
    parameters: vec2<f32>, // not wrapped
    height: f32,           // in tiles
}

// Equations 2 and 3. uv is in tiles and unbounded; view is a unit vector in the frame along u and v; detail is the level of
// the map, 0 the finest.
fn flat_btf_vdim_seen(uv: vec2<f32>, view: vec3<f32>, detail: f32) -> FlatBtfSeen {
    // The nearest level: levels are not blended.
    let level = u32(floor(flat_btf_level(detail) + 0.5));
    let side = flat_btf_parameters.size >> level;
    let i = min(u32(flat_btf_wrap(uv.x) * f32(side)), side - 1u);
    let j = min(u32(flat_btf_wrap(uv.y) * f32(side)), side - 1u);
    let reference = textureLoad(flat_btf_reference, vec2<u32>(i, j), level).xy;
    let is_compact = flat_btf_parameters.block > 0u;
    let texels = max(flat_btf_parameters.block, 1u);
    let block = vec2<u32>(i, j) / texels;
    let position = flat_btf_vdim_position(view);
    var blended = vec4<f32>(0.0);
    if brdfc_frame.sampler_filters == 1u {
        blended = flat_btf_vdim_sampled(block, position, side / texels, level);
    } else {
        blended = flat_btf_vdim_loaded(block, position, level);
    }
    if is_compact {
        let parameters = uv + (reference + flat_btf_compact_displacement(block, level, blended.xy, view));
        let share = flat_btf_column(parameters, detail).x;
        return FlatBtfSeen(parameters, flat_btf_parameters.low + flat_btf_parameters.range * share);
    }
    // Directions are blended over the azimuth and normalised, distances are blended linearly.
    let length = sqrt(blended.x * blended.x + blended.y * blended.y);
    var scale = 0.0;
    if length > 0.0 {
        scale = blended.z / length;
    }
    return FlatBtfSeen(uv + (reference + scale * blended.xy), blended.w);
}

// Displacement that a view sees in a block of compact samples; blended is 0 to 1.
fn flat_btf_compact_displacement(block: vec2<u32>, level: u32, blended: vec2<f32>, view: vec3<f32>) -> vec2<f32> {
    let low = textureLoad(flat_btf_displacements, block, 0, level).xy;
    let extent = textureLoad(flat_btf_displacements, block, 1, level).xy;
    let moved = low + extent * blended;
    let length = sqrt(view.x * view.x + view.y * view.y);
    var azimuth = vec2<f32>(1.0, 0.0);
    if length > 0.0 {
        azimuth = view.xy / length;
    }
    var tangent = flat_btf_parameters.largest_tangent;
    if view.z > 0.0 {
        tangent = min(length / view.z, tangent);
    }
    let growth = tangent + FLAT_BTF_TANGENT_BIAS;
    let x = growth * (moved.x * azimuth.x - moved.y * azimuth.y);
    let y = growth * (moved.x * azimuth.y + moved.y * azimuth.x);
    return vec2<f32>(x, y);
}

// Position of a view among the samples of a block: the polar angle in columns, the azimuth in rows.
fn flat_btf_vdim_position(view: vec3<f32>) -> vec2<f32> {
    let angle = flat_btf_atan2(sqrt(view.x * view.x + view.y * view.y), view.z);
    let polar = min(angle, flat_btf_parameters.largest_angle);
    let half_turn = flat_btf_atan2(abs(view.y), view.x);
    let azimuth = select(half_turn, FLAT_BTF_TAU - half_turn, view.y < 0.0);
    let column = polar / flat_btf_parameters.largest_angle * f32(flat_btf_parameters.polar_angles - 1u);
    let row = azimuth / FLAT_BTF_TAU * f32(flat_btf_parameters.azimuth_rows - 1u);
    return vec2<f32>(column, row);
}

// The four views around a position, blended by the sampler. With t = φ / φ_max this is the paper's u = (i + α t + β) / M with
// α = (Z - 1) / Z and β = 1 / 2Z, and likewise for the azimuth with R.
fn flat_btf_vdim_sampled(block: vec2<u32>, position: vec2<f32>, blocks: u32, level: u32) -> vec4<f32> {
    let samples = vec2<f32>(f32(flat_btf_parameters.polar_angles), f32(flat_btf_parameters.azimuth_rows));
    let inside = clamp(position, vec2<f32>(FLAT_BTF_GUARD), samples - (1.0 + FLAT_BTF_GUARD));
    let at = (vec2<f32>(block) * samples + inside + 0.5) / (f32(blocks) * samples);
    let detail = f32(level);
    return textureSampleLevel(flat_btf_vdim, flat_btf_sampler, at, detail);
}

// The same with exact weights.
fn flat_btf_vdim_loaded(block: vec2<u32>, position: vec2<f32>, level: u32) -> vec4<f32> {
    let column = flat_btf_block_tap(position.x, flat_btf_parameters.polar_angles - 1u);
    let row = flat_btf_block_tap(position.y, flat_btf_parameters.azimuth_rows - 1u);
    let corner = block * vec2<u32>(flat_btf_parameters.polar_angles, flat_btf_parameters.azimuth_rows);
    var value = vec4<f32>(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let at = corner + vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        value = value + weight * textureLoad(flat_btf_vdim, at, level);
    }
    return value;
}

// Samples around a position from 0 to last.
fn flat_btf_block_tap(position: f32, last: u32) -> FlatBtfTap {
    let lower = min(u32(position), last - 1u);
    return FlatBtfTap(lower, lower + 1u, position - f32(lower));
}
