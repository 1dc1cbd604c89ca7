//! Packs of every kind with queries, what is bound for them, and what the CPU decoders say: for tests of shaders that engines
//! compile.

use crate::flat_btf::{self, Factors, SMALL};
use crate::packs::{Numbers, packs, pairs, tables};
use brdfc_formats::PackKind;
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use brdfc_formats::bindings::{Binding, FrameBlock, Resource};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::flat_btf::factored::ShadowFormat;
use brdfc_formats::flat_btf::{
    BlendedDirection, FlatBtfDecoder, FlatBtfFile, FlatBtfParts, FlatValues, SampledDirections, ViewWeights,
};
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_formats::table::{TableDecoder, TablePack};
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use std::collections::{BTreeMap, BTreeSet};

/// Queries of a case: 100 x 100.
pub const SIDE: usize = 100;

/// How far a decoder may be from its twin: of the value and what is added to it, of BRDFs με.
const BOUND: f64 = 1e-4;

/// Three groups of four numbers.
pub type Query = [[f32; 4]; 3];

/// A pack, and what is asked of it.
pub struct Case {
    pub name: String,
    pub decoder: PackKind,
    /// What is bound.
    pub bindings: Vec<Binding<'static>>,
    /// What changes with the frame.
    pub frame: FrameBlock,
    /// The same as files: one, or several maps.
    pub files: Vec<Vec<u8>>,
    pub queries: Vec<Query>,
    /// The CPU's answers, and what is added to each before errors are divided by it.
    pub expected: Vec<([f32; 4], f32)>,
}

/// Of exact weights.
const FRAME: FrameBlock = FrameBlock { distance_scale: 1.0, sampler_filters: false, blend: Filter::Bilinear };

impl Case {
    /// Slots, names and what is bound, the frame's block as the bytes that it has.
    pub fn bound(&self) -> impl Iterator<Item = (u32, &str, Resource<'_>)> {
        self.bindings.iter().map(|binding| {
            let resource = match &binding.resource {
                Resource::Frame => Resource::Uniform(self.frame.to_bytes().to_vec().into()),
                other => other.clone(),
            };
            (binding.slot, &*binding.name, resource)
        })
    }

    /// Whether coordinates repeat that a sampler of this name is asked at.
    pub fn repeats(&self, sampler: Option<&str>) -> bool {
        let is_it = |binding: &&Binding<'_>| Some(&*binding.name) == sampler;
        self.bindings.iter().find(is_it).is_some_and(|it| it.resource == Resource::Sampler { repeats: true })
    }
    /// The largest error of answers, relative to the value and what is added to it.
    pub fn largest_error(&self, found: &[[f32; 4]]) -> f64 {
        assert_eq!(found.len(), self.expected.len());
        let of = |(found, (expected, floor)): (&[f32; 4], &([f32; 4], f32))| {
            let error = |k: usize| {
                let [found, expected] = [found[k], expected[k]].map(f64::from);
                let share = (found - expected).abs() / (expected.abs() + f64::from(*floor));
                if share.is_nan() { f64::INFINITY } else { share }
            };
            (0..4).map(error).fold(0.0, f64::max)
        };
        found.iter().zip(&self.expected).map(of).fold(0.0, f64::max)
    }
}

pub(crate) fn four([x, y, z]: [f32; 3], w: f32) -> [f32; 4] {
    [x, y, z, w]
}

/// Pairs at levels of detail; the shader filters.
pub(crate) fn brdf_queries(levels: u32, seed: u64) -> (Vec<DirectionPair>, Vec<Query>) {
    let pairs = pairs(SIDE * SIDE, seed);
    let single = |v: [f64; 3]| v.map(|c| c as f32);
    let query = |(k, pair): (usize, &DirectionPair)| {
        let level = (k % 7) as f32 / 6.0 * levels as f32;
        [four(single(pair.incoming), level), four(single(pair.outgoing), 0.0), [0.0; 4]]
    };
    let queries: Vec<Query> = pairs.iter().enumerate().map(query).collect();
    // As the shader sees them.
    let double = |q: [f32; 4]| [q[0], q[1], q[2]].map(f64::from);
    (queries.iter().map(|[a, b, _]| DirectionPair::new(double(*a), double(*b))).collect(), queries)
}

