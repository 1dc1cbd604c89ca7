//! The shader of flat BTFs, compared with the CPU decoder on any adapter.

use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::shader::{FLAT_BTF_FILTER_PRECISION, FLAT_BTF_WGSL};
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, FlatValues, IndirectionMap, MAX_TANGENT, TANGENT_BIAS};
use brdfc_gpu::Gpu;
use brdfc_probe::{FlatBtfAnswer, FlatBtfEvaluator, FlatBtfQuery};
use brdfc_testing::codecs::flat_btf::{self, SMALL, Sizes};
use brdfc_testing::packs::{Numbers, unit_vector};
use std::f32::consts::{FRAC_PI_2, TAU};

const ASSETS: [Sizes; 3] = [
    SMALL,
    Sizes { flat: 16, reference: 11, zenith: 8, azimuth: 32, largest_angle: FRAC_PI_2, views: 7, lights: 12 },
    Sizes { flat: 5, reference: 6, zenith: 16, azimuth: 16, largest_angle: 1.4, views: 4, lights: 4 },
];

/// Random queries, and views at the samples, at the pole, at the seam of the azimuth and below the horizon.
fn queries(sizes: Sizes, count: usize, seed: u64) -> Vec<FlatBtfQuery> {
    let mut numbers = Numbers::new(seed);
    let mut views: Vec<[f32; 3]> = (0..count).map(|_| unit_vector(&mut numbers)).collect();
    let header = flat_btf::header(sizes);
    for k in 0..sizes.zenith {
        for a in 0..sizes.azimuth {
            let [polar, azimuth] = header.view_angles(k, a);
            views.push([polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()].map(|c| c as f32));
        }
    }
    views.extend([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.8, -1e-9, 0.6], [-0.8, -1e-9, 0.6], [0.0, 0.6, -0.8]]);
    let edges = [0.0, 1.0, -1.0, 0.5, -1e-9, 0.999_999_94, 37.25];
    let query = |view| {
        let uv = match numbers.bits() % 5 {
            0 => [0; 2].map(|_| edges[numbers.bits() as usize % edges.len()]),
            _ => [0; 2].map(|_| numbers.between(-2.0, 3.0) as f32),
        };
        FlatBtfQuery {
            uv,
            view,
            light: unit_vector(&mut numbers),
            views: flat_btf::weights(&mut numbers, sizes.views),
            lights: flat_btf::weights(&mut numbers, sizes.lights),
        }
    };
    views.into_iter().map(query).collect()
}

/// Number of values whose bits differ from the decoder's: indirection, full form, light form.
fn differences(decoder: &FlatBtfDecoder, queries: &[FlatBtfQuery], found: &[FlatBtfAnswer]) -> [usize; 3] {
    let mut counts = [0; 3];
    for (query, found) in queries.iter().zip(found) {
        let expected = [
            decoder.indirection(query.uv, query.view),
            decoder.full(query.uv, query.view, query.views, query.lights),
            decoder.light_form(query.uv, query.view, query.light),
        ];
        for (count, (a, b)) in counts.iter_mut().zip(expected.iter().zip([found.indirection, found.full, found.light]))
        {
            *count += (0..3).filter(|k| a[*k].to_bits() != b[*k].to_bits()).count();
        }
    }
    counts
}

#[test]
fn manual_filtering_gives_the_bits_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    for (k, sizes) in ASSETS.into_iter().enumerate() {
        let decoder = FlatBtfDecoder::new(flat_btf::parts(sizes, 10 + k as u64)).unwrap();
        let loaded = evaluator.load(&decoder, FrameBlock::exact()).unwrap();
        let queries = queries(sizes, 5000, k as u64);
        let found = evaluator.eval(&loaded, &queries).unwrap();
        assert_eq!(found.len(), queries.len());
        assert_eq!(differences(&decoder, &queries, &found), [0; 3], "{sizes:?}");
        assert!(found.iter().filter(|answer| answer.light != [0.0; 3]).count() > 2000, "most are lit");
    }
}

