//! The shader of polynomial wavelet trees, compared with the CPU decoder on any adapter.

use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::pwt::shader::{PWT_FILTER_PRECISION, PWT_WGSL};
use brdfc_formats::pwt::{
    Component, Domain, LightBasis, LightCoordinates, LightMap, PwtDecoder, PwtErrors, PwtHeader, PwtPack, TextureHeader,
};
use brdfc_probe::{EVALUATE_PWT_WGSL, PwtAnswer, PwtEvaluator, PwtQuery};
use brdfc_testing::codecs::pwt::five_views;
use brdfc_testing::packs::Numbers;

const DOMAINS: [Domain; 4] = [Domain::Linear, Domain::Display, Domain::CubeRoot, Domain::Logarithm { epsilon: 0.0123 }];

/// Maximum relative error of linear values: `pow` and `exp` of a shader differ from the CPU's.
const VALUE_ERROR: f32 = 1e-4;

/// Shape of a made-up pack.
#[derive(Debug, Clone, Copy)]
struct Shape {
    size: [u32; 2],
    extent: [u32; 2],
    levels: u32,
    repeats: bool,
    views: bool,
    /// Level, channels and layers of each texture.
    textures: &'static [[u32; 3]],
}

const SHAPES: [Shape; 4] = [
    // A tile with all four textures.
    Shape {
        size: [64, 32],
        extent: [64, 32],
        levels: 4,
        repeats: true,
        views: false,
        textures: &[[0, 4, 3], [1, 2, 4], [3, 1, 5], [4, 4, 2]],
    },
    // An image smaller than its texels' extent; the first texture lacks fine levels.
    Shape {
        size: [37, 61],
        extent: [40, 64],
        levels: 3,
        repeats: false,
        views: false,
        textures: &[[1, 4, 6], [3, 1, 3]],
    },
    // One level, one layer.
    Shape { size: [13, 7], extent: [13, 7], levels: 0, repeats: false, views: false, textures: &[[0, 4, 1]] },
    // Five views of a tile; two textures begin at one level.
    Shape {
        size: [16, 8],
        extent: [16, 8],
        levels: 2,
        repeats: true,
        views: true,
        textures: &[[0, 4, 2], [0, 4, 1], [1, 2, 3]],
    },
];

/// A pack with random texels and colours, whose values stay in a sensible range.
fn pack(shape: Shape, basis: LightBasis, domain: Domain, seed: u64) -> PwtPack {
    let mut numbers = Numbers::new(seed);
    let terms = basis.terms();
    let mut triangle = Vec::new();
    let is_learned = basis.coordinates == LightCoordinates::Learned;
    for k in 0..if is_learned { 0 } else { terms } {
        triangle.extend((0..=k).map(|j| if j == k { 1.0 } else { numbers.between(-0.1, 0.1) as f32 }));
    }
    let mut textures = Vec::new();
    let mut next = 0;
    for [level, channels, layers] in shape.textures {
        let components = (0..channels * layers).map(|_| {
            next += 1;
            Component {
                channel: if is_learned { 0 } else { next % 3 },
                term: next * 5 % terms as u32,
                scale: numbers.between(0.02, 0.1) as f32,
                low: numbers.between(-0.03, 0.03) as f32,
            }
        });
        textures.push(TextureHeader { level: *level, channels: *channels, components: components.collect() });
    }
    let header = PwtHeader {
        size: shape.size,
        extent: shape.extent,
        repeats: shape.repeats,
        levels: shape.levels,
        basis,
        views: shape.views.then(five_views),
        domain,
        colour: [[0.6, 0.5, 0.4], [0.3, -0.1, -0.2], [0.05, -0.1, 0.1]],
        triangle,
        light_map: is_learned.then(|| light_map(terms, &mut numbers)),
        textures,
        errors: PwtErrors { lights: 0, psnr: 0.0, held_out_psnr: 0.0, delta_e: 0.0 },
    };
    let texels = header.textures.iter().map(|texture| {
        let levels = texture.level..=shape.levels;
        let count = levels.map(|level| (shape.extent[0] >> level) * (shape.extent[1] >> level)).sum::<u32>();
        (0..count * texture.components.len() as u32 * header.view_count()).map(|_| numbers.bits() as u8).collect()
    });
    let texels = texels.collect();
    PwtPack::new(header, texels).unwrap()
}

/// A map of random numbers.
fn light_map(terms: usize, numbers: &mut Numbers) -> LightMap {
    let texels: Vec<[f32; 3]> = (0..terms * 64).map(|_| [0; 3].map(|_| numbers.between(-0.5, 1.0) as f32)).collect();
    LightMap::new(8, &texels).unwrap()
}

