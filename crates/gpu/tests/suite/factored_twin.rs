//! The shader of factored flat BTFs, compared with the CPU decoder on any adapter.

use brdfc_formats::bindings::{Binding, FrameBlock};
use brdfc_formats::direction::from_polar;
use brdfc_formats::flat_btf::factored::shader::{FACTORED_FILTER_PRECISION, FACTORED_WGSL};
use brdfc_formats::flat_btf::factored::{
    BaseTable, BasisMap, FactoredFlatBtf, FactoredHeader, ResidualMap, WeightMap, WeightRange,
};
use brdfc_formats::flat_btf::shader::{FLAT_BTF_WGSL, factored_bindings};
use brdfc_formats::flat_btf::{BlendedDirection, ViewWeights};
use brdfc_gpu::Gpu;
use brdfc_probe::Compute;
use brdfc_testing::codecs::flat_btf::{BASE, Factors, MATERIALS, SMALL, Sizes, factored, weights};
use brdfc_testing::packs::Numbers;

const ENTRY: &str = "
fn three(first: u32) -> FactoredWeights {
    let indices = vec3<u32>(u32(input[first]), u32(input[first + 1u]), u32(input[first + 2u]));
    return FactoredWeights(indices, vec3<f32>(input[first + 3u], input[first + 4u], input[first + 5u]));
}

fn compute(at: u32) {
    let first = at * 21u;
    let uv = vec2<f32>(input[first], input[first + 1u]);
    let view = vec3<f32>(input[first + 15u], input[first + 16u], input[first + 17u]);
    let light = vec3<f32>(input[first + 18u], input[first + 19u], input[first + 20u]);
    let place = factored_place(uv, input[first + 2u]);
    let base = factored_load(place);
    var value = factored_base_colour(base, view, light);
    if factored_parameters.groups > 0u {
        value = factored_value(base, view, light, three(first + 3u), three(first + 9u));
    }
    value = factored_shadowed(value, place, base, three(first + 9u), 0.375);
    output[at * 3u] = value.x;
    output[at * 3u + 1u] = value.y;
    output[at * 3u + 2u] = value.z;
}
";

/// Share of the light that arrives.
const LIT: f32 = 0.375;

/// Value of the CPU decoder.
fn expected(asset: &FactoredFlatBtf, (uv, detail, view, light): &Query) -> [f32; 3] {
    let texel = asset.filtered(*uv, *detail);
    texel.shadowed(texel.blended(*view, *light), light.samples, LIT)
}

/// Place, level, view and light.
type Query = ([f32; 2], f32, BlendedDirection, BlendedDirection);

fn queries(sizes: Sizes, count: usize) -> Vec<Query> {
    let mut numbers = Numbers::new(6);
    let edges = [0.0, 1.0, -1.0, 0.5, -1e-9, 0.999_999_94, 37.25];
    let details = [0.0, -2.0, 0.5, 1.0, 1.75, 2.0, 9.0];
    (0..count)
        .map(|_| {
            let uv = match numbers.bits() % 5 {
                0 => [0; 2].map(|_| edges[numbers.bits() as usize % edges.len()]),
                _ => [0; 2].map(|_| numbers.between(-2.0, 3.0) as f32),
            };
            let detail = match numbers.bits() % 3 {
                0 => details[numbers.bits() as usize % details.len()],
                _ => numbers.between(0.0, 2.0) as f32,
            };
            let [view, light] = [sizes.views, sizes.lights].map(|count| {
                let samples = weights(&mut numbers, count);
                BlendedDirection { direction: direction(&mut numbers), samples }
            });
            // Some pairs are mirrored, some are opposite to each other.
            let light = match numbers.bits() % 8 {
                0 => BlendedDirection { direction: mirrored(view.direction), ..light },
                1 => BlendedDirection { direction: view.direction.map(|c| -c), ..light },
                _ => light,
            };
            (uv, detail, view, light)
        })
        .collect()
}

fn direction(numbers: &mut Numbers) -> [f32; 3] {
    let height = [0.0, 1.0, numbers.unit(), numbers.unit()][numbers.bits() as usize % 4];
    from_polar(height.acos(), numbers.between(0.0, std::f64::consts::TAU)).map(|c| c as f32)
}