/// An asset with displacements, one block per four texels of the reference plane.
fn compact(sizes: Sizes, seed: u64) -> FlatBtfDecoder {
    let indirection = flat_btf::displacements(sizes, sizes.reference / 2, seed).into();
    FlatBtfDecoder::new(FlatBtfParts { indirection, ..flat_btf::parts(sizes, seed) }).unwrap()
}

#[test]
fn displacements_have_the_bits_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    let changed = FLAT_BTF_WGSL.replace("tangent + 0.25", "tangent + 0.26");
    assert!(changed != FLAT_BTF_WGSL);
    let changed = FlatBtfEvaluator::with_shader(gpu, &changed).unwrap();
    for sizes in [SMALL, Sizes { reference: 12, ..ASSETS[1] }, ASSETS[2]] {
        let decoder = compact(sizes, 4);
        let queries = queries(sizes, 5000, 4);
        let answers = |evaluator: &FlatBtfEvaluator<'_>, filter| {
            evaluator.eval(&evaluator.load(&decoder, filter).unwrap(), &queries).unwrap()
        };
        let found = answers(&evaluator, FrameBlock::exact());
        assert_eq!(differences(&decoder, &queries, &found), [0; 3], "{sizes:?}");
        assert!(differences(&decoder, &queries, &answers(&changed, FrameBlock::exact()))[0] > 5000);
    }
    // A single block has no neighbours on another side, where errors below the precision would decide.
    let decoder = {
        let indirection = flat_btf::displacements(SMALL, 1, 4).into();
        FlatBtfDecoder::new(FlatBtfParts { indirection, ..flat_btf::parts(SMALL, 4) }).unwrap()
    };
    let queries = queries(SMALL, 5000, 5);
    let loaded = evaluator.load(&decoder, FrameBlock::default()).unwrap();
    // Shares differ by at most 1 along both angles, each with a factor of at most a fifth of a tile and the largest
    // tangent.
    let bound = 2.0 * 2.0 * FLAT_BTF_FILTER_PRECISION * 0.2 * (MAX_TANGENT + TANGENT_BIAS);
    for (query, answer) in queries.iter().zip(evaluator.eval(&loaded, &queries).unwrap()) {
        let expected = decoder.indirection(query.uv, query.view);
        let apart = [0, 1].map(|k| expected[k] - answer.indirection[k]).map(|d| d - d.round());
        assert!(apart[0].hypot(apart[1]) < bound, "{query:?}: {expected:?} {answer:?}");
    }
}

/// Largest differences of neighbouring samples in the map: along the polar angle and the azimuth, per component.
fn steps(map: &IndirectionMap) -> [[f32; 4]; 2] {
    let header = map.header();
    let mut steps = [[0.0f32; 4]; 2];
    for at in 0..header.size * header.size {
        let texel = [at % header.size, at / header.size];
        for k in 0..header.zenith_samples {
            for a in 0..header.azimuth_samples {
                let here = map.sample(texel, k, a);
                let next = [map.sample(texel, (k + 1).min(header.zenith_samples - 1), a), map.sample(texel, k, a + 1)];
                for axis in 0..2 {
                    for component in 0..4 {
                        let step = (here[component] - next[axis][component]).abs();
                        steps[axis][component] = steps[axis][component].max(step);
                    }
                }
            }
        }
    }
    steps
}

/// A map whose directions change slowly, so that their blend retains its length.
fn smooth(sizes: Sizes) -> FlatBtfParts {
    let header = flat_btf::header(sizes);
    let indirection = IndirectionMap::from_displacements(header, |[i, j], k, a| {
        let [polar, azimuth] = header.view_angles(k, a).map(|angle| angle as f32);
        let distance = 0.2 * polar * (1.0 + 0.3 * (azimuth + i as f32).sin());
        let turn = azimuth + 0.2 * (2.0 * azimuth + j as f32).cos();
        ([distance * turn.cos(), distance * turn.sin()], 0.3 * (azimuth + polar + i as f32).sin())
    })
    .unwrap();
    FlatBtfParts { indirection: indirection.into(), ..flat_btf::parts(sizes, 5) }
}

