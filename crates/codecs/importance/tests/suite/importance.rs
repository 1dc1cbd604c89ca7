//! Tests importance samples against the integrals that they estimate: white furnaces, albedos by quadrature, solid
//! angles.

use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, dot, from_polar};
use brdfc_formats::importance::ImportancePack;
use brdfc_importance::{Distribution, ImportanceRecipe, cell_probabilities, importance_samples, sequence_point};
use brdfc_source::open::open_file;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn source(address: &str) -> Box<dyn Source> {
    parse_synth(address).unwrap()
}

fn pack(source: &dyn Source) -> ImportancePack {
    importance_samples(source, &ImportanceRecipe::default()).unwrap().0
}

/// `f_r cos θi`, green.
fn integrand(source: &dyn Source, incoming: Vector, outgoing: Vector) -> f64 {
    source.eval(DirectionPair::new(incoming, outgoing), &mut Tally::default())[1] * incoming[2].max(0.0)
}

/// Incoming directions and inverse densities of a run of samples.
fn samples_of(pack: &ImportancePack, outgoing: Vector, first: u32, count: u32) -> Vec<(Vector, f64)> {
    let narrow = outgoing.map(|c| c as f32);
    let sample = |k| {
        let (incoming, inverse) = pack.sample(narrow, first + k);
        (incoming.map(f64::from), f64::from(inverse))
    };
    (0..count).map(sample).collect()
}

/// The albedo from a run of samples.
fn estimate(source: &dyn Source, pack: &ImportancePack, outgoing: Vector, first: u32, count: u32) -> f64 {
    let sum: f64 = samples_of(pack, outgoing, first, count)
        .into_iter()
        .map(|(incoming, inverse)| if inverse > 0.0 { integrand(source, incoming, outgoing) * inverse } else { 0.0 })
        .sum();
    sum / f64::from(count)
}

/// `∫ value(wi) dωi` by the midpoint rule over half vectors, dense around the normal; `jacobian` is steradians of incoming
/// directions per steradian of half vectors.
fn quadrature(outgoing: Vector, jacobian: fn(f64) -> f64, value: impl Fn(Vector) -> f64 + Sync) -> f64 {
    const STEPS: usize = 400;
    let rings: Vec<f64> = (0..STEPS)
        .into_par_iter()
        .map(|ring| {
            let share = (ring as f64 + 0.5) / STEPS as f64;
            let theta = share * share * FRAC_PI_2;
            let solid = theta.sin() * (2.0 * share * FRAC_PI_2 / STEPS as f64) * (TAU / STEPS as f64);
            let at = |cell: usize| {
                let half = from_polar(theta, (cell as f64 + 0.5) * TAU / STEPS as f64);
                let projection = dot(outgoing, half);
                let incoming: Vector = std::array::from_fn(|k| 2.0 * projection * half[k] - outgoing[k]);
                if incoming[2] <= 0.0 { 0.0 } else { value(incoming) * jacobian(projection) * solid }
            };
            (0..STEPS).map(at).sum()
        })
        .collect();
    rings.iter().sum()
}

fn reflection(projection: f64) -> f64 {
    4.0 * projection
}

/// Outgoing directions in the middle of rows, between rows, and arbitrary ones; degrees.
const OUTGOING: [[f64; 2]; 8] =
    [[0.0, 0.0], [3.7, 20.0], [17.3, 100.0], [30.0, 190.0], [45.1, 277.0], [60.0, 45.0], [71.9, 350.0], [80.0, 135.0]];

fn directions() -> Vec<Vector> {
    OUTGOING.map(|[theta, phi]| from_polar(theta.to_radians(), phi.to_radians())).to_vec()
}

/// RMS over directions and runs of the relative error of estimates with `count` samples.
fn error(source: &dyn Source, pack: &ImportancePack, references: &[(Vector, f64)], count: u32) -> f64 {
    let runs: u32 = if count == 1024 { 1 } else { 16 };
    let mut sum = 0.0;
    for (outgoing, albedo) in references {
        for run in 0..runs {
            sum += (estimate(source, pack, *outgoing, 61 * run, count) / albedo - 1.0).powi(2);
        }
    }
    (sum / f64::from(runs) / references.len() as f64).sqrt()
}

#[test]
fn lambert_in_a_white_furnace_shows_its_albedo() {
    let lambert = source("synth:lambert?kd=0.8");
    let pack = pack(lambert.as_ref());
    let mut worst: f64 = 0.0;
    for step in 0..=85 {
        let outgoing = from_polar(f64::from(step).to_radians(), f64::from(step) * 0.37);
        let found = estimate(lambert.as_ref(), &pack, outgoing, 17 * step, 1024);
        worst = worst.max((found / 0.8 - 1.0).abs());
    }
    println!("largest relative error {worst:.5}");
    assert!(worst < 0.01, "{worst}");
    let reference: Vec<_> = directions().into_iter().map(|outgoing| (outgoing, 0.8)).collect();
    assert!(error(lambert.as_ref(), &pack, &reference, 64) < 0.03);
}

