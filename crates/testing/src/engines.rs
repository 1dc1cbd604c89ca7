//! Packs of every kind with queries, bindings and the answers of the CPU decoders, for tests of shaders that engines
//! compile.

use crate::packs::pairs;
use brdfc_formats::bindings::{Binding, FrameBlock, Resource};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::Filter;
use brdfc_formats::{Answer, PackKind};
use brdfc_shaders::Language;
use std::collections::{BTreeMap, BTreeSet};

/// Queries per case: 64 x 64.
pub const SIDE: usize = 64;

/// Maximum difference between a decoder and its twin, relative to the value plus an offset, which for BRDFs is με.
const BOUND: f64 = 1e-4;

/// Three groups of four numbers.
pub type Query = [[f32; 4]; 3];

/// A pack with queries.
pub struct Case {
    pub name: String,
    pub decoder: PackKind,
    /// Resources of the decoder.
    pub bindings: Vec<Binding<'static>>,
    /// Frame-dependent parameters.
    pub frame: FrameBlock,
    /// The same resources as files: one, or several maps.
    pub files: Vec<Vec<u8>>,
    pub queries: Vec<Query>,
    /// The CPU's answers, and the offset that is added to each before errors are divided by it.
    pub expected: Vec<([f32; 4], f32)>,
}

/// Frame block with exact weights.
pub(crate) const EXACT: FrameBlock =
    FrameBlock { distance_scale: 1.0, sampler_filters: false, blend: Filter::Bilinear };

impl Case {
    /// Slots, names and resources. The frame's block has its own bytes.
    pub fn bound(&self) -> impl Iterator<Item = (u32, &str, Resource<'_>)> {
        self.bindings.iter().map(|binding| {
            let resource = match &binding.resource {
                Resource::Frame => Resource::Uniform(self.frame.to_bytes().to_vec().into()),
                other => other.clone(),
            };
            (binding.slot, &*binding.name, resource)
        })
    }

    /// Returns true if coordinates of a sampler with this name repeat.
    pub fn repeats(&self, sampler: Option<&str>) -> bool {
        let is_it = |binding: &&Binding<'_>| Some(&*binding.name) == sampler;
        self.bindings.iter().find(is_it).is_some_and(|it| it.resource == Resource::Sampler { repeats: true })
    }
    /// Largest error of the answers, relative to the value plus its offset.
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

/// Code with which a user of a decoder answers the query `a`, `b` and `c`: WGSL, or GLSL and HLSL after [`macros`].
pub fn call(decoder: PackKind) -> String {
    let Answer { body, of_struct, .. } = decoder.descriptor().answer;
    // Other languages have no function that takes the struct.
    of_struct.map_or(body.to_owned(), |answer| answer.numbers_of(body))
}

/// Preprocessor directives that define the WGSL names of a [`call`] in another language.
pub fn macros(language: Language) -> String {
    let vector = match language {
        Language::Wgsl => return String::new(),
        Language::Hlsl => "float4",
        _ => "vec4",
    };
    format!("#define vec4f {vector}\n#define u32 uint\n#define select(no, yes, is) ((is) ? (yes) : (no))\n")
}

pub(crate) fn four([x, y, z]: [f32; 3], w: f32) -> [f32; 4] {
    [x, y, z, w]
}

/// Pairs at levels of detail, filtered by the shader.
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

/// Compares answers to all cases with the CPU's, and prints the largest errors.
///
/// # Panics
/// If an answer is beyond the bound, or if the check could not detect an error.
pub fn check(what: &str, cases: &[Case], found: &[Vec<[f32; 4]>]) {
    assert_eq!(cases.len(), found.len());
    let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
    for (case, found) in cases.iter().zip(found) {
        let error = case.largest_error(found);
        println!("{what}: {}, {}: {error:.1e}", case.decoder.name(), case.name);
        let most = largest.entry(case.decoder.name()).or_default();
        *most = most.max(error);
        // All-black answers would make the check meaningless.
        assert!(case.expected.iter().filter(|(value, _)| value[0] > 0.0).count() > SIDE * SIDE / 10, "{}", case.name);
        // The control: answers of other queries are detected.
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
