//! The shipped shader, compared with the CPU decoder on any adapter.

use brdfc_formats::BrdfPack;
use brdfc_formats::crop::{Crop, DirectionRange, Window};
use brdfc_formats::direction::{DirectionPair, Parameterisation};
use brdfc_formats::wavelet::shader::{FILTER_PRECISION_8_BIT, FILTER_PRECISION_16_BIT, WAVELET_BRDF_WGSL};
use brdfc_formats::wavelet::{
    DEFAULT_DISTANCE_SCALE, Filter, SliceScale, WaveletDecoder, WaveletPack, level_of_detail,
};
use brdfc_gpu::SliceFilter;
use brdfc_probe::{EVALUATE_WGSL, Evaluated, Evaluator};
use brdfc_testing::codecs::wavelet::{energy_preserving, header, pack, packs};
use brdfc_testing::packs::pairs;
use std::ops::Range;

const FILTERS: [Filter; 3] = [Filter::Nearest, Filter::Slices, Filter::Bilinear];

fn wavelet(pack: &WaveletPack) -> BrdfPack {
    BrdfPack::Wavelet(pack.clone())
}

/// Random pairs, pairs below the horizon, and pairs at the borders of cells.
fn all_kinds_of_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut all = pairs(count, seed);
    let z = |v: [f64; 3], z: f64| [v[0], v[1], z];
    let below = DirectionPair::new(z(all[0].incoming, -0.1), all[0].outgoing);
    all.extend([below, below.exchanged(), DirectionPair::new([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])]);
    all.extend([DirectionPair::new([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), DirectionPair::from_angles(1.57, 0.0, 0.3, 3.1)]);
    all
}

/// The bound on `f_r` after equal log values: WGSL requires `exp` to be within `3 + 2 |v|` units in the last place;
/// product and difference add one each. In 1/sr.
fn exponential_bound(pack: &WaveletPack, log_value: f32) -> f64 {
    let v = f64::from(log_value);
    f64::from(pack.header.mean) * (v.exp() + f64::from(pack.header.bias)) * (5.0 + 2.0 * v.abs()) * 2f64.powi(-23)
}

/// The bound on the log value with hardware filtering: every coefficient of a path may be off by the filter's precision
/// of its range.
fn filter_bound(pack: &WaveletPack) -> f64 {
    let n = pack.header.levels;
    let precision = f64::from(if pack.header.bits == 8 { FILTER_PRECISION_8_BIT } else { FILTER_PRECISION_16_BIT });
    let range = |coefficients: std::ops::Range<usize>| {
        let scales = coefficients.map(|k| f64::from(pack.scales[usize::from(pack.index[k])].scale));
        scales.fold(0.0, f64::max)
    };
    let mut bound = range(0..1) / f64::from(1 << n);
    for j in 0..n {
        let first = 1usize << (2 * j);
        bound += (range(first..2 * first) + 2f64.sqrt() * range(2 * first..4 * first)) / f64::from(1 << (n - j));
    }
    // Additional rounding of sums.
    precision * bound + 2e-5
}

struct Differences {
    /// Number of log values whose bits differ.
    bits: usize,
    /// Number of values of `f_r` beyond the bound of the exponential.
    values: usize,
}

fn exact_differences(
    decoder: &WaveletDecoder,
    pack: &WaveletPack,
    pairs: &[DirectionPair],
    level: f32,
    filter: Filter,
    found: &[Evaluated],
) -> Differences {
    let mut differences = Differences { bits: 0, values: 0 };
    for (pair, found) in pairs.iter().zip(found) {
        let above = pair.is_above_horizon();
        let log_value = if above { decoder.log_value(*pair, level, filter) } else { [0.0; 3] };
        let f_r = decoder.eval(*pair, level, filter);
        for channel in 0..3 {
            differences.bits += usize::from(log_value[channel].to_bits() != found.log_value[channel].to_bits());
            if f_r[channel] == f32::MAX {
                differences.values += usize::from(found.f_r[channel] != f32::MAX);
                continue;
            }
            let difference = (f64::from(f_r[channel]) - f64::from(found.f_r[channel])).abs();
            let bound = if above { exponential_bound(pack, log_value[channel]) } else { 0.0 };
            differences.values += usize::from(difference > bound || difference.is_nan());
        }
    }
    differences
}

