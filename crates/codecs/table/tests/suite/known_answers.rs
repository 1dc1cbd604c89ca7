//! Tables of materials with known answers.

use brdfc_codec::EncodeError;
use brdfc_core::address::parse_synth;
use brdfc_core::{PackSource, Source, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::{Axes, TableDecoder, TableHeader, TablePack, TableSymmetry};
use brdfc_metrics::compare::compare;
use brdfc_metrics::sampling::{PairSet, cosine_directions};
use brdfc_source::open::open_file;
use brdfc_table::encode::{Encoded, encode};
use brdfc_table::fit::fit;
use brdfc_table::lattice::{Lattice, Taps};
use brdfc_table::recipe::{Aim, Size, TableRecipe};
use brdfc_table::samples::Samples;
use brdfc_table::symmetry::Asymmetry;
use brdfc_table::targets::Targets;
use brdfc_testing::codecs::table::tables;
use brdfc_testing::packs::pairs;
use brdfc_testing::testdata;
use std::path::Path;

fn source(address: &str) -> Box<dyn Source> {
    parse_synth(address).unwrap()
}

fn table(source: &dyn Source, bytes: u64) -> Encoded {
    encode(source, &TableRecipe { size: Size::Bytes(bytes), ..TableRecipe::default() }, &()).unwrap()
}

/// White furnace: a matte white reflects all light, even in the smallest table.
#[test]
fn lambert_is_flat() {
    let lambert = source("synth:lambert?kd=1");
    let encoded = table(lambert.as_ref(), 300);
    assert!(encoded.pack.gpu_bytes() <= 300);
    let decoder = TableDecoder::new(&encoded.pack);
    for pair in pairs(2000, 1) {
        let f = decoder.eval(pair)[0];
        assert!((f * std::f32::consts::PI - 1.0).abs() < 1e-4, "{f}");
    }
    assert!(encoded.off_grid.norms.relative_max < 1e-4);
    assert!(encoded.off_grid.rendering.delta_e.max < 0.02);
}

/// Errors fall with the size, and the stored errors of a pack are those of a comparison with its source.
#[test]
fn larger_tables_are_closer_and_errors_are_true() {
    let plastic = open_file(Path::new(&testdata("demo/red_plastic.binary")), None).unwrap().source;
    let mut before = f64::INFINITY;
    for bytes in [1 << 10, 4 << 10, 16 << 10] {
        let encoded = table(plastic.as_ref(), bytes);
        let pack = TablePack::from_bytes(&encoded.bytes).unwrap();
        assert_eq!(pack, encoded.pack);
        assert!(pack.gpu_bytes() <= bytes && pack.gpu_bytes() > bytes * 3 / 4, "{} of {bytes}", pack.gpu_bytes());
        let (found, _) = compare(plastic.as_ref(), &PackSource::new(&pack, None), &PairSet::comparison());
        assert_eq!(found, encoded.off_grid);
        assert_eq!((pack.off_grid, pack.rendering), (found.summary(), found.rendering.summary()));
        let error = found.rendering.delta_e.mean;
        assert!(error < 0.85 * before, "{error} after {before}");
        before = error;
    }
    assert!(before < 0.1, "{before}");
}

/// Fitting a table with the same nodes recovers its values, with any folds.
#[test]
fn tables_of_tables_are_perfect() {
    for (name, pack) in tables().into_iter().filter(|(_, pack)| pack.curve().is_none()) {
        let header = *pack.header();
        let original = PackSource::new(&pack, None);
        let samples = Samples::draw(&original, 60_000, false);
        let targets = Targets::new(&samples, header.bias * header.mean / mean_of(&samples), header.channels == 1);
        let lattice = Lattice::new(&header);
        let taps: Vec<Taps> = samples.angles.iter().map(|a| lattice.taps(&header.position_of(*a))).collect();
        let nodes = fit(lattice, &taps, &targets).nodes;
        let off: Vec<f32> = taps
            .iter()
            .zip(&targets.logarithms)
            .map(|(taps, expected)| (lattice.value(taps, &nodes)[0] - expected[0]).abs())
            .collect();
        let mean = off.iter().sum::<f32>() / off.len() as f32;
        assert!(mean < 2e-3, "{name}: off by {mean} in the mean");
        // Negative control: nodes at other positions do not hold the same values.
        let bent = TableHeader { slope: header.slope - 0.4, ..header };
        let taps: Vec<Taps> = samples.angles.iter().map(|a| lattice.taps(&bent.position_of(*a))).collect();
        let nodes = fit(lattice, &taps, &targets).nodes;
        let of = |(taps, expected): (&Taps, &[f32; 3])| (lattice.value(taps, &nodes)[0] - expected[0]).abs();
        let other = taps.iter().zip(&targets.logarithms).map(of).sum::<f32>() / taps.len() as f32;
        assert!(other > 4.0 * mean, "{name}: {other} against {mean}");
    }
}

/// `μ` as in [`Targets`].
fn mean_of(samples: &Samples) -> f32 {
    Targets::new(samples, 1e-4, false).mean
}

/// Car paint with a clear coat over flakes: a narrow lobe on a wide one, which no single warp of the columns suits.
struct CarPaint {
    coat: Box<dyn Source>,
    flakes: Box<dyn Source>,
}

impl CarPaint {
    fn new() -> Self {
        let coat = source("synth:ggx?kd=0&f0=0.04&alpha=0.02");
        Self { coat, flakes: source("synth:ggx?kd=0.05,0.02,0.01&f0=0.5,0.2,0.1&alpha=0.3") }
    }
}

impl Source for CarPaint {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        let (coat, flakes) = (self.coat.eval(pair, tally), self.flakes.eval(pair, tally));
        std::array::from_fn(|c| coat[c] + flakes[c])
    }
    fn symmetry(&self) -> brdfc_core::Symmetry {
        brdfc_core::Symmetry::FULL
    }
    fn is_grey(&self) -> bool {
        false
    }
}