/// Tables of every kind of look-up.
pub(crate) fn some_tables() -> Vec<(String, TablePack)> {
    let wanted = [
        "symmetry 3, layers 1",
        "symmetry 12, layers 3",
        "symmetry 0, layers 1, curve",
        "symmetry 15, layers 3, curve",
        "symmetry 5, layers 3, cropped",
    ];
    let some: Vec<_> = tables().into_iter().filter(|(name, _)| wanted.contains(&name.as_str())).collect();
    assert!(some.len() > 3);
    some
}

fn of_tables() -> Vec<Case> {
    let case = |(name, pack): (String, TablePack)| {
        let decoder = TableDecoder::new(&pack);
        let (pairs, queries) = brdf_queries(pack.levels(), 11);
        let floor = pack.header().mean * pack.header().bias;
        let expected =
            pairs.iter().zip(&queries).map(|(pair, [a, ..])| (four(decoder.eval_at(*pair, a[3]), 0.0), floor));
        let expected = expected.collect();
        let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
        Case { name, decoder: PackKind::Table, bindings, frame: FRAME, files, queries, expected }
    };
    some_tables().into_iter().map(case).collect()
}

/// Wavelet packs of every kind of look-up.
pub(crate) fn some_wavelets() -> Vec<(String, WaveletPack, Filter)> {
    let filters = [Filter::Nearest, Filter::Slices, Filter::Bilinear];
    let wanted =
        |name: &str| name.starts_with("lifted") || name.contains("cropped") || name.contains("levels 4, channels 3");
    let some = packs().into_iter().filter(|(name, _)| wanted(name)).step_by(3).enumerate();
    let some: Vec<_> = some.map(|(k, (name, pack))| (name, pack, filters[k % 3])).collect();
    assert!(some.len() > 4);
    some
}

fn of_wavelets() -> Vec<Case> {
    let case = |(k, (name, pack, filter)): (usize, (String, WaveletPack, Filter))| {
        let decoder = WaveletDecoder::new(&pack);
        let (pairs, queries) = brdf_queries(pack.header.levels, 12);
        let floor = pack.header.mean * pack.header.bias;
        let expected =
            pairs.iter().zip(&queries).map(|(pair, [a, ..])| (four(decoder.eval(*pair, a[3], filter), 0.0), floor));
        let expected = expected.collect();
        let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(k % 2 == 0)]);
        let (name, decoder) = (format!("{name}, {filter:?}"), PackKind::Wavelet);
        let frame = FrameBlock { blend: filter, ..FRAME };
        Case { name, decoder, bindings, frame, files, queries, expected }
    };
    some_wavelets().into_iter().enumerate().map(case).collect()
}

/// Places on pictures, levels and lights.
pub(crate) fn tree_queries() -> Vec<Query> {
    let mut numbers = Numbers::new(13);
    let query = |k: usize| {
        let [u, v] = [0; 2].map(|_| numbers.between(-0.2, 1.2) as f32);
        let [x, y, z] = flat_btf::unit_vector(&mut numbers);
        [[u, v, (k % 9) as f32 / 4.0, 0.0], [x, y, z.abs(), 0.0], [0.0; 4]]
    };
    (0..SIDE * SIDE).map(query).collect()
}

fn of_trees() -> Vec<Case> {
    let queries = tree_queries();
    let case = |(name, pack): (&str, PwtPack)| {
        let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
        let decoder = PwtDecoder::new(pack);
        let answer = |[a, b, _]: &Query| (four(decoder.value([a[0], a[1]], a[2], [b[0], b[1], b[2]]), 0.0), 1e-2);
        let expected = queries.iter().map(answer).collect();
        let (name, decoder, queries) = (name.to_owned(), PackKind::Pwt, queries.clone());
        Case { name, decoder, bindings, frame: FRAME, files, queries, expected }
    };
    crate::pwt::packs().into_iter().map(case).collect()
}