#[test]
fn manual_filtering_gives_the_bits_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = Evaluator::new(gpu).unwrap();
    let pairs = all_kinds_of_pairs(700, 3);
    let mut compared = 0;
    for (name, pack) in
        packs().into_iter().filter(|(name, _)| name.starts_with("energy-")).chain(packs().into_iter().step_by(5))
    {
        let decoder = WaveletDecoder::new(&pack);
        let finest = pack.header.levels as f32;
        for filter in FILTERS {
            let loaded = evaluator.load(&wavelet(&pack), filter).unwrap();
            for level in [0.0, 0.37, finest - 0.5, finest, finest + 3.0] {
                let found = evaluator.eval(&loaded, &pairs, level, SliceFilter::Exact).unwrap();
                assert_eq!(found.len(), pairs.len());
                let differences = exact_differences(&decoder, &pack, &pairs, level, filter, &found);
                assert_eq!(differences.bits, 0, "{name}, {filter:?}, level {level}: bits of the log value");
                assert_eq!(differences.values, 0, "{name}, {filter:?}, level {level}: f_r");
                compared += found.len();
            }
        }
    }
    assert!(compared > 100_000, "{compared}");
}

#[test]
fn extreme_scales_are_clamped_as_on_the_cpu() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = Evaluator::new(gpu).unwrap();
    let mut pack = pack(header(Parameterisation::TangentPole, 2, 3, 8), 4, 1);
    pack.scales[1] = SliceScale { scale: 2000.0, offset: -800.0 };
    let decoder = WaveletDecoder::new(&pack);
    let loaded = evaluator.load(&wavelet(&pack), Filter::Nearest).unwrap();
    let pairs = pairs(500, 9);
    let found = evaluator.eval(&loaded, &pairs, 2.0, SliceFilter::Exact).unwrap();
    let mut seen = [0; 2];
    for (pair, found) in pairs.iter().zip(&found) {
        let expected = decoder.eval(*pair, 2.0, Filter::Nearest);
        for channel in 0..3 {
            if expected[channel] == f32::MAX || expected[channel] == 0.0 {
                assert_eq!(found.f_r[channel], expected[channel]);
                seen[usize::from(expected[channel] == 0.0)] += 1;
            }
        }
    }
    assert!(seen.iter().all(|count| *count > 20), "{seen:?}");
}

#[test]
fn hardware_filtering_is_within_its_precision() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = Evaluator::new(gpu).unwrap();
    let pairs = all_kinds_of_pairs(2000, 4);
    for (name, pack) in
        packs().into_iter().filter(|(name, _)| name.starts_with("energy-")).chain(packs().into_iter().step_by(5))
    {
        let decoder = WaveletDecoder::new(&pack);
        let bound = filter_bound(&pack);
        for filter in [Filter::Slices, Filter::Bilinear] {
            let loaded = evaluator.load(&wavelet(&pack), filter).unwrap();
            let level = pack.header.levels as f32;
            let found = evaluator.eval(&loaded, &pairs, level, SliceFilter::Hardware).unwrap();
            for (pair, found) in pairs.iter().zip(&found).filter(|(pair, _)| pair.is_above_horizon()) {
                let expected = decoder.log_value(*pair, level, filter);
                for channel in 0..3 {
                    let difference = f64::from((expected[channel] - found.log_value[channel]).abs());
                    assert!(difference <= bound, "{name}, {filter:?}: {difference} > {bound}");
                }
            }
        }
    }
}

/// Without any difference the test above would be meaningless.
#[test]
fn hardware_filtering_is_not_exact() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = Evaluator::new(gpu).unwrap();
    let pack = pack(header(Parameterisation::TangentPole, 4, 3, 8), 40, 2);
    let pairs = pairs(2000, 4);
    let loaded = evaluator.load(&wavelet(&pack), Filter::Bilinear).unwrap();
    let exact = evaluator.eval(&loaded, &pairs, 4.0, SliceFilter::Exact).unwrap();
    let hardware = evaluator.eval(&loaded, &pairs, 4.0, SliceFilter::Hardware).unwrap();
    let largest = exact.iter().zip(&hardware).map(|(a, b)| (a.log_value[0] - b.log_value[0]).abs()).fold(0.0, f32::max);
    assert!(largest > 1e-7, "{largest}");
    println!("largest difference of log values: {largest}, bound {}", filter_bound(&pack));
}

