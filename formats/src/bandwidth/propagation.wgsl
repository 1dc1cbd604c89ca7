// Propagation of local bandwidth from a light to a pixel, and the sampling rates that follow.
//
// After Bagher, Soler, Subr, Belcour and Holzschuch 2012, "Interactive rendering of acquired materials on dynamic
// geometry using bandwidth prediction", sections 2.1 to 2.3; equations refer to that paper. Description:
// `formats/src/bandwidth/propagation.md`. The Rust module `bandwidth::propagation` of the crate `brdfc-formats` has the
// same functions with the same steps.
//
// Usage: prepend this file to your own shader; it has no bindings. For each pixel, over a few incident directions:
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
// All inputs must be finite and non-negative; all outputs are.

// Cycles per metre or per radian: unlimited bandwidth, and the maximum result of all operators.
const BANDWIDTH_UNLIMITED: f32 = 1e9;
// Minimum cosine to the normal.
const BANDWIDTH_SMALLEST_COSINE: f32 = 0.0009765625;
// Bandwidth of an albedo over the viewer's angle, cycles per radian.
const BANDWIDTH_ALBEDO: f32 = 0.5;
// Contributions and means below this count as black.
const BANDWIDTH_BLACK: f32 = 1e-18;
// Maximum contribution, whose square is finite.
const BANDWIDTH_BRIGHTEST: f32 = 1e12;

struct Bandwidth {
    spatial: f32,  // cycles per metre, across the ray
    angular: f32,  // cycles per radian
}

struct BandwidthSurface {
    cos_incoming: f32,
    cos_outgoing: f32,
    curvature: f32,  // 1/m, absolute value
    lobe: f32,       // angular bandwidth of the material, cycles per radian
    texture: f32,    // bandwidth of the texture, cycles per metre
}

// Initialise with zeros.
struct BandwidthAverage {
    weighted: Bandwidth,
    weight: f32,
}

// Initialise with zeros.
struct BandwidthVariance {
    squares: f32,
    sum: f32,
    directions: f32,
}

// T_d: free flight over a distance in metres.
fn bandwidth_flight(v: Bandwidth, distance: f32) -> Bandwidth {
    return Bandwidth(v.spatial, bandwidth_limited(v.angular + distance * v.spatial));
}

// P_i: projection from across the ray onto the surface.
fn bandwidth_into_surface(v: Bandwidth, cos_incoming: f32) -> Bandwidth {
    return Bandwidth(bandwidth_limited(v.spatial * cos_incoming), v.angular);
}

// C_c, and C_-c without its sign.
fn bandwidth_curvature(v: Bandwidth, curvature: f32) -> Bandwidth {
    return Bandwidth(bandwidth_limited(v.spatial + curvature * v.angular), v.angular);
}

// B_t,ρ: the lobe limits angular bandwidth, the texture adds spatial bandwidth.
fn bandwidth_reflection(v: Bandwidth, lobe: f32, texture: f32) -> Bandwidth {
    return Bandwidth(bandwidth_limited(v.spatial + texture), bandwidth_limited(min(v.angular, lobe)));
}

// P_o: projection from the surface to across the ray.
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

// Equation 4. For distant light the spatial bandwidth is 0; pass 0 as its distance.
fn bandwidth_one_bounce(
    light: Bandwidth,
    light_distance: f32,
    surface: BandwidthSurface,
    image_distance: f32,
) -> Bandwidth {
    let arriving = bandwidth_flight(light, light_distance);
    return bandwidth_flight(bandwidth_reflected(arriving, surface), image_distance);
}

// Bandwidth of a surface in constant light, at the image plane.
fn bandwidth_albedo(surface: BandwidthSurface, image_distance: f32) -> Bandwidth {
    let own = bandwidth_curvature(Bandwidth(0.0, min(surface.lobe, BANDWIDTH_ALBEDO)), surface.curvature);
    return bandwidth_flight(bandwidth_out_of_surface(own, surface.cos_outgoing), image_distance);
}