fn mirrored([x, y, z]: [f32; 3]) -> [f32; 3] {
    [-x, -y, z]
}

fn shader(decoder: &str) -> String {
    // The bindings of the layers are not used.
    format!("{FLAT_BTF_WGSL}\n{decoder}\n{ENTRY}")
}

fn found(gpu: &Gpu, decoder: &str, asset: &FactoredFlatBtf, filter: FrameBlock, queries: &[Query]) -> Vec<[f32; 3]> {
    let bindings: Vec<_> = [Binding::frame()].into_iter().chain(factored_bindings(asset)).collect();
    let compute = Compute::new(gpu, &shader(decoder), &bindings, filter).unwrap();
    let three = |three: &BlendedDirection| -> Vec<f32> {
        let three: &ViewWeights = &three.samples;
        three.indices.iter().map(|index| *index as f32).chain(three.weights).collect()
    };
    let input: Vec<f32> = queries
        .iter()
        .flat_map(|(uv, detail, view, light)| {
            [&uv[..], &[*detail], &three(view), &three(light), &view.direction, &light.direction].concat()
        })
        .collect();
    compute.run(&input, 21, 3).unwrap().as_chunks::<3>().0.to_vec()
}

fn assets() -> Vec<(Sizes, FactoredFlatBtf)> {
    let factors =
        |levels, groups, wide_groups, residual| Factors { levels, groups, wide_groups, residual, materials: 0 };
    [
        (SMALL, factors(3, 2, 2, 2)),
        (Sizes { flat: 16, views: 7, lights: 12, ..SMALL }, factors(5, 7, 1, 4)),
        (Sizes { flat: 5, views: 4, ..SMALL }, factors(3, 16, 4, 0)),
        (Sizes { flat: 9, views: 4, ..SMALL }, factors(1, 3, 0, 5)),
        (SMALL, BASE),
        (SMALL, MATERIALS),
    ]
    .into_iter()
    .map(|(sizes, factors)| (sizes, factored(sizes, factors, 8)))
    .collect()
}

fn differing(asset: &FactoredFlatBtf, queries: &[Query], found: &[[f32; 3]]) -> usize {
    assert_eq!(queries.len(), found.len());
    let differs =
        |(query, found): &(&Query, &[f32; 3])| expected(asset, query).map(f32::to_bits) != found.map(f32::to_bits);
    queries.iter().zip(found).filter(differs).count()
}

#[test]
fn manual_filtering_gives_the_bits_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    for (sizes, asset) in assets() {
        let queries = queries(sizes, 3000);
        let found = found(gpu, FACTORED_WGSL, &asset, FrameBlock::exact(), &queries);
        assert_eq!(differing(&asset, &queries, &found), 0, "{sizes:?}");
        assert!(found.iter().filter(|value| value.iter().any(|c| *c > 1e-4)).count() > 1500, "most are not black");
    }
}

/// One component of lightness, to separate the sampler's errors of weights and of the residual, with a cell per texel.
fn grey(size: u32, levels: u32, weight: impl Fn(u32) -> u8, share: impl Fn(u32) -> u8) -> FactoredFlatBtf {
    let of = factored(SMALL, Factors { levels: 1, groups: 1, wide_groups: 1, residual: 1, materials: 0 }, 1);
    let header = FactoredHeader {
        size,
        levels,
        residual: size,
        steps: [vec![0.01; 4], vec![0.0; 4], vec![0.0; 4]],
        ..of.header().clone()
    };
    let black = BaseTable::black();
    let basis =
        BasisMap::from_steps(header, &black, |_, _, colour, k| if colour + k == 0 { 10_000 } else { 0 }).unwrap();
    let texels: u32 = (0..levels).map(|level| (size >> level).max(1).pow(2)).sum();
    let sides = (0..levels).map(|level| (size >> level).max(1).pow(2));
    let firsts = sides.clone().scan(0, |first, count| Some(std::mem::replace(first, *first + count)));
    let level = |(first, count): (u32, u32)| {
        let of_base = vec![0; 8 * count as usize];
        of_base.into_iter().chain((first..first + count).flat_map(|k| [weight(k), 0, 0, 0])).collect::<Vec<u8>>()
    };
    let weights = firsts.zip(sides).flat_map(level).collect();
    let weights = WeightMap::new(size, levels, vec![WeightRange { scale: 1.0, low: 0.0 }; 12], weights).unwrap();
    let shares = (0..10 * texels).map(share).collect();
    FactoredFlatBtf::new(basis, weights, Some(ResidualMap::new(size, 5, shares).unwrap())).unwrap()
}

