//! The shader of flat BTFs, compared with the CPU decoder on any adapter.

use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::direction::from_polar;
use brdfc_formats::flat_btf::factored::shader::FACTORED_FILTER_PRECISION;
use brdfc_formats::flat_btf::shader::flat_btf_value_wgsl;
use brdfc_formats::flat_btf::{
    FlatBtfDecoder, FlatBtfParts, MacroSurface, MarchSteps, Relief, SeenPoint, Vdim, VdimHeader,
};
use brdfc_gpu::Gpu;
use brdfc_probe::{FlatBtfAnswer, FlatBtfEvaluator, FlatBtfQuery};
use brdfc_render::flat::FlatMaterial;
use brdfc_testing::codecs::flat_btf::{
    BASE, Factors, MATERIALS, SMALL, Sizes, compact_indirections, factored, indirections, layer_header, layers, relief,
    sampled_relief,
};
use brdfc_testing::packs::{Numbers, unit_vector};
use std::f64::consts::{FRAC_PI_2, PI};

const WITH_RESIDUAL: Factors = Factors { groups: 3, wide_groups: 1, residual: 2, ..BASE };
const WITHOUT: Factors = Factors { groups: 1, residual: 0, ..WITH_RESIDUAL };

/// A base alone, materials, and components with and without a residual, with one sheet and three, and with other steps
/// than the default.
fn assets(seed: u64) -> Vec<FlatMaterial> {
    let steps = MarchSteps { sight: 40, refine: 4, both: 45 };
    [
        (Sizes { sheets: 1, ..SMALL }, BASE, None),
        (SMALL, MATERIALS, None),
        (SMALL, WITH_RESIDUAL, None),
        (Sizes { flat: 16, plane: 32, views: 7, lights: 12, ..SMALL }, WITHOUT, None),
        // Sides that are not powers of two.
        (Sizes { flat: 5, plane: 12, views: 4, ..SMALL }, WITHOUT, Some(steps)),
    ]
    .map(|(sizes, factors, steps)| {
        let layers = layers(sizes, seed);
        let parts = FlatBtfParts::new(layers, factored(sizes, factors, seed + 1));
        let decoder = FlatBtfDecoder::new(parts);
        let steps = steps.unwrap_or(decoder.steps());
        FlatMaterial::new(decoder.with_steps(steps), 1).unwrap()
    })
    .to_vec()
}

/// Indirection maps with materials and shadows, with components and without shadows, and of compact samples.
fn sampled_assets(seed: u64) -> [FlatMaterial; 3] {
    type MakeMap = fn(Sizes, u32, u64) -> Vdim;
    let large = Sizes { flat: 16, plane: 12, views: 7, lights: 12, ..SMALL };
    let cases: [(Sizes, Factors, bool, MakeMap); 3] = [
        (SMALL, MATERIALS, true, indirections),
        (large, WITHOUT, false, indirections),
        (Sizes { plane: 12, ..SMALL }, MATERIALS, true, compact_indirections),
    ];
    cases.map(|(sizes, factors, shadows, map)| {
        let relief = sampled_relief(sizes, shadows, |lights| map(sizes, lights, seed));
        let parts = FlatBtfParts::new(relief, factored(sizes, factors, seed + 1));
        FlatMaterial::new(FlatBtfDecoder::new(parts), 1).unwrap()
    })
}

/// Random queries, and views and lights along the normal, at the horizon and below it.
fn queries(count: usize, seed: u64) -> Vec<FlatBtfQuery> {
    let mut numbers = Numbers::new(seed);
    let edges = [0.0, 1.0, -1.0, 0.5, -1e-9, 0.999_999_94, 37.25];
    let ends =
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, -0.8, 0.0], [0.8, -1e-9, 0.6], [0.0, 0.6, -0.8], [0.0, 0.998, 0.0625]];
    let levels = [0.0, -2.0, 0.5, 1.0, 1.75, 3.0, 9.0];
    let query = |_| {
        let uv = match numbers.bits() % 5 {
            0 => [0; 2].map(|_| edges[numbers.bits() as usize % edges.len()]),
            _ => [0; 2].map(|_| numbers.between(-2.0, 3.0) as f32),
        };
        let level = match numbers.bits() % 3 {
            0 => levels[numbers.bits() as usize % levels.len()],
            _ => numbers.between(0.0, 2.5) as f32,
        };
        let [view, light] = [0; 2].map(|_| match numbers.bits() % 9 {
            0 => ends[numbers.bits() as usize % ends.len()],
            _ => unit_vector(&mut numbers),
        });
        let surface = match numbers.bits() % 3 {
            0 => MacroSurface::PLANE,
            _ => MacroSurface {
                curvature: [0; 3].map(|_| numbers.between(-1.0, 1.0) as f32),
                height: [0.0, 0.2][numbers.bits() as usize % 2],
                stretch: match numbers.bits() % 3 {
                    0 => MacroSurface::SQUARE,
                    _ => stretch([0; 3].map(|_| numbers.between(-1.0, 1.0) as f32)),
                },
            },
        };
        FlatBtfQuery { uv, level, view, light, surface }
    };
    (0..count).map(query).collect()
}