#[test]
fn the_level_follows_the_distance() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = Evaluator::new(gpu).unwrap();
    let pack = pack(header(Parameterisation::TangentPole, 5, 3, 8), 60, 2);
    let decoder = WaveletDecoder::new(&pack);
    let loaded = evaluator.load(&wavelet(&pack), Filter::Bilinear).unwrap();
    let pairs = pairs(200, 5);
    for distance in [0.01f32, 3.0, 6.6, 7.0, 20.0, 65.0, 200.0, 1e4] {
        let level = level_of_detail(5, f64::from(distance), DEFAULT_DISTANCE_SCALE) as f32;
        let found = evaluator.eval(&loaded, &pairs, -distance, SliceFilter::Exact).unwrap();
        for (pair, found) in pairs.iter().zip(&found) {
            let expected = decoder.log_value(*pair, level, Filter::Bilinear);
            // The logarithm of a driver is accurate to about 1e-6 of a level.
            assert!((expected[1] - found.log_value[1]).abs() < 2e-5, "{distance}: {expected:?} {found:?}");
        }
    }
}

/// Counts fetches by an instrumented shader, with a counter before every line that fetches.
#[test]
fn a_reconstruction_costs_four_fetches_per_level_and_one() {
    let Some(gpu) = crate::common::gpu() else { return };
    let mut counters = 0;
    let mut instrumented = "var<private> fetch_count: u32 = 0u;\n".to_owned();
    for line in WAVELET_BRDF_WGSL.lines() {
        let code = line.split("//").next().unwrap();
        let calls = code.matches("= texture").count() + code.matches("return texture").count();
        if code.contains("textureLoad(") || code.contains("textureSampleLevel(") {
            assert_eq!(calls, 1, "one fetch per line: {line}");
            instrumented += "fetch_count += 1u;\n";
            counters += 1;
        }
        instrumented += line;
        instrumented += "\n";
    }
    assert_eq!(counters, 3, "index, hardware and exact");
    // The entry point evaluates twice. The count is from the first evaluation, for the log value.
    let counted = "        log_value = log_value_of(wi, wo, level, hardware);";
    let entry = EVALUATE_WGSL
        .replace("return 0.0;", "return f32(log_fetches);")
        .replace("fn fetches()", "var<private> log_fetches: u32 = 0u;\nfn fetches()")
        .replace(counted, &format!("{counted}\n log_fetches = fetch_count;"));
    assert!(entry.matches("log_fetches").count() == 3);
    let evaluator = Evaluator::with_shaders(gpu, &instrumented, &entry).unwrap();
    let pairs = pairs(50, 6);
    let plain = [1, 3, 5].map(|levels| header(Parameterisation::HalfDifference, levels, 3, 8));
    for header in plain.into_iter().chain([energy_preserving(3, 3, 8)]) {
        let levels = header.levels;
        let pack = wavelet(&pack(header, 1 << levels, 3));
        for (filter, slices, reconstructions, texels) in [
            (Filter::Nearest, SliceFilter::Exact, 1, 1),
            (Filter::Nearest, SliceFilter::Hardware, 1, 1),
            (Filter::Slices, SliceFilter::Hardware, 1, 1),
            (Filter::Bilinear, SliceFilter::Hardware, 4, 1),
            (Filter::Slices, SliceFilter::Exact, 1, 4),
            (Filter::Bilinear, SliceFilter::Exact, 4, 4),
        ] {
            let loaded = evaluator.load(&pack, filter).unwrap();
            for level in 0..=levels {
                // An index look-up per detail, and a coefficient of 1 or 4 texels.
                // Energy-preserving packs look up the scaling coefficients of coarser trees.
                let scaling = u32::from(level < header.trees());
                let expected = reconstructions * (2 * level * (1 + texels) + texels + scaling);
                if texels == 1 && reconstructions == 1 {
                    assert_eq!(expected, 4 * level + 1 + scaling);
                }
                if slices == SliceFilter::Hardware {
                    assert_eq!(expected, pack.fetches_at(level, filter));
                }
                for found in evaluator.eval(&loaded, &pairs, level as f32, slices).unwrap() {
                    assert_eq!(found.fetches, expected as f32, "{filter:?}, {slices:?}, level {level}");
                }
            }
            let blended = evaluator.eval(&loaded, &pairs, levels as f32 - 0.5, slices).unwrap();
            let of = |level: u32| evaluator.eval(&loaded, &pairs, level as f32, slices).unwrap()[0].fetches;
            // A blend costs what its finer level costs, and the coarser one too if that has a tree of its own.
            let coarser = if header.trees() > 0 { of(levels - 1) } else { 0.0 };
            assert_eq!(blended[0].fetches, of(levels) + coarser);
        }
    }
    println!("32 x 32, nearest: {} fetches", 4 * 5 + 1);
}