// Equation 5. The weight is the luminance of L ρ cos θi over the sampling density of the direction.
fn bandwidth_average_add(average: BandwidthAverage, v: Bandwidth, weight: f32) -> BandwidthAverage {
    let w = min(weight, BANDWIDTH_BRIGHTEST);
    let spatial = average.weighted.spatial + w * v.spatial;
    let angular = average.weighted.angular + w * v.angular;
    return BandwidthAverage(Bandwidth(spatial, angular), average.weight + w);
}

// Merges two partial sums.
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

// Equation 6, cycles per pixel. Field of view in radians and size in pixels, horizontal and vertical.
fn pixel_bandwidth(angular: f32, field_of_view: vec2<f32>, size: vec2<f32>, largest: f32) -> f32 {
    let pixel = max(field_of_view.x / size.x, field_of_view.y / size.y);
    return min(angular * pixel, largest);
}

// Maximum bandwidth that pixels resolve with 4^levels samples per pixel.
fn largest_pixel_bandwidth(antialiasing_levels: u32) -> f32 {
    return 0.5 * f32(1u << min(antialiasing_levels, 16u));
}

// Equation 8, counted from the finest. -⌈log2 2b⌉ from the bits, because log2 of a GPU may be inexact at powers of two.
fn bandwidth_pyramid_level(b: f32, coarsest: i32) -> i32 {
    let bits = bitcast<u32>(2.0 * b);
    let exponent = i32(bits >> 23u) - 127;
    let beyond = select(0, 1, (bits & 0x7fffffu) != 0u);
    return min(-(exponent + beyond), coarsest);
}

// Equation 7: angular bandwidths of the incoming light and of the lobe, and a contribution as in the average.
fn bandwidth_variance_add(v: BandwidthVariance, light: f32, lobe: f32, contribution: f32) -> BandwidthVariance {
    let x = min(contribution, BANDWIDTH_BRIGHTEST);
    let squares = v.squares + bandwidth_limited(light + lobe) * (x * x);
    return BandwidthVariance(squares, v.sum + x, v.directions + 1.0);
}

// A range of directions represented by one, with L proportional to the contribution of each: the means of L, of L² and
// of ν L² over the range.
fn bandwidth_variance_add_range(v: BandwidthVariance, l: f32, l2: f32, nu_l2: f32, lobe: f32) -> BandwidthVariance {
    return BandwidthVariance(v.squares + nu_l2 + bandwidth_limited(lobe) * l2, v.sum + l, v.directions + 1.0);
}

// Merges two partial sums.
fn bandwidth_variance_join(a: BandwidthVariance, b: BandwidthVariance) -> BandwidthVariance {
    return BandwidthVariance(a.squares + b.squares, a.sum + b.sum, a.directions + b.directions);
}

// Mean contribution.
fn bandwidth_variance_mean(v: BandwidthVariance) -> f32 {
    return v.sum / max(v.directions, 1.0);
}

// Relative to the squared mean; below the radiance `darkest` errors are absolute.
fn bandwidth_variance_relative(v: BandwidthVariance, darkest: f32) -> f32 {
    let directions = max(v.directions, 1.0);
    let mean = max(bandwidth_variance_mean(v), darkest);
    if mean < BANDWIDTH_BLACK {
        return 0.0;
    }
    return bandwidth_limited(v.squares / directions / mean / mean);
}

// Factor for an average of `samples` per shaded pixel.
fn bandwidth_sample_scale(mean_demand: f32, samples: f32) -> f32 {
    if mean_demand > 0.0 {
        return bandwidth_limited(samples / mean_demand);
    }
    return 0.0;
}

// Samples of a shaded pixel.
fn bandwidth_sample_count(demand: f32, scale: f32, fewest: u32, most: u32) -> u32 {
    let count = ceil(bandwidth_limited(scale * demand));
    return u32(min(max(count, f32(fewest)), f32(most)));
}

fn bandwidth_limited(value: f32) -> f32 {
    return min(value, BANDWIDTH_UNLIMITED);
}