/// If a highlight is too narrow for the columns, a curve is closer with the same bytes.
#[test]
fn curves_retain_narrow_highlights() {
    let made = |source: &dyn Source, factored: bool| {
        let recipe = TableRecipe { size: Size::Bytes(8 << 10), factored, ..TableRecipe::default() };
        encode(source, &recipe, &()).unwrap()
    };
    let paint = CarPaint::new();
    let (plain, factored) = (made(&paint, false), made(&paint, true));
    assert!(factored.pack.gpu_bytes() <= 8 << 10 && factored.pack.fetches() == 2 && plain.pack.fetches() == 1);
    let [plain, curved] = [&plain, &factored].map(|made| made.off_grid.rendering.delta_e.mean);
    assert!(curved < 0.9 * plain, "{curved} against {plain}");
    assert_eq!(TablePack::from_bytes(&factored.bytes).unwrap(), factored.pack);
    // Without its curve the same table is far from the material.
    let bare = TablePack::new(*factored.pack.header(), &factored.pack.values()).unwrap();
    let (bare, _) = compare(&paint, &PackSource::new(&bare, None), &PairSet::comparison());
    assert!(bare.rendering.delta_e.mean > 10.0 * curved, "{}", bare.rendering.delta_e.mean);
    // A flat material has a flat curve: no contribution counts twice.
    let flat = made(source("synth:lambert?kd=1").as_ref(), true);
    assert!(flat.off_grid.norms.relative_max < 1e-3, "{}", flat.off_grid.norms.relative_max);
}

/// A table for ratios has better ratios with the same bytes, and hardly better renderings.
#[test]
fn tables_minimise_their_error_measure() {
    let plastic = open_file(Path::new(&testdata("demo/red_plastic.binary")), None).unwrap().source;
    for bytes in [1 << 10, 4 << 10] {
        let made = |aim| {
            let recipe = TableRecipe { size: Size::Bytes(bytes), aim, ..TableRecipe::default() };
            let found = encode(plastic.as_ref(), &recipe, &()).unwrap().off_grid;
            (found.rendering.delta_e.mean, found.norms.relative_mean)
        };
        let (renderings, ratios) = (made(Aim::Renderings), made(Aim::Ratios));
        assert!(ratios.1 < 0.98 * renderings.1 && renderings.0 < 1.2 * ratios.0, "{renderings:?} {ratios:?}");
    }
}

#[test]
fn symmetry_is_measured() {
    let folds = |address: &str| {
        let source = source(address);
        Asymmetry::of(source.as_ref()).folds(source.symmetry().isotropic)
    };
    let all = TableSymmetry { reciprocal: true, mirror: true, half_turn: true, reflected: true };
    assert_eq!(folds("synth:ward?ax=0.15&ay=0.5"), all);
    let isotropic = TableSymmetry { half_turn: false, reflected: false, ..all };
    assert_eq!(folds("synth:ggx?alpha=0.2"), isotropic);
    // The model's shadowing depends on the azimuths of light and viewer, not of the half vector alone.
    assert_eq!(folds("synth:ggx?alpha_x=0.1&alpha_y=0.4"), TableSymmetry { mirror: false, ..all });
    // Materials that are not reciprocal are not folded.
    assert!(!folds("synth:poulin?kd=0.1&ks=0.3&d=3&h=0.5&n=20").mirror);
    let plastic = open_file(Path::new(&testdata("demo/red_plastic.binary")), None).unwrap().source;
    let asymmetry = Asymmetry::of(plastic.as_ref());
    assert!(asymmetry.reciprocal < 1e-6 && asymmetry.mirror >= 0.0, "{asymmetry:?}");
}