/// Bounds on the displacement, in parameters, and on the height of the sampler's blend.
fn bounds(map: &IndirectionMap) -> [f32; 2] {
    let [polar, azimuth] = steps(map);
    let error = |component: usize| FLAT_BTF_FILTER_PRECISION * (polar[component] + azimuth[component]);
    let largest = map.texels().iter().map(|texel| brdfc_formats::container::half::decode(texel[2])).fold(0.0, f32::max);
    // A blend of directions that are less than 90 degrees apart is longer than 0.7.
    [error(2) + largest * (error(0) + error(1)) / 0.7 + 1e-6, error(3) + 1e-6]
}

fn beyond_bounds(decoder: &FlatBtfDecoder, queries: &[FlatBtfQuery], found: &[FlatBtfAnswer]) -> (usize, [f32; 2]) {
    let [displacement, height] = bounds(decoder.parts().indirection.samples().unwrap());
    let (mut beyond, mut largest) = (0, [0.0f32; 2]);
    for (query, found) in queries.iter().zip(found) {
        let expected = decoder.indirection(query.uv, query.view);
        let periodic = |k: usize| {
            let difference = expected[k] - found.indirection[k];
            difference - difference.round()
        };
        let off = [periodic(0).hypot(periodic(1)), (expected[2] - found.indirection[2]).abs()];
        largest = [largest[0].max(off[0]), largest[1].max(off[1])];
        beyond += usize::from(!(off[0] <= displacement && off[1] <= height));
    }
    (beyond, largest)
}

#[test]
fn the_sampler_is_within_its_precision() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    for sizes in &ASSETS[1..] {
        let decoder = FlatBtfDecoder::new(smooth(*sizes)).unwrap();
        let loaded = evaluator.load(&decoder, FrameBlock::default()).unwrap();
        let queries = queries(*sizes, 5000, 3);
        let found = evaluator.eval(&loaded, &queries).unwrap();
        let (beyond, largest) = beyond_bounds(&decoder, &queries, &found);
        println!(
            "largest differences {largest:?}, bounds {:?}",
            bounds(decoder.parts().indirection.samples().unwrap())
        );
        assert_eq!(beyond, 0, "{largest:?}");
        assert!(largest.iter().all(|off| *off > 1e-7), "the sampler is not exact: {largest:?}");
    }
}

/// All blocks except one hold the largest numbers, which neither path may show.
#[test]
fn neither_path_leaves_its_block() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    let sizes = Sizes { reference: 63, zenith: 16, ..ASSETS[2] };
    let indirection = IndirectionMap::from_displacements(flat_btf::header(sizes), |texel, k, _| match texel {
        [61, 40] => ([0.01 * k as f32, 0.0], 0.25),
        _ => ([1024.0, 0.0], 1024.0),
    })
    .unwrap();
    let decoder =
        FlatBtfDecoder::new(FlatBtfParts { indirection: indirection.into(), ..flat_btf::parts(sizes, 5) }).unwrap();
    let mut queries = queries(sizes, 3000, 3);
    for k in 0..=64 {
        for a in 0..=64 {
            let (polar, azimuth) = (sizes.largest_angle * k as f32 / 64.0, TAU * a as f32 / 64.0);
            let view = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
            queries.push(FlatBtfQuery { view, ..queries[0] });
        }
    }
    for query in &mut queries {
        query.uv = [61.5 / 63.0, 40.5 / 63.0];
    }
    for filter in [FrameBlock::exact(), FrameBlock::default()] {
        let loaded = evaluator.load(&decoder, filter).unwrap();
        for (query, answer) in queries.iter().zip(evaluator.eval(&loaded, &queries).unwrap()) {
            let height = answer.indirection[2];
            assert!((height - 0.25).abs() < 1e-6, "{filter:?}, {:?}: {height}", query.view);
        }
        let mut outside = queries[0];
        outside.uv[0] = 0.5;
        assert_eq!(evaluator.eval(&loaded, &[outside]).unwrap()[0].indirection[2], 1024.0);
    }
}

