// How fast reflected light varies in a rendering: propagation of local bandwidth from a light to a pixel, and the
// sampling rates that follow.
//
// After Bagher, Soler, Subr, Belcour and Holzschuch 2012, "Interactive rendering of acquired materials on dynamic
// geometry using bandwidth prediction", sections 2.1 to 2.3; equation numbers below are theirs. Rules in words:
// `formats/src/bandwidth/propagation.md`; the same functions with the same steps in Rust: `bandwidth::propagation` of the crate `brdfc-formats`.
//
// To use it: paste this file before your own shader; it has no bindings. For each pixel, over a few incident
// directions:
//
//     let seen = bandwidth_one_bounce(light, light_distance, surface, image_distance);
//     average = bandwidth_average_add(average, seen, contribution);
//     variance = bandwidth_variance_add(variance, arriving, surface.lobe, contribution);
//
// and then
//
//     let b = pixel_bandwidth(bandwidth_average_mean(average).angular, field_of_view, size, largest_pixel_bandwidth(0u));
//     let level = bandwidth_pyramid_level(b, coarsest);
//     let samples = bandwidth_sample_count(bandwidth_variance_relative(variance, darkest), scale, fewest, most);
//
// Every number that goes in is finite and not negative; every number that comes out is, too.

// Cycles per metre or per radian: what stands for no limit, and the largest value that any operator gives.
const BANDWIDTH_UNLIMITED: f32 = 1e9;
// Cosines to the normal below this count as this.
const BANDWIDTH_SMALLEST_COSINE: f32 = 0.0009765625;
// How fast an albedo varies with the viewer's angle, cycles per radian.
const BANDWIDTH_ALBEDO: f32 = 0.5;
// Contributions and their means below this are black.
const BANDWIDTH_BLACK: f32 = 1e-18;
// Largest contribution, so that its square stays finite.
const BANDWIDTH_BRIGHTEST: f32 = 1e12;

struct Bandwidth {
    spatial: f32,  // cycles per metre, across the ray
    angular: f32,  // cycles per radian
}

struct BandwidthSurface {
    cos_incoming: f32,
    cos_outgoing: f32,
    curvature: f32,  // 1/m, without its sign
    lobe: f32,       // angular bandwidth of the material, cycles per radian
    texture: f32,    // bandwidth of the texture, cycles per metre
}

// Begin with zeros.
struct BandwidthAverage {
    weighted: Bandwidth,
    weight: f32,
}

// Begin with zeros.
struct BandwidthVariance {
    squares: f32,
    sum: f32,
    directions: f32,
}

// T_d: free flight over a distance in metres.
fn bandwidth_flight(v: Bandwidth, distance: f32) -> Bandwidth {
    return Bandwidth(v.spatial, bandwidth_limited(v.angular + distance * v.spatial));
}

// P_i: from across the ray to along the surface.
fn bandwidth_into_surface(v: Bandwidth, cos_incoming: f32) -> Bandwidth {
    return Bandwidth(bandwidth_limited(v.spatial * cos_incoming), v.angular);
}

// C_c, and C_-c without its sign.
fn bandwidth_curvature(v: Bandwidth, curvature: f32) -> Bandwidth {
    return Bandwidth(bandwidth_limited(v.spatial + curvature * v.angular), v.angular);
}

// B_t,ρ: the lobe limits, the texture adds.
fn bandwidth_reflection(v: Bandwidth, lobe: f32, texture: f32) -> Bandwidth {
    return Bandwidth(bandwidth_limited(v.spatial + texture), bandwidth_limited(min(v.angular, lobe)));
}

// P_o: from along the surface to across the ray.
fn bandwidth_out_of_surface(v: Bandwidth, cos_outgoing: f32) -> Bandwidth {
    let cosine = max(cos_outgoing, BANDWIDTH_SMALLEST_COSINE);
    return Bandwidth(bandwidth_limited(v.spatial / cosine), v.angular);
}

// R, equation 3.
fn bandwidth_reflected(v: Bandwidth, surface: BandwidthSurface) -> Bandwidth {
    var ray = bandwidth_into_surface(v, surface.cos_incoming);
    ray = bandwidth_curvature(ray, surface.curvature);
    ray = bandwidth_reflection(ray, surface.lobe, surface.texture);
    ray = bandwidth_curvature(ray, surface.curvature);
    return bandwidth_out_of_surface(ray, surface.cos_outgoing);
}

// Equation 4. Of light from far away the spatial bandwidth is 0; give 0 as its distance.
fn bandwidth_one_bounce(
    light: Bandwidth,
    light_distance: f32,
    surface: BandwidthSurface,
    image_distance: f32,
) -> Bandwidth {
    let arriving = bandwidth_flight(light, light_distance);
    return bandwidth_flight(bandwidth_reflected(arriving, surface), image_distance);
}