/// Flat BTFs of every kind of values that files have.
pub(crate) fn some_flat_btfs() -> [(&'static str, FlatBtfDecoder); 2] {
    let whole = flat_btf::parts(SMALL, 4);
    let compact = flat_btf::displacements(SMALL, 1, 4).into();
    let factors = Factors { levels: 3, groups: 3, wide_groups: 1, shadow: ShadowFormat::R8 };
    let factored = FlatValues::Factored(Box::new(flat_btf::factored(SMALL, factors, 5)));
    [
        ("light form", FlatBtfParts { values: FlatValues::None, ..whole.clone() }),
        ("factored, displacements", FlatBtfParts { values: factored, indirection: compact, ..whole }),
    ]
    .map(|(name, parts)| (name, FlatBtfDecoder::new(parts).unwrap()))
}

/// Places, levels, views and lights.
pub(crate) fn flat_queries() -> Vec<Query> {
    let mut numbers = Numbers::new(14);
    let query = |k: usize| {
        let [u, v] = [0; 2].map(|_| numbers.between(-1.0, 2.0) as f32);
        let [view, light] = [0; 2].map(|_| flat_btf::unit_vector(&mut numbers)).map(|[x, y, z]| [x, y, z.abs(), 0.0]);
        [[u, v, (k % 9) as f32 / 4.0, 0.0], view, light]
    };
    (0..SIDE * SIDE).map(query).collect()
}

fn of_flat_btfs() -> Vec<Case> {
    let queries = flat_queries();
    let case = |(name, decoder): (&str, FlatBtfDecoder)| {
        let directions = SampledDirections::of(&decoder.parts().values).unwrap();
        let bindings = decoder.bindings(true, directions.as_ref()).into_owned();
        let answer = |[a, b, c]: &Query| {
            let [view, light] = [b, c].map(|v| [v[0], v[1], v[2]]);
            (four(flat_value(&decoder, directions.as_ref(), [a[0], a[1]], a[2], [view, light]), 0.0), 1e-2)
        };
        let expected = queries.iter().map(answer).collect();
        let (name, queries) = (name.to_owned(), queries.clone());
        let files = vec![FlatBtfFile::new(decoder, None).unwrap().to_bytes(true)];
        Case { name, decoder: PackKind::FlatBtf, bindings, frame: FRAME, files, queries, expected }
    };
    some_flat_btfs().into_iter().map(case).collect()
}

/// As `FlatMaterial::value` of the renderer.
fn flat_value(
    decoder: &FlatBtfDecoder,
    directions: Option<&SampledDirections>,
    uv: [f32; 2],
    level: f32,
    [view, light]: [[f32; 3]; 2],
) -> [f32; 3] {
    let Some(directions) = directions else {
        return decoder.light_form(uv, view, light);
    };
    let ([views, lights], dimmed) = blends(directions, [view, light]);
    decoder.value(uv, level, views, lights).map(|value| value * dimmed)
}

/// View and light among the sampled ones, and what is left of a light below all of these.
pub(crate) fn blends(
    SampledDirections { views, lights, lowest_light }: &SampledDirections,
    [view, light]: [[f32; 3]; 2],
) -> ([BlendedDirection; 2], f32) {
    let blended = |mesh: &DirectionMesh, direction| {
        let (indices, weights) = mesh.weights(direction);
        BlendedDirection { direction, samples: ViewWeights { indices, weights } }
    };
    ([blended(views, view), blended(lights, light)], (light[2] / lowest_light).min(1.0))
}

fn of_bandwidth() -> Vec<Case> {
    let mut numbers = Numbers::new(15);
    let mut map = |kind, size: [u32; 2], largest: f64| {
        let header = BandwidthHeader { kind, epsilon: 0.01, transformed: size };
        let values: Vec<f32> = (0..size[0] * size[1]).map(|_| numbers.between(0.0, largest) as f32).collect();
        BandwidthMap::new(header, size, &values).unwrap()
    };
    let maps = [
        map(BandwidthKind::Brdf, [256; 2], 30.0),
        map(BandwidthKind::Environment, [512, 256], 80.0),
        map(BandwidthKind::Texture { metres: [0.01; 2], tiles: true }, [300, 77], 3e6),
    ];
    let queries: Vec<Query> = (0..SIDE * SIDE)
        .map(|_| {
            let [i, o] = [0; 2].map(|_| flat_btf::unit_vector(&mut numbers)).map(|[x, y, z]| [x, y, z.abs(), 0.0]);
            [i, o, [numbers.between(-2.0, 3.0) as f32, numbers.between(-2.0, 3.0) as f32, 0.0, 0.0]]
        })
        .collect();
    let three = |v: &[f32; 4]| [v[0], v[1], v[2]];
    let answer = |[a, b, c]: &Query| {
        let [brdf, environment, texture] = &maps;
        ([brdf.brdf(three(a), three(b)), environment.environment(three(a)), texture.texture([c[0], c[1]]), 0.0], 1.0)
    };
    let expected = queries.iter().map(answer).collect();
    let bindings = maps.iter().flat_map(|map| map.bindings().into_owned()).collect();
    let files = maps.iter().map(|map| map.to_bytes(true)).collect();
    let (name, decoder) = ("three maps".to_owned(), PackKind::Bandwidth);
    vec![Case { name, decoder, bindings, frame: FRAME, files, queries, expected }]
}

fn of_importance() -> Vec<Case> {
    let case = |header: ImportanceHeader| {
        let mut numbers = Numbers::new(16);
        let texels = (0..header.rows() * header.samples).map(|_| {
            let [x, y, z] = flat_btf::unit_vector(&mut numbers);
            [x, y, z.abs(), numbers.between(-6.0, 6.0).exp2() as f32]
        });
        let pack = ImportancePack::new(header, texels.collect()).unwrap();
        let queries: Vec<Query> = (0..SIDE * SIDE)
            .map(|_| {
                let [x, y, z] = flat_btf::unit_vector(&mut numbers);
                [[x, y, z.abs(), (numbers.bits() % 5000) as f32], [0.0; 4], [0.0; 4]]
            })
            .collect();
        let answer = |[a, ..]: &Query| {
            let (incoming, inverse_density) = pack.sample([a[0], a[1], a[2]], a[3] as u32);
            (four(incoming, inverse_density), 1.0)
        };
        let expected = queries.iter().map(answer).collect();
        let name = format!("{} polar angles, {} azimuths", header.polar, header.azimuths);
        let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
        Case { name, decoder: PackKind::Importance, bindings, frame: FRAME, files, queries, expected }
    };
    vec![
        case(ImportanceHeader { polar: 64, azimuths: 1, samples: 50 }),
        case(ImportanceHeader { polar: 7, azimuths: 12, samples: 64 }),
    ]
}

/// All of them.
pub fn cases() -> Vec<Case> {
    [of_tables(), of_wavelets(), of_trees(), of_flat_btfs(), of_bandwidth(), of_importance()]
        .into_iter()
        .flatten()
        .collect()
}

/// Holds answers to all cases against the CPU's, and prints the largest errors.
///
/// # Panics
/// Where one is beyond the bound; where answers would not show an error.
pub fn check(what: &str, cases: &[Case], found: &[Vec<[f32; 4]>]) {
    assert_eq!(cases.len(), found.len());
    let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
    for (case, found) in cases.iter().zip(found) {
        let error = case.largest_error(found);
        println!("{what}: {}, {}: {error:.1e}", case.decoder.name(), case.name);
        let most = largest.entry(case.decoder.name()).or_default();
        *most = most.max(error);
        // What is all black would agree with nothing.
        assert!(case.expected.iter().filter(|(value, _)| value[0] > 0.0).count() > SIDE * SIDE / 10, "{}", case.name);
        // Answers of other queries are noticed.
        let mut shifted = found.clone();
        shifted.rotate_left(1);
        let is_constant = case.expected.iter().all(|value| *value == case.expected[0]);
        assert!(is_constant || case.largest_error(&shifted) > BOUND, "{}", case.name);
    }
    let decoders: BTreeSet<&str> = cases.iter().map(|case| case.decoder.name()).collect();
    assert!(largest.len() == decoders.len() && decoders.len() > 3);
    assert!(largest.values().all(|error| *error < BOUND), "{what}: {largest:?}");
    for (decoder, error) in largest {
        println!("agrees: {what}, {decoder}: {error:.1e}");
    }
}
