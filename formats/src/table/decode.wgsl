// Table packs: f_r of a direction pair, from one filtered fetch (two for anisotropic materials). Factored packs take
// one more fetch of a curve (two between levels of detail).
//
// Layout and equations: `formats/src/table/spec.md`. The CPU decoder `TableDecoder` of the crate `brdfc-formats`
// performs the same steps in the same order. Half-difference angles after Rusinkiewicz 1998.
//
// Usage: prepend this file to your own shader, move the bindings as needed, and call
//
//     let f_r = table_brdf(wi, wo);                 // the sampler filters
//     let f_r = table_brdf_exact(wi, wo);           // manual filtering: eight loads for one fetch (two of a curve), the
//                                                   // same bits as the CPU decoder
//     let f_r = table_brdf_at(wi, wo, level, true); // at a level of detail, such as table_brdf_level_of_detail(distance)
//
// wi (to the light) and wo (to the viewer) are unit vectors in the frame x = tangent, y = bitangent, z = normal. The
// result is linear RGB in 1/sr, 0 if a direction is at or below the horizon.

// Same fields and order as `TableBrdfParameters` of `brdfc-formats`. 144 bytes.
struct TableBrdfParameters {
    half_nodes: u32,                // columns, along θ_h: total + 1024 x first stored + 1048576 x number stored
    difference_nodes: u32,          // rows, along θ_d, likewise
    azimuth_nodes: u32,             // slices of a layer, along φ_d
    layers: u32,                    // along φ_h, 1: isotropic
    symmetry: u32,                  // 1 reciprocal, 2 mirror, 4 half turn, 8 reflected, 16 grey
    curve: u32,                     // nodes + 65536 x coarser levels in factored packs; else 0
    mean: f32,                      // μ, 1/sr
    bias: f32,                      // ε
    low: vec3<f32>,                 // ln(f / μ + ε) of a texel of 0
    slope: f32,                     // change of row density
    span: vec3<f32>,                // difference between a texel of 1 and one of 0
    reserved: f32,
    knots: array<vec4<f32>, 5>,     // fraction of columns below θ_h = (k / 16)² π/2, 17 of them
}

// Cropped packs store only some of the columns and rows.

@group(1) @binding(1) var<uniform> table_brdf_parameters: TableBrdfParameters;
// Texture of the KTX2 file.
@group(1) @binding(2) var table_brdf_texels: texture_3d<f32>;
// Linear filter, clamp to edge.
@group(1) @binding(3) var table_brdf_sampler: sampler;
// Curve of a factored pack, a row per level of detail; any texture without a curve.
@group(1) @binding(4) var table_brdf_curve: texture_2d<f32>;

const TABLE_BRDF_PI: f32 = 3.14159274;
const TABLE_BRDF_HALF_PI: f32 = 1.57079637;
const TABLE_BRDF_TAU: f32 = 6.28318548;
const TABLE_BRDF_LARGEST: f32 = 3.4028234e38;

// Half-difference angles of a pair, with θ_d as a fraction of the maximum for which both directions are above the
// horizon.
struct TableBrdfAngles {
    theta_half: f32,
    phi_half: f32,
    ratio: f32,
    phi_difference: f32,
}

// Position of a value in the texture, in nodes.
struct TableBrdfPosition {
    at: vec3<f32>,         // column, row, slice of a layer
    layers: vec2<u32>,     // on both sides of φ_h
    layer_weight: f32,     // weight of the second layer
}

// Logarithms ln(f / μ + ε) at the two levels around a level of detail.
struct TableBrdfLogValues {
    fine: vec3<f32>,       // at the requested level if it is whole, otherwise at the finer level
    coarse: vec3<f32>,     // at the coarser level
    coarse_weight: f32,    // weight of the coarser value
}

// f_r with the sampler's trilinear filter.
fn table_brdf(wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    return table_brdf_at(wi, wo, f32(table_brdf_levels()), true);
}