// What a surface shows in light that does not vary, at the image plane.
fn bandwidth_albedo(surface: BandwidthSurface, image_distance: f32) -> Bandwidth {
    let own = bandwidth_curvature(Bandwidth(0.0, min(surface.lobe, BANDWIDTH_ALBEDO)), surface.curvature);
    return bandwidth_flight(bandwidth_out_of_surface(own, surface.cos_outgoing), image_distance);
}

// Equation 5. The weight is the luminance of L ρ cos θi over the density that the direction was drawn with.
fn bandwidth_average_add(average: BandwidthAverage, v: Bandwidth, weight: f32) -> BandwidthAverage {
    let w = min(weight, BANDWIDTH_BRIGHTEST);
    let spatial = average.weighted.spatial + w * v.spatial;
    let angular = average.weighted.angular + w * v.angular;
    return BandwidthAverage(Bandwidth(spatial, angular), average.weight + w);
}

// With the directions of another part of the sum.
fn bandwidth_average_join(a: BandwidthAverage, b: BandwidthAverage) -> BandwidthAverage {
    let spatial = a.weighted.spatial + b.weighted.spatial;
    let angular = a.weighted.angular + b.weighted.angular;
    return BandwidthAverage(Bandwidth(spatial, angular), a.weight + b.weight);
}

fn bandwidth_average_mean(average: BandwidthAverage) -> Bandwidth {
    if average.weight < BANDWIDTH_BLACK {
        return Bandwidth(0.0, 0.0);
    }
    let spatial = bandwidth_limited(average.weighted.spatial / average.weight);
    let angular = bandwidth_limited(average.weighted.angular / average.weight);
    return Bandwidth(spatial, angular);
}

// Equation 6, cycles per pixel. Field of view in radians and size in pixels, across and down.
fn pixel_bandwidth(angular: f32, field_of_view: vec2<f32>, size: vec2<f32>, largest: f32) -> f32 {
    let pixel = max(field_of_view.x / size.x, field_of_view.y / size.y);
    return min(angular * pixel, largest);
}

// What pixels can show, with 4^levels samples per pixel.
fn largest_pixel_bandwidth(antialiasing_levels: u32) -> f32 {
    return 0.5 * f32(1u << min(antialiasing_levels, 16u));
}

// Equation 8, counted from the finest. -⌈log2 2b⌉ from the bits: log2 of a GPU may be off at powers of two.
fn bandwidth_pyramid_level(b: f32, coarsest: i32) -> i32 {
    let bits = bitcast<u32>(2.0 * b);
    let exponent = i32(bits >> 23u) - 127;
    let beyond = select(0, 1, (bits & 0x7fffffu) != 0u);
    return min(-(exponent + beyond), coarsest);
}

// Equation 7: angular bandwidths of the arriving light and of the lobe, and a contribution as in the average.
fn bandwidth_variance_add(v: BandwidthVariance, light: f32, lobe: f32, contribution: f32) -> BandwidthVariance {
    let x = min(contribution, BANDWIDTH_BRIGHTEST);
    let squares = v.squares + bandwidth_limited(light + lobe) * (x * x);
    return BandwidthVariance(squares, v.sum + x, v.directions + 1.0);
}

// A range of directions that one stands for: of each, L is proportional to the contribution. The means of L, of L² and of
// ν L² over the range.
fn bandwidth_variance_add_range(v: BandwidthVariance, l: f32, l2: f32, nu_l2: f32, lobe: f32) -> BandwidthVariance {
    return BandwidthVariance(v.squares + nu_l2 + bandwidth_limited(lobe) * l2, v.sum + l, v.directions + 1.0);
}

// With the directions of another part of the sum.
fn bandwidth_variance_join(a: BandwidthVariance, b: BandwidthVariance) -> BandwidthVariance {
    return BandwidthVariance(a.squares + b.squares, a.sum + b.sum, a.directions + b.directions);
}

// The mean contribution.
fn bandwidth_variance_mean(v: BandwidthVariance) -> f32 {
    return v.sum / max(v.directions, 1.0);
}

// Relative to the squared mean; `darkest` is the radiance below which errors count as at it.
fn bandwidth_variance_relative(v: BandwidthVariance, darkest: f32) -> f32 {
    let directions = max(v.directions, 1.0);
    let mean = max(bandwidth_variance_mean(v), darkest);
    if mean < BANDWIDTH_BLACK {
        return 0.0;
    }
    return bandwidth_limited(v.squares / directions / mean / mean);
}

// The factor that spends so many samples per shaded pixel.
fn bandwidth_sample_scale(mean_demand: f32, samples: f32) -> f32 {
    if mean_demand > 0.0 {
        return bandwidth_limited(samples / mean_demand);
    }
    return 0.0;
}

// Samples of a shaded pixel.
fn bandwidth_sample_count(demand: f32, scale: f32, fewest: u32, most: u32) -> u32 {
    let wanted = ceil(bandwidth_limited(scale * demand));
    return u32(min(max(wanted, f32(fewest)), f32(most)));
}

fn bandwidth_limited(value: f32) -> f32 {
    return min(value, BANDWIDTH_UNLIMITED);
}