/// Every coordinate with every domain; degree 5 and others; alternating shapes.
fn packs() -> Vec<PwtDecoder> {
    let mut packs = Vec::new();
    for coordinates in LightCoordinates::ALL {
        for domain in DOMAINS {
            let number = packs.len();
            let basis = LightBasis { coordinates, degree: [5, 2, 3, 5, 0][number % 5] };
            packs.push(PwtDecoder::new(pack(SHAPES[number % 3], basis, domain, 20 + number as u64)));
        }
    }
    let basis = LightBasis { coordinates: LightCoordinates::Learned, degree: 3 };
    packs.push(PwtDecoder::new(pack(SHAPES[3], basis, Domain::Display, 19)));
    packs
}

/// A light above the horizon.
fn light(numbers: &mut Numbers) -> [f32; 3] {
    let (z, phi) = (numbers.between(0.02, 1.0), numbers.between(0.0, std::f64::consts::TAU));
    let r = (1.0 - z * z).sqrt();
    [r * phi.cos(), r * phi.sin(), z].map(|c| c as f32)
}

/// Places of one level: within the image, beyond it, and on its borders.
fn queries(level: f32, count: usize, seed: u64) -> Vec<PwtQuery> {
    let mut numbers = Numbers::new(seed);
    let edges = [0.0, 1.0, -1.0, 0.5, -1e-9, 0.999_999_94, 37.25];
    let special = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]];
    let query = |k| {
        let uv = match k % 5 {
            0 => [0; 2].map(|_| edges[numbers.bits() as usize % edges.len()]),
            1 => [0; 2].map(|_| numbers.between(-2.0, 3.0) as f32),
            _ => [0; 2].map(|_| numbers.unit() as f32),
        };
        let light = if k % 20 == 0 { special[k / 20 % 3] } else { light(&mut numbers) };
        let outgoing = self::light(&mut numbers);
        PwtQuery { uv, level, light, outgoing, view: 0 }
    };
    (0..count).map(query).collect()
}

/// Levels to evaluate: whole ones, blends, and beyond both ends.
const LEVELS: [f32; 10] = [0.0, 0.25, 1.0, 1.5, 2.0, 2.75, 3.0, 3.4, 4.0, 9.0];

/// Answers at all levels, each in its own dispatch. Another test covers levels that differ between invocations.
fn answers(
    evaluator: &PwtEvaluator<'_>,
    decoder: &PwtDecoder,
    filter: FrameBlock,
    count: usize,
) -> Vec<(PwtQuery, PwtAnswer)> {
    let loaded = evaluator.load(decoder.pack(), filter).unwrap();
    let of_level = |(k, level): (usize, &f32)| {
        let views = decoder.pack().header().view_count();
        let queries: Vec<PwtQuery> = queries(*level, count, k as u64)
            .into_iter()
            .enumerate()
            .map(|(k, query)| PwtQuery { view: k as u32 % views, ..query })
            .collect();
        let found = evaluator.eval(&loaded, &queries).unwrap();
        assert_eq!(found.len(), queries.len());
        queries.into_iter().zip(found).collect::<Vec<_>>()
    };
    LEVELS.iter().enumerate().flat_map(of_level).collect()
}

/// Differences between answers and the decoder's.
#[derive(Debug, Default, Clone, Copy)]
struct Difference {
    /// Number of sums whose bits differ.
    other_bits: usize,
    /// Largest relative error of a linear value; values below 1e-3 count as 1e-3.
    value: f32,
}

fn difference(decoder: &PwtDecoder, answers: &[(PwtQuery, PwtAnswer)]) -> Difference {
    let mut found = Difference::default();
    for (query, answer) in answers {
        let weights = decoder.pack().header().weights(query.light);
        let sum = decoder.sum(query.uv, query.level, query.view, &weights);
        for (a, b) in sum.iter().zip(answer.sum) {
            found.other_bits += usize::from(a.to_bits() != b.to_bits());
        }
        let value = decoder.value(query.uv, query.level, query.outgoing, query.light);
        for (a, b) in value.iter().zip(answer.value) {
            found.value = found.value.max((a - b).abs() / a.abs().max(1e-3));
        }
    }
    found
}

#[test]
fn exact_filtering_gives_the_sums_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = PwtEvaluator::new(gpu).unwrap();
    for decoder in packs() {
        let header = decoder.pack().header();
        let answers = answers(&evaluator, &decoder, FrameBlock::exact(), 600);
        let found = difference(&decoder, &answers);
        let kind = (header.basis, header.domain.name(), header.size);
        println!("{kind:?}: {found:?}");
        assert_eq!(found.other_bits, 0, "{kind:?}: {found:?}");
        assert!(found.value < VALUE_ERROR, "{kind:?}: {found:?}");
        let lit = answers.iter().filter(|(_, answer)| answer.value != [0.0; 3]).count();
        assert!(lit > answers.len() / 3, "{kind:?}: {lit} are lit");
        assert!(answers.iter().all(|(query, answer)| query.light[2] > 0.0 || answer.value == [0.0; 3]));
    }
}