/// Densities are normalised: their inverses sum to the solid angle, and with the cosine to π.
#[test]
fn inverse_densities_sum_to_solid_angles() {
    let pack = pack(source("synth:ggx?kd=0.3&alpha=0.4").as_ref());
    for outgoing in directions() {
        let samples = samples_of(&pack, outgoing, 0, 1024);
        let mean = |value: &dyn Fn(&Vector) -> f64| {
            samples.iter().map(|(incoming, inverse)| value(incoming) * inverse).sum::<f64>() / 1024.0
        };
        let cosine = mean(&|incoming| incoming[2]);
        assert!((cosine / PI - 1.0).abs() < 0.02, "{outgoing:?}: {cosine}");
        // Quarters of the sphere of directions, with the cosine: π / 4 each.
        for [sx, sy] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let inside = |i: &Vector| if i[0] * sx > 0.0 && i[1] * sy > 0.0 { i[2] } else { 0.0 };
            let quarter = mean(&inside);
            assert!((quarter / (PI / 4.0) - 1.0).abs() < 0.1, "{outgoing:?} {sx} {sy}: {quarter}");
        }
    }
}

/// Compares counts of stored half vectors with probabilities, and stored densities with solid angles, in regions of the
/// hemisphere that do not follow the cells' borders.
#[test]
fn half_vectors_have_their_stored_density() {
    let ggx = source("synth:ggx?kd=0.2&f0=0.3&alpha=0.3");
    let recipe = ImportanceRecipe { samples: 8192, isotropic_polar: 8, ..ImportanceRecipe::default() };
    let (pack, _) = importance_samples(ggx.as_ref(), &recipe).unwrap();
    for row in 0..8 {
        let probabilities = cell_probabilities(ggx.as_ref(), &pack.header(), row, &recipe, &mut Tally::default());
        assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(probabilities.iter().all(|p| *p > 0.0));
        let distribution = Distribution::new(recipe.grid, &probabilities);
        // 6 rings of equal solid angle, 5 sectors.
        let region = |[x, y, z]: [f64; 3]| {
            let turn = (y.atan2(x) / TAU).rem_euclid(1.0);
            5 * (((1.0 - z) * 6.0) as usize).min(5) + ((turn * 5.0) as usize).min(4)
        };
        let [mut counted, mut solid, mut squares, mut expected] = [[0.0; 30]; 4];
        for [x, y, z, density] in &pack.texels()[8192 * row as usize..][..8192] {
            let at = region([*x, *y, *z].map(f64::from));
            counted[at] += 1.0;
            solid[at] += 1.0 / f64::from(*density) / 8192.0;
        }
        for step in 0..600 {
            let z = 1.0 - (f64::from(step) + 0.5) / 600.0;
            let r = (1.0 - z * z).sqrt();
            let ring = (0..recipe.grid.polar).rfind(|k| recipe.grid.border(*k) <= 1.0 - z).unwrap();
            for cell in 0..640 {
                let turn = (f64::from(cell) + 0.5) / 640.0;
                let density = distribution.density(ring, (turn * 64.0) as usize);
                let at = region([r * (TAU * turn).cos(), r * (TAU * turn).sin(), z]);
                expected[at] += 8192.0 * density * TAU / (600.0 * 640.0);
                squares[at] += 1.0 / density / 8192.0 * TAU / (600.0 * 640.0);
            }
        }
        // Random points would have a chi-square of about 29; well-spread ones have less.
        let chi: f64 = (0..30).map(|k| (counted[k] - expected[k]).powi(2) / expected[k]).sum();
        assert!(chi < 29.0, "row {row}: {chi}");
        // Within four standard errors of random points, which are large where few half vectors fall.
        let mut precise = 0;
        for k in 0..30 {
            let (off, standard) = (solid[k] - TAU / 30.0, squares[k].sqrt());
            assert!(off.abs() < 4.0 * standard, "row {row}, region {k}: {} {standard}", solid[k]);
            precise += u32::from(standard < 0.05 * TAU / 30.0);
        }
        assert!(precise >= 4, "row {row}: {squares:?}");
        // The negative control: a density that does not depend on the half vector.
        let flat: f64 = (0..30).map(|k| (counted[k] - 8192.0 / 30.0).powi(2) / (8192.0 / 30.0)).sum();
        assert!(flat > 1000.0, "row {row}: {flat}");
    }
}

