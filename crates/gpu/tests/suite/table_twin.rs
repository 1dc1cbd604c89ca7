//! The shipped shader of table packs, compared with the CPU decoder on any adapter.

use brdfc_formats::BrdfPack;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::shader::TABLE_BRDF_WGSL;
use brdfc_formats::table::{LogValues, TableDecoder, TablePack};
use brdfc_formats::wavelet::Filter;
use brdfc_gpu::{Gpu, SliceFilter};
use brdfc_probe::{EVALUATE_TABLE_WGSL, Evaluated, Evaluator};
use brdfc_testing::codecs::table::tables;
use brdfc_testing::packs::pairs;

/// Range of the curves of the tested packs, between -1 and 2.
const CURVE_RANGE: f32 = 3.0;

/// Random pairs, pairs below the horizon, and pairs where angles are 0 or at their largest.
fn all_kinds_of_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut all = pairs(count, seed);
    let below = DirectionPair::new([0.6, 0.0, -0.8], all[0].outgoing);
    all.extend([below, below.exchanged(), DirectionPair::new([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])]);
    all.extend([DirectionPair::new([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), DirectionPair::from_angles(1.57, 0.0, 0.3, 3.1)]);
    // The half vector at the normal, and on the tangent and the bitangent.
    for phi in [0.0, 0.5, 1.5, 3.0] {
        let [x, y] = [0.6 * f64::cos(phi), 0.6 * f64::sin(phi)];
        all.push(DirectionPair::new([x, y, 0.8], [-x, -y, 0.8]));
        all.push(DirectionPair::new([x, 0.0, (1.0 - x * x).sqrt()], [0.6, 0.0, 0.8]));
        all.push(DirectionPair::new([0.0, y, (1.0 - y * y).sqrt()], [0.0, -0.6, 0.8]));
    }
    all
}

/// Tables at their finest level of detail, and tables with more levels at some of these, and beyond.
fn with_levels() -> Vec<(String, TablePack, f32)> {
    let levels = |pack: &TablePack| if pack.levels() == 0 { vec![0.0] } else { vec![3.0, 1.4, 0.0, 2.0, 4.0] };
    let at = |(name, pack): (String, TablePack)| {
        levels(&pack).into_iter().map(move |level| (format!("{name}, level {level}"), pack.clone(), level))
    };
    tables().into_iter().flat_map(at).collect()
}

/// Logarithms of the evaluation, interpolated between both sides of a level.
fn log_value(decoder: &TableDecoder, pair: DirectionPair, level: f32) -> [f32; 3] {
    let LogValues { fine, coarse, coarse_weight } = decoder.log_values(pair, level);
    std::array::from_fn(|k| fine[k] + coarse_weight * (coarse[k] - fine[k]))
}

fn evaluate(gpu: &Gpu, pack: &TablePack, pairs: &[DirectionPair], level: f32, filter: SliceFilter) -> Vec<Evaluated> {
    let evaluator = Evaluator::of_tables(gpu).unwrap();
    let loaded = evaluator.load(&BrdfPack::Table(pack.clone()), Filter::Bilinear).unwrap();
    evaluator.eval(&loaded, pairs, level, filter).unwrap()
}

#[test]
fn manual_filtering_gives_the_bits_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pairs = all_kinds_of_pairs(1500, 5);
    for (name, pack, level) in with_levels() {
        let decoder = TableDecoder::new(&pack);
        let found = evaluate(gpu, &pack, &pairs, level, SliceFilter::Exact);
        for (pair, found) in pairs.iter().zip(&found) {
            let above = pair.is_above_horizon();
            let expected = if above { log_value(&decoder, *pair, level) } else { [0.0; 3] };
            assert_eq!(expected.map(f32::to_bits), found.log_value.map(f32::to_bits), "{name}, {pair:?}");
            let f_r = decoder.eval_at(*pair, level);
            for channel in 0..3 {
                // The exponential and the two operations after it: see `shader_twin`.
                let v = f64::from(expected[channel]);
                let bound = 0.25 * (v.exp() + 1e-4) * (5.0 + 2.0 * v.abs()) * 2f64.powi(-23);
                let difference = (f64::from(f_r[channel]) - f64::from(found.f_r[channel])).abs();
                assert!(difference <= if above { bound } else { 0.0 }, "{name}, {pair:?}: {f_r:?} {found:?}");
            }
        }
    }
}