/// Tiles that are stretched, sheared, turned, and mirrored for some.
fn stretch([wider, shear, turn]: [f32; 3]) -> [f32; 4] {
    let width = turn.signum() * (1.5 + wider);
    let (sine, cosine) = (3.0 * turn).sin_cos();
    [cosine * width, cosine * shear - sine / width.abs(), sine * width, sine * shear + cosine / width.abs()]
}

/// Answer of the CPU.
fn expected(material: &FlatMaterial, query: &FlatBtfQuery) -> FlatBtfAnswer {
    let FlatBtfQuery { uv, level, view, light, surface } = *query;
    let decoder = material.decoder();
    let look = decoder.look(uv, level, view, surface);
    let point = look.point();
    FlatBtfAnswer {
        at: point.at,
        height: point.height,
        sheet: point.sheet as u32,
        parameters: look.parameters(),
        rise: point.rise,
        value: look.shaded(material.directions(), light),
    }
}

/// Number of numbers whose bits differ from the CPU's: visible points, parameters, values.
fn differences(material: &FlatMaterial, queries: &[FlatBtfQuery], found: &[FlatBtfAnswer]) -> [usize; 3] {
    assert_eq!(queries.len(), found.len());
    let mut counts = [0; 3];
    for (query, found) in queries.iter().zip(found) {
        let expected = expected(material, query);
        let numbers = |of: &FlatBtfAnswer| {
            let seen = [of.at[0], of.at[1], of.height, of.sheet as f32, of.rise];
            [seen.to_vec(), of.parameters.to_vec(), of.value.to_vec()]
        };
        for (count, (a, b)) in counts.iter_mut().zip(numbers(&expected).iter().zip(numbers(found))) {
            let differ = a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            if differ > 0 && *count == 0 {
                println!("{query:?}: {expected:?}, by the shader {found:?}");
            }
            *count += differ;
        }
    }
    counts
}

fn answers(
    evaluator: &FlatBtfEvaluator<'_>,
    material: &FlatMaterial,
    frame: FrameBlock,
    queries: &[FlatBtfQuery],
) -> Vec<FlatBtfAnswer> {
    let loaded = evaluator.load(material.decoder(), frame, material.directions()).unwrap();
    evaluator.eval(&loaded, queries).unwrap()
}

#[test]
fn manual_filtering_gives_the_bits_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    let mut sheets = [0; 3];
    for (k, material) in assets(10).into_iter().enumerate() {
        let queries = queries(5000, k as u64);
        let found = answers(&evaluator, &material, FrameBlock::exact(), &queries);
        assert_eq!(differences(&material, &queries, &found), [0; 3], "{k}");
        let lit = found.iter().filter(|answer| answer.value != [0.0; 3]).count();
        assert!((1500..4500).contains(&lit), "{k}: most are lit, not all: {lit}");
        found.iter().for_each(|answer| sheets[answer.sheet as usize] += 1);
        // The steps are in the uniform block: other ones change points and values.
        let other = material.decoder().clone().with_steps(MarchSteps { sight: 3, refine: 0, both: 6 });
        let other = FlatMaterial::new(other, 1).unwrap();
        let [seen, parameters, values] = differences(&other, &queries, &found);
        assert!(seen > 1000 && parameters > 1000 && values > 1000, "{k}: {seen} {parameters} {values}");
    }
    assert!(sheets.iter().all(|count| *count > 0), "{sheets:?}");
}

