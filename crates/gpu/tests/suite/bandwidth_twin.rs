//! The shader of bandwidth maps, compared with the CPU look-ups on any adapter.

use brdfc_formats::bandwidth::shader::BANDWIDTH_WGSL;
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use brdfc_formats::bindings::{Binding, FrameBlock, Texels};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_gpu::Gpu;
use brdfc_probe::Compute;
use brdfc_testing::packs::Numbers;
use std::f32::consts::{FRAC_PI_2, TAU};

const ENTRY: &str = "
fn compute(at: u32) {
    let incoming = vec3<f32>(input[11u * at], input[11u * at + 1u], input[11u * at + 2u]);
    let outgoing = vec3<f32>(input[11u * at + 3u], input[11u * at + 4u], input[11u * at + 5u]);
    let direction = vec3<f32>(input[11u * at + 6u], input[11u * at + 7u], input[11u * at + 8u]);
    output[3u * at] = bandwidth_brdf(incoming, outgoing);
    output[3u * at + 1u] = bandwidth_environment(direction);
    output[3u * at + 2u] = bandwidth_texture(vec2<f32>(input[11u * at + 9u], input[11u * at + 10u]));
}
";

/// Positions at which maps are looked up.
#[derive(Clone, Copy)]
struct BandwidthQuery {
    incoming: [f32; 3],
    outgoing: [f32; 3],
    direction: [f32; 3],
    uv: [f32; 2],
}

/// `[brdf, environment, texture]` of each query, in up to one map of each kind; 0 of absent ones.
fn by_shader(gpu: &Gpu, source: &str, maps: &[BandwidthMap], queries: &[BandwidthQuery]) -> Vec<[f32; 3]> {
    let bindings: Vec<_> = maps.iter().flat_map(|map| map.bindings().all).collect();
    let present = |slot: u32| bindings.iter().any(|binding| binding.slot == slot);
    let absent = [29, 31, 33].into_iter().filter(|slot| !present(*slot)).flat_map(|slot| {
        let texels = Texels::empty(TexelFormat::R16Float, Extent::D2([1; 2]));
        [Binding::uniform(slot, "none", vec![0; 16]), Binding::texture(slot + 1, "none", texels)]
    });
    let bindings: Vec<_> = bindings.iter().cloned().chain(absent).collect();
    let compute = Compute::new(gpu, &format!("{source}\n{ENTRY}"), &bindings, FrameBlock::default()).unwrap();
    let numbers = |query: &BandwidthQuery| {
        let [incoming, outgoing, direction] = [query.incoming, query.outgoing, query.direction];
        incoming.into_iter().chain(outgoing).chain(direction).chain(query.uv)
    };
    let input: Vec<f32> = queries.iter().flat_map(numbers).collect();
    compute.run(&input, 11, 3).unwrap().chunks_exact(3).map(|found| [found[0], found[1], found[2]]).collect()
}

fn maps(tiles: bool) -> [BandwidthMap; 3] {
    let mut numbers = Numbers::new(8);
    let mut map = |kind, size: [u32; 2], largest: f64| {
        let header = BandwidthHeader { kind, epsilon: 0.01, transformed: size };
        let values: Vec<f32> = (0..size[0] * size[1]).map(|_| numbers.between(0.0, largest) as f32).collect();
        BandwidthMap::new(header, size, &values).unwrap()
    };
    [
        map(BandwidthKind::Brdf, [256; 2], 30.0),
        map(BandwidthKind::Environment, [512, 256], 80.0),
        map(BandwidthKind::Texture { metres: [0.01; 2], tiles }, [300, 77], 3e6),
    ]
}

