//! The shader of bandwidth propagation, compared with its CPU twin on any adapter.

use brdfc_formats::bandwidth::propagation::{
    Bandwidth, BandwidthAverage, BandwidthSurface, DirectedLight, PROPAGATION_WGSL, VarianceEstimate,
    largest_pixel_bandwidth, pixel_bandwidth, pyramid_level, sample_count, sample_scale,
};
use brdfc_formats::bindings::FrameBlock;
use brdfc_gpu::Gpu;
use brdfc_probe::Compute;
use brdfc_testing::packs::Numbers;

/// Numbers of input and output for a pixel with two incident directions.
const IN: usize = 26;
const OUT: usize = 13;
/// Index in the output of the variance of two joined sums.
const JOINED: usize = 12;

const ENTRY: &str = "
fn surface(first: u32) -> BandwidthSurface {
    return BandwidthSurface(input[first], input[first + 1u], input[first + 2u], input[first + 3u], input[first + 4u]);
}

fn compute(at: u32) {
    let first = at * 26u;
    var average = BandwidthAverage(Bandwidth(0.0, 0.0), 0.0);
    var variance = BandwidthVariance(0.0, 0.0, 0.0);
    var average_of_first = average;
    var variance_of_first = variance;
    for (var k = 0u; k < 2u; k += 1u) {
        let f = first + 9u * k;
        let light = Bandwidth(input[f], input[f + 1u]);
        let seen = bandwidth_one_bounce(light, input[f + 2u], surface(f + 3u), input[first + 18u]);
        average = bandwidth_average_add(average, seen, input[f + 8u]);
        average = bandwidth_average_add(average, bandwidth_albedo(surface(f + 3u), input[first + 18u]), input[f + 2u]);
        variance = bandwidth_variance_add(variance, light.angular, input[f + 6u], input[f + 8u]);
        if k == 0u {
            average_of_first = average;
            variance_of_first =
                bandwidth_variance_add_range(variance, input[f + 8u], input[f + 5u], input[f + 1u], input[f + 6u]);
        }
        output[at * 13u + 2u * k] = seen.spatial;
        output[at * 13u + 2u * k + 1u] = seen.angular;
    }
    average = bandwidth_average_join(average, average_of_first);
    let joined = bandwidth_variance_join(variance, variance_of_first);
    let mean = bandwidth_average_mean(average);
    let field = vec2<f32>(input[first + 19u], input[first + 20u]);
    let size = vec2<f32>(input[first + 21u], input[first + 22u]);
    let antialiasing = u32(input[first + 23u]);
    let b = pixel_bandwidth(mean.angular, field, size, largest_pixel_bandwidth(antialiasing));
    let relative = bandwidth_variance_relative(variance, input[first + 24u]);
    let scale = bandwidth_sample_scale(input[first + 25u], 32.0);
    output[at * 13u + 4u] = mean.spatial;
    output[at * 13u + 5u] = mean.angular;
    output[at * 13u + 6u] = b;
    output[at * 13u + 7u] = f32(bandwidth_pyramid_level(b, 9));
    output[at * 13u + 8u] = relative;
    output[at * 13u + 9u] = scale;
    output[at * 13u + 10u] = f32(bandwidth_sample_count(relative, scale, 4u, 256u));
    output[at * 13u + 12u] = bandwidth_variance_relative(joined, input[first + 24u]);
    output[at * 13u + 11u] = f32(bandwidth_pyramid_level(input[first + 25u], 9));
}
";

fn surface(words: &[f32]) -> BandwidthSurface {
    BandwidthSurface {
        cos_incoming: words[0],
        cos_outgoing: words[1],
        curvature: words[2],
        lobe: words[3],
        texture: words[4],
    }
}

fn expected(words: &[f32]) -> [f32; OUT] {
    let mut average = BandwidthAverage::default();
    let mut variance = VarianceEstimate::default();
    let mut of_first = (average, variance);
    let mut out = [0.0; OUT];
    for k in 0..2 {
        let f = &words[9 * k..];
        let light = Bandwidth { spatial: f[0], angular: f[1] };
        let seen = light.one_bounce(f[2], surface(&f[3..8]), words[18]);
        average = average.add(seen, f[8]);
        average = average.add(surface(&f[3..8]).albedo(words[18]), f[2]);
        variance = variance.add(light.angular, f[6], f[8]);
        if k == 0 {
            let range = DirectedLight { radiance: f[8], bandwidth: 0.0, squares: f[5], varying: f[1] };
            of_first = (average, variance.add_range(range, f[6]));
        }
        out[2 * k] = seen.spatial;
        out[2 * k + 1] = seen.angular;
    }
    average = average.join(of_first.0);
    let joined = variance.join(of_first.1).relative(words[24]);
    let mean = average.mean();
    let largest = largest_pixel_bandwidth(words[23] as u32);
    let b = pixel_bandwidth(mean.angular, [words[19], words[20]], [words[21], words[22]], largest);
    let (relative, scale) = (variance.relative(words[24]), sample_scale(words[25], 32.0));
    let count = sample_count(relative, scale, 4, 256) as f32;
    let last = [b, pyramid_level(b, 9) as f32, relative, scale, count, pyramid_level(words[25], 9) as f32, joined];
    out[4..6].copy_from_slice(&[mean.spatial, mean.angular]);
    out[6..].copy_from_slice(&last);
    out
}