#[test]
fn indirection_maps_have_the_bits_of_the_cpu_decoder() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    for (k, material) in sampled_assets(20).into_iter().enumerate() {
        let queries = queries(5000, k as u64 + 9);
        let found = answers(&evaluator, &material, FrameBlock::exact(), &queries);
        assert_eq!(differences(&material, &queries, &found), [0; 3], "{k}");
        let lit = found.iter().filter(|answer| answer.value != [0.0; 3]).count();
        assert!((1500..4500).contains(&lit), "{k}: most are lit, not all: {lit}");
        // The control: another map.
        let [seen, parameters, values] = differences(&sampled_assets(30)[k], &queries, &found);
        assert!(seen > 1000 && parameters > 1000 && values > 1000, "{k}: {seen} {parameters} {values}");
    }
}

/// Blending by the sampler stays within its precision of each block's range. Blocks of every other texel have displacements
/// and heights that are hundreds of times larger: where the sampler reached into one, the difference would show.
#[test]
fn the_sampler_never_reaches_the_next_block() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    let header =
        VdimHeader { size: 8, block: 1, polar_angles: 4, azimuth_rows: 5, largest_angle: 1.25, levels: 1, lights: 0 };
    let is_quiet = |[i, j]: [u32; 2]| (i + j).is_multiple_of(2);
    let seen = |texel: [u32; 2], k: u32, a: u32| {
        let scale = if is_quiet(texel) { 0.05 } else { 50.0 };
        let (along, turn) = (scale * k as f32 / 3.0, 1.5 * a as f32);
        SeenPoint { displacement: [along * turn.cos(), along * turn.sin()], height: scale * ((k + a) % 3) as f32 / 2.0 }
    };
    let map = Vdim::of_views(header, vec![[0.0; 2]; 64], seen).unwrap();
    let relief = Relief::sampled(map.clone(), None).unwrap();
    let parts = FlatBtfParts::new(relief, factored(SMALL, BASE, 3));
    let material = FlatMaterial::new(FlatBtfDecoder::new(parts), 1).unwrap();
    // At the corners and edges of blocks, and at random places in them; in the middle and at the edges of texels.
    let mut numbers = Numbers::new(6);
    let polar = [0.0, 1e-4, 0.6, 1.2499, 1.25, 1.5];
    let azimuths = [0.0, 1e-5, -1e-5, 1.0, FRAC_PI_2, PI, -FRAC_PI_2];
    let mut queries = Vec::new();
    for texel in 0..64u32 {
        for polar in polar {
            for azimuth in azimuths {
                let within = [0; 2].map(|_| [0.001, 0.5, 0.999][numbers.bits() as usize % 3]);
                let uv = [(texel % 8) as f32 + within[0], (texel / 8) as f32 + within[1]].map(|c| c / 8.0);
                let azimuth = azimuth + if numbers.bits().is_multiple_of(4) { numbers.between(0.0, 6.0) } else { 0.0 };
                let view = from_polar(polar, azimuth).map(|c| c as f32);
                queries.push(FlatBtfQuery { uv, level: -1.0, view, light: view, surface: MacroSurface::PLANE });
            }
        }
    }
    let found = answers(&evaluator, &material, FrameBlock::default(), &queries);
    let mut largest = [0.0f32; 2];
    for (query, found) in queries.iter().zip(found) {
        let texel = query.uv.map(|c| (c * 8.0) as u32);
        let expected = expected(&material, query);
        let off = [0, 1].map(|k| found.parameters[k] - expected.parameters[k]).map(|d| d - d.round());
        let off = off[0].hypot(off[1]).max((found.rise - expected.rise).abs());
        let kind = usize::from(!is_quiet(texel));
        largest[kind] = largest[kind].max(off);
    }
    // The range of a quiet block is 0.05; two axes, and directions that are normalised again.
    assert!(largest[0] <= 4.0 * 0.05 / 256.0, "{largest:?}");
    // The control: a quarter of a sample further, the sampler blends the next block.
    let broken = flat_btf_value_wgsl().replace("* samples + inside + 0.5)", "* samples + inside + 0.75)");
    let broken = FlatBtfEvaluator::with_shader(gpu, &broken).unwrap();
    let leaks =
        answers(&broken, &material, FrameBlock::default(), &queries).iter().zip(&queries).any(|(found, query)| {
            is_quiet(query.uv.map(|c| (c * 8.0) as u32)) && (found.rise - expected(&material, query).rise).abs() > 0.1
        });
    assert!(leaks, "a sampler that reaches the next block shows");
}