/// Random queries, and queries at the borders of cells, at the poles, at the seams and beyond.
fn queries() -> Vec<BandwidthQuery> {
    let mut numbers = Numbers::new(2);
    let mut direction = |cells: u32| {
        let on_a_border = numbers.bits().is_multiple_of(3);
        let part = |count: u32, share: f64| {
            if on_a_border { (share * f64::from(count)).round() / f64::from(count) } else { share }
        };
        let azimuth = TAU * part(cells, numbers.unit()) as f32;
        let polar = 2.0 * FRAC_PI_2 * part(cells, numbers.unit()) as f32;
        [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
    };
    let mut all: Vec<BandwidthQuery> = (0..20_000)
        .map(|_| {
            let [x, y, z] = direction(512);
            BandwidthQuery { incoming: direction(16), outgoing: direction(16), direction: [x, z, y], uv: [0.0; 2] }
        })
        .collect();
    let ends = [0.0, 1.0, -1.0, 0.5, -1e-9, 0.999_999_94, 37.25, -400.5];
    for query in &mut all {
        query.uv = [0; 2].map(|_| match numbers.bits() % 3 {
            0 => ends[numbers.bits() as usize % ends.len()],
            _ => numbers.between(-2.0, 3.0) as f32,
        });
    }
    for d in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, -0.0, 0.0], [1.0, -1e-9, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    {
        let [x, y, z] = d;
        all.push(BandwidthQuery { incoming: d, outgoing: d, direction: [x, z, y], uv: [0.25, 0.75] });
    }
    all
}

/// Number of look-ups whose bits differ from the CPU's, per kind.
fn differences(gpu: &Gpu, source: &str, maps: &[BandwidthMap; 3], queries: &[BandwidthQuery]) -> [usize; 3] {
    let mut counts = [0; 3];
    for (query, found) in queries.iter().zip(by_shader(gpu, source, maps, queries)) {
        let expected = [
            maps[0].brdf(query.incoming, query.outgoing),
            maps[1].environment(query.direction),
            maps[2].texture(query.uv),
        ];
        for kind in 0..3 {
            counts[kind] += usize::from(expected[kind].to_bits() != found[kind].to_bits());
        }
    }
    counts
}

#[test]
fn the_shader_has_the_bits_of_the_cpu() {
    let Some(gpu) = crate::common::gpu() else { return };
    let queries = queries();
    for tiles in [true, false] {
        assert_eq!(differences(gpu, BANDWIDTH_WGSL, &maps(tiles), &queries), [0; 3], "{tiles}");
    }
    let some = by_shader(gpu, BANDWIDTH_WGSL, &maps(true)[1..2], &queries[..50]);
    assert!(some.iter().all(|[brdf, environment, texture]| *brdf == 0.0 && *environment > 0.0 && *texture == 0.0));
}

/// Small changes of the shader, each of which the queries must detect.
const CHANGES: [(&str, &str); 16] = [
    ("BANDWIDTH_PI: f32 = 3.14159274", "BANDWIDTH_PI: f32 = 3.1416"),
    ("BANDWIDTH_HALF_PI: f32 = 1.57079637", "BANDWIDTH_HALF_PI: f32 = 1.5708"),
    ("BANDWIDTH_TAU: f32 = 6.28318548", "BANDWIDTH_TAU: f32 = 6.2832"),
    ("-4.0545664e-3", "-4.2e-3"),
    ("2.1862958e-2", "2.2e-2"),
    ("5.5912327e-2", "5.6e-2"),
    ("9.642198e-2", "9.6e-2"),
    ("0.1390863", "0.139"),
    ("0.19946566", "0.1995"),
    ("0.3332986", "0.3333"),
    ("0.99999934", "1.0001"),
    ("incoming * BANDWIDTH_CELLS + outgoing", "outgoing * BANDWIDTH_CELLS + incoming"),
    ("texture_parameters.tiles == 1u", "texture_parameters.tiles == 2u"),
    ("f32(count) - 1.0", "f32(count) - 2.0"),
    ("y < 0.0)", "y > 0.0)"),
    (".x * bandwidth_texture_parameters.scale", ".x"),
];

#[test]
fn a_changed_shader_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let queries = queries();
    let maps = maps(true);
    let noticed = |source: &str| differences(gpu, source, &maps, &queries) != [0; 3];
    assert!(!noticed(BANDWIDTH_WGSL));
    for (from, to) in CHANGES {
        assert_eq!(BANDWIDTH_WGSL.matches(from).count(), 1, "{from}");
        assert!(noticed(&BANDWIDTH_WGSL.replace(from, to)), "{from} -> {to}");
    }
}