#[test]
fn without_views_the_light_form_remains() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    let decoder = FlatBtfDecoder::new(FlatBtfParts { values: FlatValues::None, ..flat_btf::parts(SMALL, 2) }).unwrap();
    let loaded = evaluator.load(&decoder, FrameBlock::exact()).unwrap();
    let mut queries = queries(SMALL, 300, 1);
    for query in &mut queries {
        query.views.weights = [0.0; 3];
    }
    for (query, answer) in queries.iter().zip(evaluator.eval(&loaded, &queries).unwrap()) {
        assert_eq!(answer.light, decoder.light_form(query.uv, query.view, query.light));
        assert_eq!(answer.full, [0.0; 3]);
    }
}

/// Constants of the shader and small changes of them, each of which the queries must detect.
const CHANGES: [(&str, &str); 22] = [
    ("FLAT_BTF_PI: f32 = 3.14159274", "FLAT_BTF_PI: f32 = 3.1416"),
    ("FLAT_BTF_HALF_PI: f32 = 1.57079637", "FLAT_BTF_HALF_PI: f32 = 1.5708"),
    ("FLAT_BTF_TAU: f32 = 6.28318548", "FLAT_BTF_TAU: f32 = 6.2832"),
    ("FLAT_BTF_GUARD: f32 = 0.001953125", "FLAT_BTF_GUARD: f32 = 0.25"),
    ("-4.0545664e-3", "-4.1e-3"),
    ("2.1862958e-2", "2.2e-2"),
    ("5.5912327e-2", "5.6e-2"),
    ("9.642198e-2", "9.6e-2"),
    ("0.1390863", "0.139"),
    ("0.19946566", "0.1995"),
    ("0.3332986", "0.3333"),
    ("0.99999934", "1.0"),
    ("f32(size) - 0.5", "f32(size) - 0.4999"),
    ("inside + 0.5;", "inside + 0.6;"),
    ("max(cosine, 0.0)", "max(cosine, 1e-3)"),
    ("select(lower + 1u, 0u, lower + 1u == size)", "select(lower + 1u, 1u, lower + 1u == size)"),
    ("size - 1u, below < 0.0)", "0u, below < 0.0)"),
    ("azimuth_samples + 1u));\n    var value", "azimuth_samples));\n    var value"),
    ("light % columns, light / columns", "light / columns, light % columns"),
    ("select(tap.lower, tap.upper, upper == 1u)", "select(tap.lower, tap.upper, upper == 2u)"),
    ("v < 3u", "v < 2u"),
    ("l < 3u", "l < 2u"),
];

/// The negative control: every change above is detected.
#[test]
fn a_changed_constant_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    assert!(!is_detected(gpu, FLAT_BTF_WGSL));
    for (from, to) in CHANGES {
        assert_eq!(FLAT_BTF_WGSL.matches(from).count(), 1, "{from}");
        assert!(is_detected(gpu, &FLAT_BTF_WGSL.replace(from, to)), "{from} -> {to}");
    }
}

fn is_detected(gpu: &Gpu, source: &str) -> bool {
    let evaluator = FlatBtfEvaluator::with_shader(gpu, source).unwrap();
    for sizes in ASSETS {
        let decoder = FlatBtfDecoder::new(flat_btf::parts(sizes, 3)).unwrap();
        let queries = queries(sizes, 1000, 4);
        let loaded = evaluator.load(&decoder, FrameBlock::exact()).unwrap();
        if differences(&decoder, &queries, &evaluator.eval(&loaded, &queries).unwrap()) != [0; 3] {
            return true;
        }
    }
    let sizes = ASSETS[1];
    let decoder = FlatBtfDecoder::new(smooth(sizes)).unwrap();
    let queries = queries(sizes, 1000, 4);
    let loaded = evaluator.load(&decoder, FrameBlock::default()).unwrap();
    beyond_bounds(&decoder, &queries, &evaluator.eval(&loaded, &queries).unwrap()).0 > 0
}