/// Layers of one height and random displacements: rays end where they end without a sampler, and parameters are within
/// the precision of filters along three axes.
#[test]
fn the_sampler_is_within_its_precision() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    let mut numbers = Numbers::new(4);
    let moved: Vec<[f32; 2]> = (0..64).map(|_| [0; 2].map(|_| numbers.between(0.0, 0.25) as f32)).collect();
    let layers = relief(layer_header(SMALL), |[column, row]| ([100, 40, 200], [moved[(8 * row + column) as usize]; 3]));
    let parts = FlatBtfParts::new(layers, factored(SMALL, BASE, 3));
    let material = FlatMaterial::new(FlatBtfDecoder::new(parts), 1).unwrap();
    let queries = queries(5000, 3);
    let mut largest = [0.0f32; 2];
    for (query, found) in queries.iter().zip(answers(&evaluator, &material, FrameBlock::default(), &queries)) {
        let expected = expected(&material, query);
        let apart = |a: [f32; 2], b: [f32; 2]| [0, 1].map(|k| (a[k] - b[k]) - (a[k] - b[k]).round());
        let all = [apart(expected.at, found.at), apart(expected.parameters, found.parameters)];
        for (largest, [x, y]) in largest.iter_mut().zip(all) {
            *largest = largest.max(x.abs()).max(y.abs());
        }
    }
    let bound = 3.0 * FACTORED_FILTER_PRECISION * 0.25;
    println!("largest differences {largest:?}, bound {bound}");
    assert!(largest[0] < 2e-5 && largest[1] < bound, "{largest:?} of {bound}");
    assert!(largest[1] > 1e-7, "the sampler is not exact");
}

/// Most rays through any layers end near where they end without a sampler; few jump.
#[test]
fn few_rays_jump_with_the_sampler() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = FlatBtfEvaluator::new(gpu).unwrap();
    let changed = flat_btf_value_wgsl().replace("flat_btf_sampler, at, level", "flat_btf_sampler, at + 0.05, level");
    let changed = FlatBtfEvaluator::with_shader(gpu, &changed).unwrap();
    for (k, material) in assets(20).into_iter().enumerate() {
        let queries = queries(5000, 3);
        let far = |evaluator: &FlatBtfEvaluator<'_>| {
            let found = answers(evaluator, &material, FrameBlock::default(), &queries);
            let is_far = |(query, found): &(&FlatBtfQuery, &FlatBtfAnswer)| {
                let expected = expected(&material, query);
                (expected.at[0] - found.at[0]).hypot(expected.at[1] - found.at[1]) > 0.02
            };
            queries.iter().zip(&found).filter(is_far).count()
        };
        let [right, shifted] = [&evaluator, &changed].map(far);
        println!("{k}: {right} of {} rays jump, {shifted} with shifted look-ups", queries.len());
        assert!(right < 250 && shifted > 5 * right, "{k}: {right} {shifted}");
    }
}