/// Maximum errors with 64, 256 and 1024 samples.
const CONVERGENCE: [(&str, [f64; 3]); 6] = [
    ("synth:ggx?kd=0.3&f0=0.04&alpha=0.3", [0.05, 0.02, 0.01]),
    ("synth:ggx?kd=0.1&f0=0.5&alpha=0.1", [0.05, 0.02, 0.01]),
    ("synth:ggx?kd=0&f0=0.9&alpha=0.02", [0.05, 0.02, 0.01]),
    ("synth:ggx?kd=0.1&f0=0.5&alpha_x=0.1&alpha_y=0.5", [0.08, 0.03, 0.02]),
    ("synth:ward?kd=0.2&ks=0.2&ax=0.1&ay=0.4", [0.08, 0.03, 0.02]),
    ("synth:velvet", [0.08, 0.03, 0.02]),
];

fn references(source: &dyn Source) -> Vec<(Vector, f64)> {
    directions()
        .into_iter()
        .map(|outgoing| (outgoing, quadrature(outgoing, reflection, |incoming| integrand(source, incoming, outgoing))))
        .collect()
}

#[test]
fn albedos_converge_to_quadrature() {
    for (address, most) in CONVERGENCE {
        let source = source(address);
        let pack = pack(source.as_ref());
        let references = references(source.as_ref());
        let errors = [64, 256, 1024].map(|count| error(source.as_ref(), &pack, &references, count));
        println!("{address}: relative errors {errors:.5?}");
        assert!((0..3).all(|k| errors[k] < most[k]), "{address}: {errors:?}");
        assert!(errors[2] < errors[0], "{address}: {errors:?}");
    }
}

/// Tests the quadrature: a white Lambertian surface reflects everything if and only if the Jacobian is `4 (wo · h)`.
#[test]
fn a_wrong_jacobian_is_detected() {
    let white = source("synth:lambert?kd=1");
    let pack = pack(white.as_ref());
    for outgoing in directions() {
        let found = quadrature(outgoing, reflection, |incoming| integrand(white.as_ref(), incoming, outgoing));
        assert!((found - 1.0).abs() < 2e-3, "{outgoing:?}: {found}");
        let wrong = quadrature(outgoing, |_| 1.0, |incoming| integrand(white.as_ref(), incoming, outgoing));
        assert!((wrong - 1.0).abs() > 0.1, "{outgoing:?}: {wrong}");
        // The same for samples whose density is taken per steradian of half vectors.
        let samples = samples_of(&pack, outgoing, 0, 1024);
        let wrong: f64 = samples
            .iter()
            .filter(|(_, inverse)| *inverse > 0.0)
            .map(|(incoming, inverse)| {
                let sum: Vector = std::array::from_fn(|k| incoming[k] + outgoing[k]);
                let projection = 0.5 * dot(sum, sum).sqrt();
                incoming[2] / PI * inverse / reflection(projection)
            })
            .sum();
        assert!((wrong / 1024.0 - 1.0).abs() > 0.1, "{outgoing:?}: {}", wrong / 1024.0);
    }
}

/// Variance of a single sample with the pack, and with directions uniform over the hemisphere, relative to the squared
/// albedo.
fn variances(source: &dyn Source, pack: &ImportancePack, references: &[(Vector, f64)]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (outgoing, albedo) in references {
        let relative = |incoming| integrand(source, incoming, *outgoing) / albedo;
        let ours: f64 = samples_of(pack, *outgoing, 0, 1024)
            .into_iter()
            .map(|(incoming, inverse)| (if inverse > 0.0 { relative(incoming) * inverse } else { 0.0 } - 1.0).powi(2))
            .sum();
        sums[0] += ours / 1024.0;
        sums[1] += TAU * quadrature(*outgoing, reflection, |incoming| relative(incoming).powi(2)) - 1.0;
    }
    sums.map(|sum| sum / references.len() as f64)
}

#[test]
fn variance_is_far_below_that_of_uniform_directions() {
    for (address, factor) in [
        ("synth:lambert", 5.0),
        ("synth:ggx?kd=0.3&f0=0.04&alpha=0.3", 5.0),
        ("synth:ggx?kd=0.1&f0=0.5&alpha=0.1", 50.0),
        ("synth:ggx?kd=0&f0=0.9&alpha=0.02", 1000.0),
        ("synth:ward?kd=0.2&ks=0.2&ax=0.1&ay=0.4", 20.0),
    ] {
        let source = source(address);
        let [ours, uniform] = variances(source.as_ref(), &pack(source.as_ref()), &references(source.as_ref()));
        println!("{address}: variance {ours:.4}, uniform {uniform:.3}, factor {:.0}", uniform / ours);
        assert!(ours * factor < uniform, "{address}: {ours} {uniform}");
    }
}