/// Error bound of the sampler for red, green and blue: the weight of each number, times the precision along both axes, and
/// between levels. Neighbouring texels differ by up to 1.
fn filter_bound(decoder: &PwtDecoder, query: &PwtQuery) -> [f32; 3] {
    let header = decoder.pack().header();
    let weights = header.weights(query.light);
    let mut bounds = [1e-5; 3];
    // Texels of the light map differ by up to 1.5, along two axes.
    let of_map = if header.light_map.is_some() { 2.0 * 1.5 * PWT_FILTER_PRECISION } else { 0.0 };
    bounds.iter_mut().for_each(|bound| *bound += of_map);
    for (component, weight) in header.components().zip(header.component_weights(&weights)) {
        let colour = header.colour[component.channel as usize];
        let largest = component.low.abs().max((component.low + component.scale).abs());
        for ((bound, weight), colour) in bounds.iter_mut().zip(weight).zip(colour) {
            *bound += 3.0 * PWT_FILTER_PRECISION * (weight * component.scale).abs() + of_map * (colour * largest).abs();
        }
    }
    bounds
}

/// The largest error of a sum, as a share of its bound.
fn share_of_bound(decoder: &PwtDecoder, answers: &[(PwtQuery, PwtAnswer)]) -> f32 {
    let mut largest = 0.0f32;
    for (query, answer) in answers {
        let weights = decoder.pack().header().weights(query.light);
        let sum = decoder.sum(query.uv, query.level, query.view, &weights);
        let bounds = filter_bound(decoder, query);
        for k in 0..3 {
            largest = largest.max((sum[k] - answer.sum[k]).abs() / bounds[k]);
        }
    }
    largest
}

#[test]
fn the_sampler_is_within_its_precision() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = PwtEvaluator::new(gpu).unwrap();
    for decoder in packs() {
        let answers = answers(&evaluator, &decoder, FrameBlock::default(), 300);
        let share = share_of_bound(&decoder, &answers);
        println!("{:?}: {share} of the bound", decoder.pack().header().size);
        assert!(share <= 1.0, "{share}");
        assert!(share > 0.01, "the sampler is not exact: {share}");
    }
}

/// Levels that differ from one invocation to the next. Software drivers have been observed to fetch from other levels
/// than requested by `textureLoad` in this case. They do not if sides halve exactly.
#[test]
fn levels_may_differ_between_invocations() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = PwtEvaluator::new(gpu).unwrap();
    for decoder in &packs()[..3] {
        let mut queries = queries(0.0, 3000, 8);
        for (k, query) in queries.iter_mut().enumerate() {
            query.level = LEVELS[k * 7 % LEVELS.len()];
        }
        let found = [FrameBlock::exact(), FrameBlock::default()].map(|filter| {
            let loaded = evaluator.load(decoder.pack(), filter).unwrap();
            let found = evaluator.eval(&loaded, &queries).unwrap();
            queries.iter().copied().zip(found).collect::<Vec<_>>()
        });
        assert_eq!(difference(decoder, &found[0]).other_bits, 0);
        assert!(share_of_bound(decoder, &found[1]) <= 1.0);
    }
}

/// Counts fetches by an instrumented shader, with a counter before every fetch.
#[test]
fn the_sampler_fetches_once_per_layer() {
    let Some(gpu) = crate::common::gpu() else { return };
    let counted = PWT_WGSL.replace("{ return texture", "{ fetch_count += 1u; return texture");
    assert_eq!(counted.matches("fetch_count").count(), 16, "eight textures, two filters");
    let all = PWT_WGSL.matches("textureLoad(").count() + PWT_WGSL.matches("textureSampleLevel(").count();
    assert_eq!(all, 16 + 5 + 1, "those of the light map and of the mesh are made once for each light and view");
    let counted = format!("var<private> fetch_count: u32 = 0u;\n{counted}");
    let entry_point = EVALUATE_PWT_WGSL.replace("return 0.0;", "return f32(fetch_count);");
    assert_ne!(entry_point, EVALUATE_PWT_WGSL);
    let evaluator = PwtEvaluator::with_shaders(gpu, &counted, &entry_point).unwrap();
    for decoder in &packs()[..3] {
        let header = decoder.pack().header();
        for (query, answer) in answers(&evaluator, decoder, FrameBlock::default(), 30) {
            assert_eq!(answer.fetches, header.fetches() as f32, "{query:?}");
        }
        for (query, answer) in answers(&evaluator, decoder, FrameBlock::exact(), 30) {
            let own = |level: u32| (query.level - level as f32).clamp(0.0, (header.levels - level) as f32);
            let texels = |level: u32| if own(level).fract() > 0.0 { 8 } else { 4 };
            let expected: u32 = header.textures.iter().map(|texture| texture.layers() * texels(texture.level)).sum();
            assert_eq!(answer.fetches, expected as f32, "{query:?}");
        }
    }
}