/// Byte ranges of the numbers in the shader's code.
fn literals(source: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in source.split_inclusive('\n') {
        let code = line.split("//").next().unwrap();
        if !code.trim_start().starts_with('@') {
            let bytes = code.as_bytes();
            let mut at = 0;
            while at < bytes.len() {
                let word_before = at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || b"_.".contains(&bytes[at - 1]));
                if bytes[at].is_ascii_digit() && !word_before {
                    let mut end = at;
                    while end < bytes.len()
                        && (bytes[end].is_ascii_alphanumeric()
                            || bytes[end] == b'.'
                            || (bytes[end] == b'-' && bytes[end - 1] == b'e'))
                    {
                        end += 1;
                    }
                    found.push(start + at..start + end);
                    at = end;
                } else {
                    at += 1;
                }
            }
        }
        start += line.len();
    }
    found
}

/// Changes that do not affect any value, with the reason.
const HARMLESS: [(&str, &str, &str); 13] = [
    ("k < select(2u, ", "2u", "one more level, which is not read; the count of fetches notices"),
    ("is_finest || fraction == ", "0.25", "one more level with weight 0; the count of fetches notices"),
    ("fraction * (values[", "2", "an index out of bounds is the last"),
    ("if first > ", "1u", "other trees start at 5 or later"),
    ("var values: array<vec3<f32>, ", "3", "one more element, which nothing reads"),
    ("let last = whole + select(", "1u", "one more level with weight 0; the count of fetches notices"),
    ("let cells = select(4u, ", "2u", "one more cell with weight 0; the count of fetches notices"),
    ("wavelet_brdf_sampler, at, ", "0.25", "there is one mip level"),
    ("let t = select(", "0.25", "only a zero vector has no angle"),
    ("wavelet_brdf_reconstruct(at, ", "2u", "one more cell with weight 0, which a tap of one cell has"),
    ("wavelet_brdf_parameters.scaling_offset, ", "0.25", "the half of the scaling coefficient is never requested"),
    ("let k = round(x * ", "1.4412523050000001e0", "the remainder is a little larger, with the same accuracy"),
    ("let x = max(value, vec3<f32>(-", "8.6913e1", "equivalent to 0 below either"),
];

/// A number with a small change.
fn changed(text: &str) -> String {
    match text.strip_suffix('u') {
        Some(integer) => format!("{}u", integer.parse::<u32>().unwrap() + 1),
        None if text.starts_with("0x") => format!("{text}0"),
        None => match (text.parse::<i32>(), text.parse::<f64>().unwrap()) {
            (Ok(integer), _) => (integer + 1).to_string(),
            (_, 0.0) => "0.25".to_owned(),
            (_, value) => format!("{:e}", value * 0.999),
        },
    }
}