/// Constants of the shader and small changes of them, each of which the queries must detect.
const CHANGES: [(&str, &str); 59] = [
    ("FLAT_BTF_TEXELS_PER_STEP: f32 = ", "FLAT_BTF_TEXELS_PER_STEP: f32 = 0.1 + "),
    ("FLAT_BTF_MIN_COSINE: f32 = ", "FLAT_BTF_MIN_COSINE: f32 = 0.001 + "),
    ("FLAT_BTF_RISE: f32 = ", "FLAT_BTF_RISE: f32 = 0.1 + "),
    ("ray, detail, flat_btf_parameters.sight_steps", "ray, detail, 7u"),
    ("both - min(point.steps, both)", "7u"),
    ("            taken = k;\n", ""),
    ("max(detail - 1.0, 0.0)", "max(detail, 0.0)"),
    ("k < flat_btf_parameters.refine_steps", "k < 1u"),
    ("flat_btf_parameters.low + range - surface.height", "range - surface.height"),
    ("point.at + rise * flat_btf_tiles(surface, normal.xy)", "point.at"),
    ("flat_btf_tiles(surface, normal.xy)", "normal.xy"),
    ("flat_btf_tiles(surface, along - back * turn)", "(along - back * turn)"),
    ("s.x * along.x + s.y * along.y", "s.x * along.x"),
    ("s.z * along.x + s.w * along.y", "s.w * along.y"),
    ("let determinant = s.x * s.w - s.y * s.z;", "let determinant = 1.0;"),
    ("s.x * tiles.y - s.z * tiles.x", "s.x * tiles.y"),
    ("s.x * normal.x + s.z * normal.y", "s.x * normal.x"),
    ("p * v.y - q * v.x", "p * v.y"),
    ("height = min(height, column.z - above)", "height = height"),
    ("select(column.x, column.y, point.sheet == 1u) + above", "column.x + above"),
    ("s.w * tiles.x - s.y * tiles.y", "s.w * tiles.x"),
    ("s.y * normal.x + s.w * normal.y", "s.w * normal.y"),
    ("point.height + rise * normal.z", "point.height + rise"),
    ("FLAT_BTF_MIN_PASSING_STEPS: f32 = ", "FLAT_BTF_MIN_PASSING_STEPS: f32 = 3.0 + "),
    ("FLAT_BTF_MIN_AREA_RATIO: f32 = ", "FLAT_BTF_MIN_AREA_RATIO: f32 = 0.8 + "),
    ("slope - surface.height * turned", "slope"),
    ("slope - above * turned", "slope"),
    ("along - back * turn)", "along)"),
    ("2.0 * back * turn", "back * turn"),
    ("-(range * range * flat_btf_tiles(surface, turn))", "0.0 * turn"),
    ("-(up * up * flat_btf_tiles(surface, turn))", "0.0 * turn"),
    ("high = min(highest, -0.5 / bend)", "high = highest"),
    ("0.5 * bend * range", "0.0"),
    ("last = -0.5 / bend", "last = 2.0"),
    ("last = fall / half_bend", "last = 2.0"),
    ("if ray.passes == 1u {\n", "if false {\n"),
    ("c.x * v.x + c.y * v.y", "c.x * v.x"),
    ("c.y / determinant", "c.y"),
    ("height * c.y * (height * c.y)", "0.0"),
    ("v.x - v.z * tilt.x", "v.x"),
    ("v.z + v.x * tilt.x", "v.z"),
    ("ray.back - share", "0.0 - share"),
    ("flat_btf_parameters.sheets > 1u", "flat_btf_parameters.sheets > 3u"),
    ("select(2u, 1u, below_top.x", "select(1u, 2u, below_top.x"),
    ("first <= min(below_top.y, above_underside.y)", "first <= below_top.y"),
    ("            a = middle;\n", ""),
    ("            b = middle;\n", ""),
    ("f32(size) - 0.5", "f32(size) - 0.4999"),
    ("select(lower + 1u, 0u, lower + 1u == size)", "select(lower + 1u, 1u, lower + 1u == size)"),
    ("size - 1u, below < 0.0)", "0u, below < 0.0)"),
    ("select(tap.lower, tap.upper, upper == 1u)", "select(tap.lower, tap.upper, upper == 2u)"),
    ("texel, sheet, level).xy", "texel, 0u, level).xy"),
    ("max(flat_btf_parameters.size >> level, 1u)", "flat_btf_parameters.size"),
    ("min(max(detail, 0.0), f32", "min(max(detail, 0.1), f32"),
    ("if light.z <= 0.0", "if light.z <= 0.1"),
    ("min(light.z / lowest_light, 1.0)", "1.0"),
    ("if any(value != vec3<f32>(0.0)) &&", "if false &&"),
    (" && factored_dot(look.base.normal, light) > 0.0", ""),
    ("look.base, lights, lit) * dimmed", "look.base, lights, lit)"),
];

/// The negative control: every change above is detected.
#[test]
fn a_changed_shader_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let source = flat_btf_value_wgsl();
    assert!(!is_detected(gpu, &source));
    for (from, to) in CHANGES {
        assert_eq!(source.matches(from).count(), 1, "{from}");
        assert!(is_detected(gpu, &source.replace(from, to)), "{from} -> {to}");
    }
}

fn is_detected(gpu: &Gpu, source: &str) -> bool {
    let evaluator = FlatBtfEvaluator::with_shader(gpu, source).unwrap();
    let queries = queries(1000, 4);
    assets(3).iter().any(|material| {
        differences(material, &queries, &answers(&evaluator, material, FrameBlock::exact(), &queries)) != [0; 3]
    })
}