/// Steps of the shader and small changes of them, each of which one of the packs must detect.
const CHANGES: [(usize, &str, &str); 29] = [
    (16, "layer * pwt.views + view", "layer * pwt.views"),
    (16, "direction_mesh_weights(wo, 0u)", "direction_mesh_weights(-wo, 0u)"),
    (16, "if pwt.views == 1u {", "if pwt.views > 0u {"),
    (0, "if wi.z <= 0.0 {", "if wi.z <= -1.0 {"),
    (10, "select(n * (n + 1u) / 2u, n * n,", "select(n * (n + 1u) / 2u, n * n - 1u,"),
    (0, "pwt.triangle[at / 4u][at % 4u]", "pwt.triangle[at / 4u][at % 3u]"),
    (10, "max(wi.z, 0.0)", "max(wi.z, 0.1)"),
    (0, "let scale = 1.0 + wi.z;", "let scale = 1.001 + wi.z;"),
    (0, "terms[first - 1u] * v", "terms[first - 1u] * u"),
    (10, "2.0 * z - 1.0", "2.0 * z - 1.001"),
    (10, "let scale = 2.0 * sqrt", "let scale = 2.001 * sqrt"),
    (10, "2.0 * order - 1.0", "2.0 * order + 1.0"),
    (10, "(degree - order + 1.0)", "(degree - order + 2.0)"),
    (1, "at = within * (pwt.size / pwt.extent)", "at = within"),
    (0, "uv - floor(uv), pwt.repeats == 1u", "uv - floor(uv), pwt.repeats == 2u"),
    (0, "f32(pwt.levels - base)", "f32(pwt.levels)"),
    (0, "let blend = own - f32(finer);", "let blend = 0.0;"),
    (0, "pwt_filtered(index, layer, at, finer + k)", "pwt_filtered(index, layer, at, finer)"),
    (0, "vec2<f32>(side) - 0.5", "vec2<f32>(side) - 0.4999"),
    (0, "let d = pwt_load(index, layer, last, level);", "let d = c;"),
    (0, "((texel % side) + side) % side", "clamp(texel, vec2<i32>(0), side - 1)"),
    (0, "case 1u: { return textureLoad(pwt_texture_1,", "case 1u: { return textureLoad(pwt_texture_0,"),
    (1, "vec3<f32>(2.4)", "vec3<f32>(2.41)"),
    (1, "value <= vec3<f32>(0.04045)", "value <= vec3<f32>(0.06)"),
    (3, "- pwt.epsilon;", "- 1.01 * pwt.epsilon;"),
    (12, "wi.xy / (1.0 + wi.z) * 0.5 + 0.5", "wi.xy * 0.5 + 0.5"),
    (12, "(*weights)[0], pwt.coordinates == 3u", "(*weights)[0], pwt.coordinates == 4u"),
    (12, "at * f32(pwt.map_side) - 0.5", "at * f32(pwt.map_side) - 0.499"),
    (
        12,
        "let upper = a + weight.x * (b - a);\n    let under = c + weight.x * (d - c);\n    return upper + weight.y * (under - upper);\n}\n\n// All",
        "return a;\n}\n\n// All",
    ),
];

/// The negative control: every change above is detected.
#[test]
fn a_changed_step_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let packs = packs();
    let missed = CHANGES.iter().filter(|(pack, from, to)| {
        assert_eq!(PWT_WGSL.matches(from).count(), 1, "{from}");
        let decoder = PWT_WGSL.replace(from, to);
        let evaluator = PwtEvaluator::with_shaders(gpu, &decoder, EVALUATE_PWT_WGSL).unwrap();
        let pack = &packs[*pack];
        let found = difference(pack, &answers(&evaluator, pack, FrameBlock::exact(), 100));
        found.other_bits == 0 && found.value <= VALUE_ERROR
    });
    let missed: Vec<_> = missed.collect();
    assert!(missed.is_empty(), "{missed:?}");
    let coarser = PWT_WGSL.replace("pwt_sampler, at, layer, own", "pwt_sampler, at, layer, own + 0.1");
    let evaluator = PwtEvaluator::with_shaders(gpu, &coarser, EVALUATE_PWT_WGSL).unwrap();
    let answers = answers(&evaluator, &packs[0], FrameBlock::default(), 100);
    assert!(share_of_bound(&packs[0], &answers) > 1.0, "the bound of the sampler is tight enough");
}