#[test]
fn the_sampler_is_within_its_precision() {
    let Some(gpu) = crate::common::gpu() else { return };
    let byte = |k: u32| (k.wrapping_mul(0x9e37_79b9) >> 24) as u8;
    // Lightness is at most 100 w, so colours have a slope of 3 (100 / 116)² / 116 of it; three filters, one per axis.
    let bound = 3.0 * FACTORED_FILTER_PRECISION;
    let slope = 3.0 * (100.0f32 / 116.0).powi(3);
    // Shares are (255 c / 180)² of a filtered c.
    let of_share = 2.0 * (255.0f32 / 180.0).powi(2);
    for (asset, bound) in [(grey(8, 4, byte, |_| 180), slope * bound), (grey(8, 4, |_| 255, byte), of_share * bound)] {
        let queries = queries(SMALL, 3000);
        let found = found(gpu, FACTORED_WGSL, &asset, FrameBlock::default(), &queries);
        let mut largest = 0.0f32;
        for (query, found) in queries.iter().zip(&found) {
            let expected = expected(&asset, query);
            largest = (0..3).map(|k| (expected[k] - found[k]).abs()).fold(largest, f32::max);
        }
        println!("largest difference {largest}, bound {bound}");
        assert!(largest <= bound, "{largest} of {bound}");
    }
}

/// Texels are equal everywhere, so that only tables are filtered. The controls take another material or level.
#[test]
fn the_sampler_filters_tables_within_its_precision() {
    let Some(gpu) = crate::common::gpu() else { return };
    let of = factored(SMALL, MATERIALS, 8);
    let lows = [1.0, 1.0, 1.0, 0.4, 0.2, 0.0, -0.1, 0.0];
    let ranges = lows.map(|low| WeightRange { scale: 0.0, low }).to_vec();
    let weights = of.weights();
    let weights = WeightMap::new(weights.size(), weights.levels(), ranges, weights.texels().to_vec()).unwrap();
    let asset = FactoredFlatBtf::new(of.basis().clone(), weights, None).unwrap();
    let queries = queries(SMALL, 3000);
    let largest = |source: &str| {
        let found = found(gpu, source, &asset, FrameBlock::default(), &queries);
        let of_query = |(query, found): (&Query, &[f32; 3])| {
            let expected = expected(&asset, query);
            (0..3).map(|k| (expected[k] - found[k]).abs()).fold(0.0, f32::max)
        };
        queries.iter().zip(&found).map(of_query).fold(0.0, f32::max)
    };
    // Neighbouring entries of both tables differ by at most 4, 1 and 4 along the axes.
    let bound = LIT * FACTORED_FILTER_PRECISION * 9.0;
    assert!(largest(FACTORED_WGSL) <= bound, "{}", largest(FACTORED_WGSL));
    for (from, to) in [
        ("f32(table * FACTORED_HALF_ANGLES) + angle", "angle"),
        ("row, f32(base.level) + base.blend) + vec3<f32>(0.5)", "row, f32(base.level)) + vec3<f32>(0.5)"),
        ("+ vec3<f32>(0.5);", "+ vec3<f32>(0.0);"),
    ] {
        assert_eq!(FACTORED_WGSL.matches(from).count(), 1, "{from}");
        assert!(largest(&FACTORED_WGSL.replace(from, to)) > bound, "{from}");
    }
}