/// The negative control: a small change of any number in the shader is detected. One shader contains all of these
/// changes, of which a run selects one. Constants have shaders of their own.
#[test]
fn a_changed_constant_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let found = literals(WAVELET_BRDF_WGSL);
    let before = |range: &Range<usize>| WAVELET_BRDF_WGSL[..range.start].rsplit('\n').next().unwrap();
    let is_chosen = |range: &Range<usize>| {
        let is_size = before(range).ends_with("array<vec3<f32>, ");
        !is_size && !before(range).starts_with("const ") && !WAVELET_BRDF_WGSL[range.clone()].starts_with("0x")
    };
    let mut all = WAVELET_BRDF_WGSL.to_owned();
    for (k, range) in found.iter().enumerate().rev().filter(|(_, range)| is_chosen(range)) {
        let text = &WAVELET_BRDF_WGSL[range.clone()];
        all.replace_range(range.clone(), &format!("select({text}, {}, change == {}u)", changed(text), k + 1));
    }
    let mut evaluator = Evaluator::with_shaders(gpu, &all, EVALUATE_WGSL).unwrap();
    assert!(!is_detected(&evaluator), "no change is active");
    let mut missed = Vec::new();
    for (k, range) in found.iter().enumerate() {
        let text = &WAVELET_BRDF_WGSL[range.clone()];
        let changed = changed(text);
        let noticed = if is_chosen(range) {
            evaluator.change = k as u32 + 1;
            is_detected(&evaluator)
        } else {
            let mut source = WAVELET_BRDF_WGSL.to_owned();
            source.replace_range(range.clone(), &changed);
            Evaluator::with_shaders(gpu, &source, EVALUATE_WGSL).map_or(true, |evaluator| is_detected(&evaluator))
        };
        let line = WAVELET_BRDF_WGSL[..range.start].matches('\n').count();
        let harmless = HARMLESS.iter().any(|(part, text, _)| changed == *text && before(range).ends_with(part));
        if noticed == harmless {
            missed.push(format!(
                "line {}: {text} -> {changed}: {}",
                line + 1,
                WAVELET_BRDF_WGSL.lines().nth(line).unwrap()
            ));
        }
    }
    assert!(found.len() > 60, "{}", found.len());
    assert!(missed.is_empty(), "{} of {}:\n{}", missed.len(), found.len(), missed.join("\n"));
}

fn is_detected(evaluator: &Evaluator<'_>) -> bool {
    let pairs = all_kinds_of_pairs(400, 8);
    let crop = Crop { directions: DirectionRange::ALL, window: Window { first: [1, 2], size: [5, 3] } };
    let mut absurd = pack(header(Parameterisation::TangentPole, 2, 3, 8), 4, 1);
    absurd.scales[1] = SliceScale { scale: 2000.0, offset: -800.0 };
    let mut steep = pack(energy_preserving(3, 3, 8), 40, 2);
    steep.scales[2..].iter_mut().for_each(|s| (s.scale, s.offset) = (8.0 * s.scale, 8.0 * s.offset));
    for pack in [
        pack(header(Parameterisation::HalfDifference, 3, 3, 16), 40, 2),
        pack(header(Parameterisation::TangentPole, 2, 1, 8), 12, 5),
        pack(header(Parameterisation::TangentPole, 3, 3, 16), 30, 3).cropped(crop).expect("within the grid"),
        steep,
        absurd,
    ] {
        let decoder = WaveletDecoder::new(&pack);
        for filter in FILTERS {
            let loaded = evaluator.load(&wavelet(&pack), filter).unwrap();
            for level in [0.1, pack.header.levels as f32] {
                let found = evaluator.eval(&loaded, &pairs, level, SliceFilter::Exact).unwrap();
                let differences = exact_differences(&decoder, &pack, &pairs, level, filter, &found);
                if differences.bits + differences.values > 0 {
                    return true;
                }
            }
            for distance in [3.0, 9.0] {
                let level = level_of_detail(pack.header.levels, f64::from(distance), DEFAULT_DISTANCE_SCALE) as f32;
                let found = evaluator.eval(&loaded, &pairs, -distance, SliceFilter::Exact).unwrap();
                let close = |(pair, found): (&DirectionPair, &Evaluated)| {
                    !pair.is_above_horizon()
                        || (decoder.log_value(*pair, level, filter)[0] - found.log_value[0]).abs() <= 2e-5
                };
                if pack.scales[1].scale < 100.0 && !pairs.iter().zip(&found).all(close) {
                    return true;
                }
            }
            if filter != Filter::Nearest && pack.header.bits == 16 {
                let level = pack.header.levels as f32;
                let found = evaluator.eval(&loaded, &pairs, level, SliceFilter::Hardware).unwrap();
                let bound = filter_bound(&pack) as f32;
                for (pair, found) in pairs.iter().zip(&found) {
                    let above = pair.is_above_horizon();
                    let expected = if above { decoder.log_value(*pair, level, filter) } else { [0.0; 3] };
                    let f_r = if above { decoder.from_log(found.log_value[0]) } else { 0.0 };
                    let exponential = if above { exponential_bound(&pack, found.log_value[0]) as f32 } else { 0.0 };
                    let beyond = |difference: f32, bound: f32| difference.abs() > bound || difference.is_nan();
                    if beyond(expected[0] - found.log_value[0], bound) || beyond(f_r - found.f_r[0], exponential) {
                        return true;
                    }
                }
            }
        }
    }
    false
}