// f_r with manual weights.
fn table_brdf_exact(wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    return table_brdf_at(wi, wo, f32(table_brdf_levels()), false);
}

// f_r at a level of detail, 0 to table_brdf_levels(), the finest. The sampler filters if `hardware` is true.
fn table_brdf_at(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {
    if !(wi.z > 0.0 && wo.z > 0.0) {
        return vec3<f32>(0.0);
    }
    let values = table_brdf_log_values(wi, wo, level, hardware);
    let fine = table_brdf_from_log(values.fine);
    if values.coarse_weight > 0.0 {
        return fine + values.coarse_weight * (table_brdf_from_log(values.coarse) - fine);
    }
    return fine;
}

// Number of coarser levels of detail.
fn table_brdf_levels() -> u32 {
    return table_brdf_parameters.curve >> 16u;
}

// Level of detail at a distance from the viewer: far is coarse.
fn table_brdf_level_of_detail(distance: f32) -> f32 {
    let finest = f32(table_brdf_levels());
    return finest - clamp(log2(brdfc_frame.distance_scale * distance), 0.0, finest);
}

// f = μ (exp(v) - ε), clamped to 0 and to the largest number.
fn table_brdf_from_log(value: vec3<f32>) -> vec3<f32> {
    let f = table_brdf_parameters.mean * (exp(value) - table_brdf_parameters.bias);
    return select(vec3<f32>(0.0), min(f, vec3<f32>(TABLE_BRDF_LARGEST)), f > vec3<f32>(0.0));
}

// Both directions are above the horizon. Levels are blended by value, not by logarithm, to preserve energy.
fn table_brdf_log_values(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> TableBrdfLogValues {
    let angles = table_brdf_angles(wi, wo);
    let position = table_brdf_position(angles);
    var value = table_brdf_sample(position.at, position.layers.x, hardware);
    if table_brdf_parameters.layers > 1u {
        let upper = table_brdf_sample(position.at, position.layers.y, hardware);
        value = value + position.layer_weight * (upper - value);
    }
    let table = table_brdf_parameters.low + table_brdf_parameters.span * value;
    if table_brdf_parameters.curve == 0u {
        return TableBrdfLogValues(table, table, 0.0);
    }
    let levels = table_brdf_levels();
    let down = clamp(f32(levels) - level, 0.0, f32(levels));
    let row = u32(down);
    let coarse_weight = down - f32(row);
    let fine = table + table_brdf_along(angles.theta_half, row, hardware);
    if coarse_weight > 0.0 {
        let coarse = table + table_brdf_along(angles.theta_half, row + 1u, hardware);
        return TableBrdfLogValues(fine, coarse, coarse_weight);
    }
    return TableBrdfLogValues(fine, fine, 0.0);
}

// Row of the curve at θ_h. The finest level has the first row.
fn table_brdf_along(theta_half: f32, row: u32, hardware: bool) -> vec3<f32> {
    let nodes = table_brdf_parameters.curve & 0xffffu;
    let at = sqrt(min(theta_half / TABLE_BRDF_HALF_PI, 1.0)) * f32(nodes - 1u);
    if hardware {
        let texel = vec2<f32>((at + 0.5) / f32(nodes), (f32(row) + 0.5) / f32(table_brdf_levels() + 1u));
        return table_brdf_colour(textureSampleLevel(table_brdf_curve, table_brdf_sampler, texel, 0.0));
    }
    let lower = min(u32(at), nodes - 2u);
    let left = table_brdf_colour(textureLoad(table_brdf_curve, vec2<u32>(lower, row), 0));
    let right = table_brdf_colour(textureLoad(table_brdf_curve, vec2<u32>(lower + 1u, row), 0));
    return left + (at - f32(lower)) * (right - left);
}

// Texture value at a position in a layer.
fn table_brdf_sample(position: vec3<f32>, layer: u32, hardware: bool) -> vec3<f32> {
    let axes = vec2<u32>(table_brdf_parameters.half_nodes, table_brdf_parameters.difference_nodes);
    let size = vec3<u32>(axes >> vec2<u32>(20u), table_brdf_slices());
    // Positions outside the window of a cropped pack are clamped to it.
    let within = vec3<f32>(position.xy - vec2<f32>((axes >> vec2<u32>(10u)) & vec2<u32>(1023u)), position.z);
    let at = clamp(within, vec3<f32>(0.0), vec3<f32>(size - 1u));
    if hardware {
        let texel = vec3<f32>(at.xy, f32(layer * size.z) + at.z) + 0.5;
        let whole = vec3<f32>(vec2<f32>(size.xy), f32(table_brdf_parameters.layers * size.z));
        return table_brdf_colour(textureSampleLevel(table_brdf_texels, table_brdf_sampler, texel / whole, 0.0));
    }
    let lower = min(vec3<u32>(at), size - 2u);
    let weight = at - vec3<f32>(lower);
    let first = vec3<u32>(lower.xy, layer * size.z + lower.z);
    let near = table_brdf_slice(first, weight.xy);
    let far = table_brdf_slice(first + vec3<u32>(0u, 0u, 1u), weight.xy);
    return near + weight.z * (far - near);
}

// Bilinear filtering within a slice, columns first.
fn table_brdf_slice(first: vec3<u32>, weight: vec2<f32>) -> vec3<f32> {
    let upper = table_brdf_row(first, weight.x);
    let lower = table_brdf_row(first + vec3<u32>(0u, 1u, 0u), weight.x);
    return upper + weight.y * (lower - upper);
}

fn table_brdf_row(first: vec3<u32>, weight: f32) -> vec3<f32> {
    let left = table_brdf_colour(textureLoad(table_brdf_texels, first, 0));
    let right = table_brdf_colour(textureLoad(table_brdf_texels, first + vec3<u32>(1u, 0u, 0u), 0));
    return left + weight * (right - left);
}

// Grey packs have the same value in all channels.
fn table_brdf_colour(texel: vec4<f32>) -> vec3<f32> {
    return select(texel.rgb, texel.rrr, table_brdf_symmetric(16u));
}

// Columns or rows of an uncropped pack.
fn table_brdf_nodes(axis: u32) -> u32 {
    return axis & 1023u;
}

// Slices of a layer. If φ_d is periodic, a copy of the first slice follows the last.
fn table_brdf_slices() -> u32 {
    return table_brdf_parameters.azimuth_nodes + select(1u, 0u, table_brdf_symmetric(2u));
}

fn table_brdf_symmetric(flag: u32) -> bool {
    return (table_brdf_parameters.symmetry & flag) != 0u;
}

fn table_brdf_angles(i: vec3<f32>, o: vec3<f32>) -> TableBrdfAngles {
    let sum = i + o;
    let sum_length = table_brdf_length(sum);
    let h = sum / sum_length;
    let square = h.x * h.x + h.y * h.y;
    let sine = sqrt(square);
    let theta_half = table_brdf_atan2(sine, h.z);
    let theta_difference = table_brdf_atan2(table_brdf_length(i - o), sum_length);
    // Both times sin θ_h: away from the normal, and to its left. x is (i · h) h.z - i.z without the difference
    // of nearly equal numbers.
    var x = i.x;
    var y = i.y;
    if sine > 0.0 {
        x = h.z * (i.x * h.x + i.y * h.y) - i.z * square;
        y = i.y * h.x - i.x * h.y;
    }
    let across = sqrt(x * x + y * y);
    let cosine = select(1.0, abs(x) / across, across > 0.0);
    let largest = table_brdf_atan2(h.z, sine * cosine);
    let ratio = select(1.0, theta_difference / largest, theta_difference < largest);
    // Isotropic tables ignore φ_h.
    var phi_half = 0.0;
    if table_brdf_parameters.layers > 1u {
        phi_half = table_brdf_azimuth(h.y, h.x);
    }
    return TableBrdfAngles(theta_half, phi_half, ratio, table_brdf_azimuth(y, x));
}

fn table_brdf_position(angles: TableBrdfAngles) -> TableBrdfPosition {
    let folded = table_brdf_folded(angles);
    let mirror = table_brdf_symmetric(2u);
    let reflected = table_brdf_symmetric(8u);
    let slices = table_brdf_parameters.azimuth_nodes - select(0u, 1u, mirror);
    let column = table_brdf_column_share(angles.theta_half) * f32(table_brdf_nodes(table_brdf_parameters.half_nodes) - 1u);
    let bent = angles.ratio * (1.0 + table_brdf_parameters.slope * (1.0 - angles.ratio));
    let row = bent * f32(table_brdf_nodes(table_brdf_parameters.difference_nodes) - 1u);
    let at = vec3<f32>(column, row, folded.y * f32(slices));
    let layers = table_brdf_parameters.layers;
    if layers == 1u {
        return TableBrdfPosition(at, vec2<u32>(0u, 0u), 0.0);
    }
    let steps = layers - select(0u, 1u, reflected);
    let layer = folded.x * f32(steps);
    let lower = min(u32(layer), steps - 1u);
    return TableBrdfPosition(at, vec2<u32>(lower, (lower + 1u) % layers), layer - f32(lower));
}

// φ_h and φ_d as fractions of their periods, folded by the symmetry.
fn table_brdf_folded(angles: TableBrdfAngles) -> vec2<f32> {
    let reciprocal = table_brdf_symmetric(1u);
    let mirror = table_brdf_symmetric(2u);
    let half_turn = table_brdf_symmetric(4u);
    let reflected = table_brdf_symmetric(8u);
    var half_azimuth = angles.phi_half;
    var difference = angles.phi_difference;
    if reflected && half_turn {
        if half_azimuth < 0.0 {
            half_azimuth = half_azimuth + TABLE_BRDF_PI;
        }
        if half_azimuth > TABLE_BRDF_HALF_PI {
            half_azimuth = TABLE_BRDF_PI - half_azimuth;
            difference = -difference;
        }
    } else if reflected && half_azimuth < 0.0 {
        half_azimuth = -half_azimuth;
        difference = -difference;
    }
    if mirror {
        difference = abs(difference);
        if reciprocal && difference > TABLE_BRDF_HALF_PI {
            difference = TABLE_BRDF_PI - difference;
        }
    }
    let half_period = select(TABLE_BRDF_TAU, TABLE_BRDF_PI, reflected) / select(1.0, 2.0, half_turn);
    let difference_period = select(TABLE_BRDF_TAU, TABLE_BRDF_PI, mirror) / select(1.0, 2.0, reciprocal);
    let half_share = half_azimuth / half_period;
    let difference_share = difference / difference_period;
    return vec2<f32>(
        select(half_share - floor(half_share), min(half_share, 1.0), reflected),
        select(difference_share - floor(difference_share), min(difference_share, 1.0), mirror),
    );
}

// Fraction of columns below θ_h: linear between knots that are equally spaced in the square root of the angle.
fn table_brdf_column_share(theta_half: f32) -> f32 {
    let at = sqrt(min(theta_half / TABLE_BRDF_HALF_PI, 1.0)) * 16.0;
    let lower = min(u32(at), 15u);
    let knot = table_brdf_knot(lower);
    return knot + (at - f32(lower)) * (table_brdf_knot(lower + 1u) - knot);
}

fn table_brdf_knot(k: u32) -> f32 {
    return table_brdf_parameters.knots[k >> 2u][k & 3u];
}

fn table_brdf_length(v: vec3<f32>) -> f32 {
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

// atan2(y, x), in [-π, π].
fn table_brdf_azimuth(y: f32, x: f32) -> f32 {
    let angle = table_brdf_atan2(abs(y), x);
    return select(angle, -angle, y < 0.0);
}