/// Small changes of the shader, each of which the queries must detect.
const CHANGES: [(&str, &str); 51] = [
    ("1.0 / 116.0", "1.0 / 116.1"),
    ("1.0 / 500.0", "1.0 / 500.5"),
    ("1.0 / 200.0", "1.0 / 200.5"),
    ("3.0799556", "3.08"),
    ("0.045232937", "0.0453"),
    ("-0.20402668", "-0.205"),
    ("factored_parameters.size >> level", "factored_parameters.size"),
    ("uv.y, side)", "uv.x, side)"),
    ("factored_parameters.residual >> level", "factored_parameters.residual"),
    (" - factored_parameters.residual_octaves", ""),
    ("255.0 / 180.0", "255.0 / 181.0"),
    ("(1.0 - lit) * shares.y", "0.99 * shares.y"),
    ("lit * shares.x", "lit * shares.y"),
    ("blend * (factored_residual_level", "0.9 * blend * (factored_residual_level"),
    ("uv.y, factored_side(level));\n    var value = vec4", "uv.x, factored_side(level));\n    var value = vec4"),
    ("<< vec4<u32>(24u, 16u, 8u, 0u)) >>", "<< vec4<u32>(24u, 16u, 0u, 8u)) >>"),
    ("min(max(opponent.y, limit.x), limit.y)", "opponent.y"),
    ("vec2<u32>(16u, 0u)", "vec2<u32>(0u, 16u)"),
    ("2u * factored_parameters.wide_groups", "factored_parameters.wide_groups"),
    ("(words + 3u) / 4u", "(words + 4u) / 4u"),
    ("light * 3u + colour", "light * 3u + 2u - colour"),
    ("root * root * root", "root * root"),
    ("min(max(level_of_detail, 0.0), last)", "min(max(level_of_detail, 0.1), last)"),
    ("v < 3u", "v < 2u"),
    ("0.433953", "0.434"),
    ("0.072175", "0.0722"),
    ("0.10946796", "0.1095"),
    ("116.0 * root.y", "116.1 * root.y"),
    ("500.0 * (root.x", "500.5 * (root.x"),
    ("200.0 * (root.y", "200.5 * (root.y"),
    ("0x2a5137a0u", "0x2a6137a0u"),
    ("FACTORED_LEAST_COSINES: f32 = 0.1", "FACTORED_LEAST_COSINES: f32 = 0.11"),
    ("f32(FACTORED_HALF_ANGLES - 1u)", "f32(FACTORED_HALF_ANGLES - 2u)"),
    ("f32(FACTORED_DIFFERENCE_ANGLES - 1u)", "f32(FACTORED_DIFFERENCE_ANGLES - 2u)"),
    ("var share = 0.5;", "var share = 0.501;"),
    ("share = 0.25;", "share = 0.26;"),
    ("2.0 * cosine * base.normal - light", "2.0 * cosine * base.normal + light"),
    ("(factored_parameters.axes >> table) & 1u", "factored_parameters.axes & 1u"),
    ("table * FACTORED_HALF_ANGLES + u32(i), base.level", "u32(i), base.level"),
    ("+ u32(i), base.level)", "+ u32(i), 0u)"),
    ("first + vec3<u32>(1u, 1u, 0u)", "first + vec3<u32>(1u, 0u, 0u)"),
    ("base.blend * (coarse - entry)", "0.99 * base.blend * (coarse - entry)"),
    ("select(place.blend, 0.0, level == last)", "0.0"),
    ("let second = factored_parameters.albedos[1].xyz", "let second = factored_parameters.albedos[0].xyz"),
    ("(first.w * cosine)", "cosine"),
    ("(gloss.w * cosine)", "cosine"),
    ("min(0.5 * length, 1.0)", "min(0.501 * length, 1.0)"),
    ("slopes.xz + slopes.yw", "slopes.xz"),
    ("scale - 1.0)", "scale - 0.999)"),
    ("flat_btf_raised(light, factored_parameters.lowest_light)", "light"),
    ("lights.weights[l] * factored_residual", "lights.weights.x * factored_residual"),
];

/// The negative control: every change above is detected.
#[test]
fn a_changed_shader_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let noticed = |source: &str| {
        assets().into_iter().any(|(sizes, asset)| {
            let queries = queries(sizes, 500);
            differing(&asset, &queries, &found(gpu, source, &asset, FrameBlock::exact(), &queries)) > 0
        })
    };
    assert!(!noticed(FACTORED_WGSL));
    for (from, to) in CHANGES {
        assert_eq!(FACTORED_WGSL.matches(from).count(), 1, "{from}");
        assert!(noticed(&FACTORED_WGSL.replace(from, to)), "{from} -> {to}");
    }
}