/// Error of the texture unit: at most 1/128 of a texel's range. The format has 10 bits or half floats.
#[test]
fn hardware_filtering_is_within_its_precision() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pairs = all_kinds_of_pairs(2000, 6);
    let mut largest = 0.0f32;
    for (name, pack, level) in with_levels() {
        let decoder = TableDecoder::new(&pack);
        let found = evaluate(gpu, &pack, &pairs, level, SliceFilter::Hardware);
        for (pair, found) in pairs.iter().zip(&found).filter(|(pair, _)| pair.is_above_horizon()) {
            let expected = log_value(&decoder, *pair, level);
            for channel in 0..3 {
                let curve = if pack.curve().is_some() { CURVE_RANGE } else { 0.0 };
                let range = pack.header().span[channel] + curve;
                let share = (found.log_value[channel] - expected[channel]).abs() / range;
                largest = largest.max(share);
                assert!(share < 1.0 / 128.0, "{name}, {pair:?}: off by {share} of the range");
            }
        }
    }
    println!("hardware filtering is off by {largest} of a texel's range");
}

/// Changes of lines of the shader that the test must detect.
#[test]
fn changed_shaders_are_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pairs = all_kinds_of_pairs(300, 7);
    let changes = [
        ("let first = vec3<u32>(lower.xy, layer * size.z + lower.z);", "let first = vec3<u32>(lower.xy, lower.z);"),
        ("return left + weight * (right - left);", "return left;"),
        ("return upper + weight.y * (lower - upper);", "return upper;"),
        ("return near + weight.z * (far - near);", "return near;"),
        ("value = value + position.layer_weight * (upper - value);", ""),
        ("select(texel.rgb, texel.rrr, table_brdf_symmetric(16u))", "texel.rgb"),
        ("select(1u, 0u, table_brdf_symmetric(2u))", "0u"),
        ("- i.z * square;", "+ i.z * square;"),
        ("y = i.y * h.x - i.x * h.y;", "y = i.x * h.y - i.y * h.x;"),
        ("let largest = table_brdf_atan2(h.z, sine * cosine);", "let largest = table_brdf_atan2(h.z, sine);"),
        ("table_brdf_parameters.slope * (1.0 - angles.ratio)", "0.0"),
        ("(lower + 1u) % layers", "lower"),
        ("half_azimuth = half_azimuth + TABLE_BRDF_PI;", ""),
        ("difference = -difference;\n        }", "}"),
        ("half_azimuth = -half_azimuth;", ""),
        ("difference = abs(difference);", ""),
        ("difference = TABLE_BRDF_PI - difference;", ""),
        ("select(TABLE_BRDF_TAU, TABLE_BRDF_PI, reflected)", "TABLE_BRDF_PI"),
        ("select(TABLE_BRDF_TAU, TABLE_BRDF_PI, mirror)", "TABLE_BRDF_PI"),
        ("select(half_share - floor(half_share), min(half_share, 1.0), reflected)", "half_share - floor(half_share)"),
        ("sqrt(min(theta_half / TABLE_BRDF_HALF_PI, 1.0)) * 16.0", "min(theta_half / TABLE_BRDF_HALF_PI, 1.0) * 16.0"),
        ("[k & 3u]", "[0]"),
        ("vec2<f32>((axes >> vec2<u32>(10u)) & vec2<u32>(1023u))", "vec2<f32>(0.0)"),
        ("let at = clamp(within, vec3<f32>(0.0), vec3<f32>(size - 1u));", "let at = within;"),
        ("axes >> vec2<u32>(20u)", "axes & vec2<u32>(1023u)"),
        ("select(angle, -angle, y < 0.0)", "angle"),
        ("let at = sqrt(min(theta_half / TABLE_BRDF_HALF_PI, 1.0)) * f32(nodes - 1u);", "let at = 0.5;"),
        ("return left + (at - f32(lower)) * (right - left);", "return left;"),
        ("let coarse_weight = down - f32(row);", "let coarse_weight = 0.0;"),
        ("let down = clamp(f32(levels) - level, 0.0, f32(levels));", "let down = clamp(level, 0.0, f32(levels));"),
        (
            "table_brdf_along(angles.theta_half, row + 1u, hardware)",
            "table_brdf_along(angles.theta_half, row, hardware)",
        ),
    ];
    for (line, change) in changes {
        assert_eq!(TABLE_BRDF_WGSL.matches(line).count(), 1, "{line}");
        let changed = TABLE_BRDF_WGSL.replace(line, change);
        let evaluator = Evaluator::with_shaders(gpu, &changed, EVALUATE_TABLE_WGSL).unwrap();
        let noticed = with_levels().into_iter().any(|(_, pack, level)| {
            let decoder = TableDecoder::new(&pack);
            let loaded = evaluator.load(&BrdfPack::Table(pack.clone()), Filter::Bilinear).unwrap();
            let found = evaluator.eval(&loaded, &pairs, level, SliceFilter::Exact).unwrap();
            let differs = |(pair, found): (&DirectionPair, &Evaluated)| {
                pair.is_above_horizon() && log_value(&decoder, *pair, level) != found.log_value
            };
            pairs.iter().zip(&found).any(differs)
        });
        assert!(noticed, "{line}");
    }
}