/// One-sided materials become reciprocal on request, at a reported cost.
#[test]
fn reciprocal_tables_are_reciprocal() {
    struct OneSided;
    impl Source for OneSided {
        fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
            tally.evaluations += 1;
            [0.1 + 0.2 * pair.incoming[2]; 3]
        }
        fn symmetry(&self) -> brdfc_core::Symmetry {
            brdfc_core::Symmetry { reciprocal: false, ..brdfc_core::Symmetry::FULL }
        }
        fn is_grey(&self) -> bool {
            true
        }
    }
    let of = |reciprocal| encode(&OneSided, &TableRecipe { reciprocal, ..TableRecipe::default() }, &()).unwrap();
    let (plain, both) = (of(false), of(true));
    assert!(plain.off_grid.reciprocity > 0.1 && plain.off_grid.norms.relative_mean < 0.005);
    assert!(both.off_grid.reciprocity < 1e-4, "{}", both.off_grid.reciprocity);
    assert!(both.off_grid.norms.relative_mean > 0.05, "the symmetrised values are off either way");
    assert!(both.pack.header().symmetry.reciprocal && !plain.pack.header().symmetry.reciprocal);
}

/// Reflected light does not exceed the source's, up to the format's rounding.
#[test]
fn energy_is_preserved() {
    let metal = source("synth:ggx?kd=0&f0=1&alpha=0.3");
    let encoded = table(metal.as_ref(), 16 << 10);
    let decoder = TableDecoder::new(&encoded.pack);
    for theta in [0.0f64, 0.6, 1.2] {
        let incoming = [theta.sin(), 0.0, theta.cos()];
        let outgoing = cosine_directions(64);
        let albedo = |f: &dyn Fn([f64; 3]) -> f64| {
            outgoing.iter().map(|o| f(*o)).sum::<f64>() * std::f64::consts::PI / outgoing.len() as f64
        };
        let pair = |o| brdfc_formats::direction::DirectionPair::new(incoming, o);
        let exact = albedo(&|o| metal.eval(pair(o), &mut Tally::default())[0]);
        let found = albedo(&|o| f64::from(decoder.eval(pair(o))[0]));
        assert!((found / exact - 1.0).abs() < 0.01 && found < 1.01, "{theta}: {found} against {exact}");
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let plastic = open_file(Path::new(&testdata("demo/red_plastic.binary")), None).unwrap().source;
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| table(plastic.as_ref(), 4 << 10).bytes)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn sizes_are_checked() {
    let lambert = source("synth:lambert");
    let made = |size| encode(lambert.as_ref(), &TableRecipe { size, ..TableRecipe::default() }, &());
    let error = made(Size::Bytes(100)).unwrap_err();
    assert!(matches!(error, EncodeError::TooFewBytes { allowed: 100, smallest: 160, .. }), "{error}");
    let axes = Axes { half: 1, difference: 4, azimuth: 4, layers: 1 };
    let error = made(Size::Nodes(axes)).unwrap_err().to_string();
    assert!(error.contains("θ_h nodes: found 1, expected 2 to 256"), "{error}");
    for axes in [Axes { half: 0, ..axes }, Axes { layers: 0, ..axes }, Axes { azimuth: 256, layers: 256, ..axes }] {
        assert!(matches!(made(Size::Nodes(axes)), Err(EncodeError::Format(_))), "{axes:?}");
    }
    // No budget needs more samples than the maximum.
    let ward = source("synth:ward?ax=0.15&ay=0.5");
    let recipe = TableRecipe { size: Size::Bytes(1 << 40), measure: false, ..TableRecipe::default() };
    assert!(encode(ward.as_ref(), &recipe, &()).unwrap().pack.gpu_bytes() <= 2 * brdfc_table::encode::MAX_TEXELS + 144);
    let axes = Axes { half: 7, difference: 3, azimuth: 5, layers: 2 };
    assert_eq!(made(Size::Nodes(axes)).unwrap().pack.header().axes, axes);
}