/// Pixels of every kind: sizes over many powers of two, zeros, the largest values, powers of two for the levels.
fn inputs(count: usize, seed: u64) -> Vec<f32> {
    let mut numbers = Numbers::new(seed);
    let mut all = Vec::with_capacity(IN * count);
    for _ in 0..count {
        let mut any = |low: f64, high: f64, zero: bool| match numbers.bits() % 16 {
            0 if zero => 0.0,
            1 => high.exp2() as f32,
            _ => numbers.between(low, high).exp2() as f32,
        };
        for _ in 0..2 {
            all.extend([any(-6.0, 8.0, true), any(-4.0, 30.0, true), any(-4.0, 6.0, true)]);
            all.extend([any(-3.0, 0.0, true), any(-12.0, 0.0, true), any(-6.0, 8.0, true)]);
            all.extend([any(-4.0, 20.0, true), any(-6.0, 30.0, true), any(-20.0, 44.0, true)]);
        }
        // Half of them are seen from close by, so that not all pixels are at the limit.
        all.push(any(-8.0, 4.0, true) * (numbers.bits() % 2) as f32);
        let mut any = |low: f64, high: f64| numbers.between(low, high).exp2() as f32;
        all.extend([any(-12.0, 1.0), any(-12.0, 1.0), any(4.0, 11.0).ceil(), any(4.0, 11.0).ceil()]);
        all.extend([(numbers.bits() % 4) as f32, (numbers.bits() % 2) as f32 * 0.25]);
        all.push(match numbers.bits() % 4 {
            0 => ((numbers.bits() % 16) as f32 - 12.0).exp2(),
            1 => f32::from_bits(((numbers.bits() % 16) as f32 - 12.0).exp2().to_bits() + 1),
            2 => 0.0,
            _ => numbers.between(-14.0, 4.0).exp2() as f32,
        });
    }
    all
}

/// Number of values whose bits differ, per kind.
fn differences(gpu: &Gpu, source: &str, inputs: &[f32]) -> [usize; OUT] {
    let compute = Compute::new(gpu, &format!("{source}\n{ENTRY}"), &[], FrameBlock::default()).unwrap();
    let found = compute.run(inputs, IN, OUT).unwrap();
    let mut counts = [0; OUT];
    for (words, found) in inputs.chunks_exact(IN).zip(found.chunks_exact(OUT)) {
        for (at, (count, (a, b))) in counts.iter_mut().zip(expected(words).iter().zip(found)).enumerate() {
            // A driver may join sums in another order.
            let allowed = if at == JOINED { 4 } else { 0 };
            *count += usize::from(a.to_bits().abs_diff(b.to_bits()) > allowed);
        }
    }
    counts
}

#[test]
fn the_shader_gives_the_bits_of_the_cpu() {
    let Some(gpu) = crate::common::gpu() else { return };
    let inputs = inputs(20_000, 1);
    assert_eq!(differences(gpu, PROPAGATION_WGSL, &inputs), [0; OUT]);
    // The inputs cover all kinds.
    let answers: Vec<_> = inputs.chunks_exact(IN).map(expected).collect();
    for level in -3..=9 {
        assert!(answers.iter().any(|a| a[7] == level as f32), "level {level}");
    }
    let between = answers.iter().filter(|a| a[10] > 4.0 && a[10] < 256.0).count();
    assert!(between > 300, "{between}");
    assert!(answers.iter().flatten().all(|number| number.is_finite()));
}