#[test]
fn measured_materials_converge() {
    for (file, most) in [("merl/chrome.binary", [0.2, 0.1, 0.06]), ("merl/red-plastic.binary", [0.1, 0.05, 0.03])] {
        let Some(path) = brdfc_testing::shared_data(file) else { continue };
        let source = open_file(&path, None).unwrap().source;
        let pack = pack(source.as_ref());
        let references = references(source.as_ref());
        let errors = [64, 256, 1024].map(|count| error(source.as_ref(), &pack, &references, count));
        let [ours, uniform] = variances(source.as_ref(), &pack, &references);
        println!("{file}: relative errors {errors:.5?}, variance {ours:.4}, uniform {uniform:.3}");
        assert!((0..3).all(|k| errors[k] < most[k]), "{file}: {errors:?}");
        assert!(10.0 * ours < uniform, "{file}: {ours} {uniform}");
    }
}

/// A source with hidden symmetries, or with values that are no numbers.
struct Changed(Box<dyn Source>, Symmetry, f64);

impl Source for Changed {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        self.0.eval(pair, tally).map(|value| value * self.2)
    }

    fn symmetry(&self) -> Symmetry {
        self.1
    }
}

#[test]
fn symmetries_only_save_work() {
    let small = ImportanceRecipe { anisotropic_polar: 4, anisotropic_azimuths: 8, samples: 256, ..Default::default() };
    let (folded, few) = importance_samples(source("synth:ward").as_ref(), &small).unwrap();
    let plain = Changed(source("synth:ward"), Symmetry::NONE, 1.0);
    let (all, many) = importance_samples(&plain, &small).unwrap();
    assert_eq!(4 * few.evaluations, many.evaluations);
    // Rows of the first quarter are identical; the others are equally accurate.
    assert_eq!(folded.texels()[..2 * 256], all.texels()[..2 * 256]);
    assert_ne!(folded.texels(), all.texels());
    let references = references(&plain);
    for pack in [&folded, &all] {
        let error = error(&plain, pack, &references, 256);
        assert!(error < 0.1, "{error}");
    }
    let isotropic = source("synth:ggx");
    let (folded, few) = importance_samples(isotropic.as_ref(), &small).unwrap();
    let plain = Changed(isotropic, Symmetry { mirror: false, ..Symmetry::FULL }, 1.0);
    let (all, many) = importance_samples(&plain, &small).unwrap();
    assert_eq!(2 * few.evaluations, many.evaluations);
    for (a, b) in folded.texels().iter().flatten().zip(all.texels().iter().flatten()) {
        assert!((a - b).abs() <= 1e-4 * a.abs().max(1.0), "{a} {b}");
    }
}

#[test]
fn bad_sources_and_recipes() {
    let small = ImportanceRecipe { isotropic_polar: 4, samples: 64, ..Default::default() };
    for factor in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        let source = Changed(source("synth:ggx"), Symmetry::FULL, factor);
        let (pack, _) = importance_samples(&source, &small).unwrap();
        let lambert = parse_synth("synth:lambert?kd=1").unwrap();
        let found = estimate(lambert.as_ref(), &pack, from_polar(0.5, 0.3), 0, 64);
        assert!((found - 1.0).abs() < 0.2, "{factor}: {found}");
    }
    let ggx = source("synth:ggx");
    for (recipe, expected) in [
        (ImportanceRecipe { samples: 0, ..small }, "brdfc.importance samples: found 0, expected 1 to 8192"),
        (
            ImportanceRecipe { isotropic_polar: 2000, ..small },
            "brdfc.importance polar rows: found 2000, expected 1 to 1024",
        ),
        (ImportanceRecipe { defensive: 0.0, ..small }, "defensive share: found 0, expected above 0, up to 1"),
        (ImportanceRecipe { defensive: f64::NAN, ..small }, "defensive share: found NaN, expected above 0, up to 1"),
    ] {
        assert_eq!(importance_samples(ggx.as_ref(), &recipe).unwrap_err().to_string(), expected);
    }
    let mut odd = small;
    odd.grid.azimuths = 63;
    assert!(importance_samples(ggx.as_ref(), &odd).is_err());
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let recipe = ImportanceRecipe { anisotropic_polar: 4, anisotropic_azimuths: 8, samples: 128, ..Default::default() };
    for address in ["synth:ggx?alpha=0.1", "synth:ward"] {
        let bytes = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| importance_samples(source(address).as_ref(), &recipe).unwrap().0.to_bytes(true))
        };
        let one = bytes(1);
        assert_eq!(one, bytes(3), "{address}");
        assert_eq!(ImportancePack::from_bytes(&one).unwrap().to_bytes(true), one);
    }
}

#[test]
fn the_first_points_by_hand() {
    let close = |a: [f64; 2], b: [f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() < 1e-9);
    assert!(close(sequence_point(0), [0.5, 0.5]));
    assert!(close(sequence_point(1), [0.254_877_666, 0.069_840_291]));
}