/// Lines of the shader and small changes of them, each of which the inputs must detect.
const CHANGES: [(&str, &str); 46] = [
    ("BANDWIDTH_UNLIMITED: f32 = 1e9", "BANDWIDTH_UNLIMITED: f32 = 1.001e9"),
    ("BANDWIDTH_SMALLEST_COSINE: f32 = 0.0009765625", "BANDWIDTH_SMALLEST_COSINE: f32 = 0.00098"),
    ("BANDWIDTH_BLACK: f32 = 1e-18", "BANDWIDTH_BLACK: f32 = 1e-3"),
    ("BANDWIDTH_BRIGHTEST: f32 = 1e12", "BANDWIDTH_BRIGHTEST: f32 = 2e12"),
    ("v.angular + distance * v.spatial", "v.angular - distance * v.spatial"),
    ("v.spatial * cos_incoming", "v.spatial"),
    ("v.spatial + curvature * v.angular", "v.spatial + v.angular"),
    ("v.spatial + texture", "v.spatial"),
    ("min(v.angular, lobe)", "max(v.angular, lobe)"),
    ("max(cos_outgoing, BANDWIDTH_SMALLEST_COSINE)", "cos_outgoing + BANDWIDTH_SMALLEST_COSINE"),
    ("v.spatial / cosine", "v.spatial * cosine"),
    ("bandwidth_into_surface(v, surface.cos_incoming)", "bandwidth_into_surface(v, surface.cos_outgoing)"),
    ("surface.lobe, surface.texture)", "surface.texture, surface.lobe)"),
    ("bandwidth_out_of_surface(ray, surface.cos_outgoing)", "bandwidth_out_of_surface(ray, surface.cos_incoming)"),
    ("bandwidth_flight(light, light_distance)", "light"),
    (
        "bandwidth_flight(bandwidth_reflected(arriving, surface), image_distance)",
        "bandwidth_reflected(arriving, surface)",
    ),
    ("min(weight, BANDWIDTH_BRIGHTEST)", "weight"),
    ("average.weighted.spatial + w * v.spatial", "max(average.weighted.spatial, w * v.spatial)"),
    ("average.weighted.angular + w * v.angular", "max(average.weighted.angular, w * v.angular)"),
    ("average.weight + w)", "average.weight + 1.0)"),
    ("average.weighted.spatial / average.weight", "average.weighted.spatial"),
    ("average.weighted.angular / average.weight", "average.weighted.angular"),
    ("max(field_of_view.x / size.x, field_of_view.y / size.y)", "field_of_view.x / size.x"),
    ("min(angular * pixel, largest)", "angular * pixel"),
    ("0.5 * f32(1u", "f32(1u"),
    ("bitcast<u32>(2.0 * b)", "bitcast<u32>(b)"),
    ("select(0, 1, (bits & 0x7fffffu) != 0u)", "1"),
    ("min(-(exponent + beyond), coarsest)", "-(exponent + beyond)"),
    ("bandwidth_limited(light + lobe) * (x * x)", "bandwidth_limited(light + lobe) * x"),
    ("v.sum + x, v.directions + 1.0", "v.sum, v.directions + 1.0"),
    ("max(bandwidth_variance_mean(v), darkest)", "bandwidth_variance_mean(v)"),
    ("v.sum / max(v.directions, 1.0)", "v.sum / max(v.directions, 5.0)"),
    ("nu_l2 + bandwidth_limited(lobe) * l2", "nu_l2 + l2"),
    ("min(surface.lobe, BANDWIDTH_ALBEDO)", "surface.lobe"),
    ("BANDWIDTH_ALBEDO: f32 = 0.5", "BANDWIDTH_ALBEDO: f32 = 0.25"),
    ("out_of_surface(own, surface.cos_outgoing)", "out_of_surface(own, surface.cos_incoming)"),
    ("v.sum + l,", "v.sum,"),
    ("a.squares + b.squares", "a.squares"),
    ("a.sum + b.sum", "a.sum"),
    ("a.directions + b.directions", "a.directions"),
    ("a.weighted.spatial + b.weighted.spatial", "a.weighted.spatial"),
    ("a.weighted.angular + b.weighted.angular", "a.weighted.angular"),
    ("a.weight + b.weight", "a.weight"),
    ("v.squares / directions / mean / mean", "v.squares / directions / mean"),
    ("bandwidth_limited(samples / mean_demand)", "samples * mean_demand"),
    ("ceil(bandwidth_limited(scale * demand))", "floor(bandwidth_limited(scale * demand))"),
];

/// The negative control: every change above is detected, and changes exactly one place.
#[test]
fn a_changed_line_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let inputs = inputs(5000, 2);
    for (from, to) in CHANGES {
        assert_eq!(PROPAGATION_WGSL.matches(from).count(), 1, "{from}");
        let found = differences(gpu, &PROPAGATION_WGSL.replace(from, to), &inputs);
        assert!(found != [0; OUT], "{from} -> {to}");
    }
}
