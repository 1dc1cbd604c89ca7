//! One benchmark per stage, on inputs made in memory with fixed seeds: `cargo bench -p brdfc-benches`, with `-- haar`
//! for a selection.
//!
//! The grid is 32 x 32 per hemisphere unless the name says otherwise. All stages use every core.

use brdfc_bandwidth::environment::environment_bandwidth;
use brdfc_bandwidth::lobe::lobe_bandwidth;
use brdfc_core::address::parse_model;
use brdfc_core::{PackSource, Source};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::{Filter, RowScratch, WaveletDecoder, WaveletPack};
use brdfc_importance::{ImportanceRecipe, importance_samples};
use brdfc_metrics::compare::compare;
use brdfc_metrics::sampling::{PairSet, random_pairs};
use brdfc_readers::merl::{Dimensions, Merl};
use brdfc_readers::scan::Scan;
use brdfc_source::simulate::{ScanPlan, merl_file, scan};
use brdfc_source::{MerlSource, ScanSource};
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::haar;
use brdfc_wavelet::log_encode::{DEFAULT_BIAS, LogEncoding, log_encode};
use brdfc_wavelet::measure::grid_error;
use brdfc_wavelet::quantise::quantise;
use brdfc_wavelet::recipe::{Recipe, Target};
use brdfc_wavelet::resample::resample;
use brdfc_wavelet::table::{Grid, Table};
use brdfc_wavelet::threshold::{keep, ranking, slice_energies};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;

const GRID: Grid = Grid { parameterisation: Parameterisation::TangentPole, levels: 5 };
const COARSE: Grid = Grid { levels: 4, ..GRID };
const SEED: u64 = 7;
const RATIO: f64 = 4.0;

fn model(address: &str) -> Box<dyn Source> {
    parse_model(address).expect("a model of ours")
}

/// A red plastic as a MERL file of full size.
fn merl_bytes() -> Vec<u8> {
    merl_file(model("ggx?kd=0.4,0.05,0.04&alpha=0.25").as_ref(), Dimensions::MERL)
}

/// The same file with one side of the plane of incidence brighter than the other.
fn lopsided(mut table: Merl) -> MerlSource {
    let azimuths = table.dimensions.phi_difference;
    for (cell, value) in table.values.iter_mut().enumerate() {
        let phi = std::f32::consts::PI * (cell % azimuths) as f32 / azimuths as f32;
        *value = value.map(|v| v * (1.0 + 0.1 * (2.0 * phi).sin()));
    }
    MerlSource::new(table)
}

/// A noisy scan of a blue paint.
fn scan_source() -> ScanSource {
    let plan =
        ScanPlan { rows: 1440, incidences: 8, azimuths: Some(1), noise: 0.05, gaps: 0.1, duplicates: 0.05, seed: SEED };
    let rows = scan(model("ggx?kd=0.1,0.1,0.4&alpha=0.3").as_ref(), &plan);
    ScanSource::new(&Scan { rows, ..Scan::default() }).expect("enough rows")
}

fn read(criterion: &mut Criterion) {
    let bytes = merl_bytes();
    let mut group = criterion.benchmark_group("read");
    group.throughput(Throughput::Bytes(bytes.len() as u64));
    group.bench_function("merl 90 x 90 x 180", |b| b.iter(|| Merl::from_bytes(black_box(&bytes))));
}

fn resampling(criterion: &mut Criterion) {
    let table = Merl::from_bytes(&merl_bytes()).expect("our own file");
    let (mirror, lopsided, scan) = (MerlSource::new(table.clone()), lopsided(table), scan_source());
    assert!(mirror.symmetry().mirror && !lopsided.symmetry().mirror, "the two inputs differ in symmetry");
    let mut group = criterion.benchmark_group("resample");
    for (name, source, grid) in [
        ("merl, mirror symmetric", &mirror as &dyn Source, GRID),
        ("merl, not mirror symmetric", &lopsided, GRID),
        ("scan by moving least squares, 16 x 16", &scan, COARSE),
    ] {
        let (_, tally) = resample(source, grid);
        group.throughput(Throughput::Elements(tally.evaluations));
        group.bench_function(name, |b| b.iter(|| resample(black_box(source), grid)));
    }
}

fn importance(criterion: &mut Criterion) {
    let table = Merl::from_bytes(&merl_bytes()).expect("our own file");
    let (mirror, lopsided, ward) = (MerlSource::new(table.clone()), lopsided(table), model("ward"));
    let recipe = ImportanceRecipe::default();
    let mut group = criterion.benchmark_group("importance samples");
    for (name, source) in [
        ("merl, mirror symmetric", &mirror as &dyn Source),
        ("merl, not mirror symmetric", &lopsided),
        ("anisotropic model", ward.as_ref()),
    ] {
        group.bench_function(name, |b| b.iter(|| importance_samples(black_box(source), &recipe)));
    }
}

/// A table, its logarithms and its coefficients.
struct Stages {
    source: MerlSource,
    table: Table,
    encoding: LogEncoding,
    logarithms: Table,
    coefficients: Table,
    pack: WaveletPack,
}

fn stages() -> Stages {
    let source = MerlSource::new(Merl::from_bytes(&merl_bytes()).expect("our own file"));
    let (table, _) = resample(&source, GRID);
    let encoding = LogEncoding::of(&table, DEFAULT_BIAS);
    let logarithms = log_encode(&table, encoding);
    let coefficients = haar::transform(&logarithms);
    let recipe = Recipe { target: Target::Ratio(RATIO), measure_off_grid: false, ..Recipe::default() };
    let pack = encode(&source, &recipe, &()).expect("a ratio is always met").pack;
    Stages { source, table, encoding, logarithms, coefficients, pack }
}

fn encoding(criterion: &mut Criterion) {
    let s = stages();
    let order = ranking(&slice_energies(&s.coefficients), GRID.levels);
    let selected = keep(&order, s.pack.retained());
    let mut group = criterion.benchmark_group("encode");
    group.bench_function("log", |b| b.iter(|| log_encode(black_box(&s.table), s.encoding)));
    group.bench_function("haar", |b| b.iter(|| haar::transform(black_box(&s.logarithms))));
    group.bench_function("slice energies and ranking", |b| {
        b.iter(|| ranking(&slice_energies(black_box(&s.coefficients)), GRID.levels))
    });
    group.bench_function("quantise, 4:1", |b| {
        b.iter(|| quantise(black_box(&s.coefficients), &selected, &s.pack.header))
    });
}

fn decoding(criterion: &mut Criterion) {
    let s = stages();
    let decoder = WaveletDecoder::new(&s.pack);
    let mut group = criterion.benchmark_group("decode");
    group.bench_function("whole grid, one thread", |b| {
        let mut row = vec![0.0; GRID.cells()];
        let mut scratch = RowScratch::default();
        b.iter(|| {
            for outer in 0..GRID.cells() {
                for channel in 0..3 {
                    decoder.decode_row(outer, channel, &mut row, &mut scratch);
                }
            }
            row[0]
        });
    });
    let pairs = random_pairs(1000, SEED);
    group.throughput(Throughput::Elements(pairs.len() as u64));
    for (name, filter) in [("1000 pairs, nearest", Filter::Nearest), ("1000 pairs, bilinear", Filter::Bilinear)] {
        group.bench_function(name, |b| {
            b.iter(|| pairs.iter().map(|pair| decoder.eval(*pair, GRID.levels as f32, filter)[0]).sum::<f32>());
        });
    }
}

fn measuring(criterion: &mut Criterion) {
    let s = stages();
    let decoded = PackSource::new(&s.pack, None);
    let decoder = WaveletDecoder::new(&s.pack);
    let set = PairSet::comparison();
    let mut group = criterion.benchmark_group("measure");
    group.bench_function("on the grid", |b| b.iter(|| grid_error(black_box(&s.table), &decoder, DirectionRange::ALL)));
    group.throughput(Throughput::Elements(set.pairs.len() as u64));
    group.bench_function("at independent test directions", |b| b.iter(|| compare(&s.source, &decoded, &set)));
}

fn bandwidth(criterion: &mut Criterion) {
    let table = MerlSource::new(Merl::from_bytes(&merl_bytes()).expect("our own file"));
    let mut group = criterion.benchmark_group("bandwidth");
    group.bench_function("merl, lobes of 64 x 64", |b| b.iter(|| lobe_bandwidth(black_box(&table), 64, 0.01)));
    let (width, height) = (2048, 1024);
    let pixel = |i: usize| {
        let (x, y) = ((i % width) as f32 / 100.0, (i / width) as f32 / 40.0);
        [1.5 + x.sin(), 1.2 + (x + y).cos(), 1.0 + (i * i % 101) as f32 / 100.0]
    };
    let sky: Vec<[f32; 3]> = (0..width * height).map(pixel).collect();
    group.throughput(Throughput::Elements(sky.len() as u64));
    group.bench_function("environment 2048 x 1024", |b| b.iter(|| environment_bandwidth(black_box(&sky), width, 0.01)));
}

/// Preparation of adaptive shading, and forward shading for comparison.
fn adaptive(criterion: &mut Criterion) {
    use brdfc_bandwidth::map::environment_map;
    use brdfc_render::adaptive::{AdaptiveScene, DistantLight, Lookups, Settings, forward, predict};
    use brdfc_render::gbuffer::GBuffer;
    use brdfc_render::scene::Frame;
    use brdfc_render::scenes::Builtin;
    use brdfc_render::shade::SourceReflectance;
    let table = MerlSource::new(Merl::from_bytes(&merl_bytes()).expect("our own file"));
    let (scene, frame) = (Builtin::BumpyBall.scene(), Frame { width: 512, height: 512, samples: 1 });
    let (sky, lookups) = (&scene.environment, Lookups::new(&table).expect("the default recipes"));
    let light = DistantLight::new(sky, environment_map(&sky.pixels, sky.width, 0.01).expect("a map"));
    let reflectance = SourceReflectance(&table);
    let materials = vec![lookups.material(&reflectance); scene.parts.len()];
    let adaptive = AdaptiveScene { scene: &scene, light: &light, materials: &materials };
    let buffer = GBuffer::new(&scene, frame);
    let points = (0..buffer.part.len()).filter(|point| buffer.part_at(*point).is_some()).count();
    let mut group = criterion.benchmark_group("adaptive");
    group.throughput(Throughput::Elements(points as u64));
    for directions in [4, 16, 64] {
        let settings = Settings { directions, ..Settings::default() };
        group.bench_function(format!("bandwidth buffer, {directions} directions"), |b| {
            b.iter(|| predict(black_box(&adaptive), frame, &buffer, &settings));
        });
    }
    group.bench_function("forward shading, 4 samples", |b| {
        b.iter(|| forward(black_box(&adaptive), frame, &buffer, 4));
    });
}

fn packing(criterion: &mut Criterion) {
    let pack = stages().pack;
    let mut group = criterion.benchmark_group("pack");
    group.throughput(Throughput::Bytes(pack.texels.len() as u64));
    for (name, compressed) in [("stored", false), ("zstandard", true)] {
        let bytes = pack.to_bytes(compressed);
        group.bench_function(format!("write, {name}"), |b| b.iter(|| black_box(&pack).to_bytes(compressed)));
        group.bench_function(format!("read, {name}"), |b| b.iter(|| WaveletPack::from_bytes(black_box(&bytes))));
    }
}

/// Fits a stack of 400 x 400 texels under 72 lights with 36 terms, computes the bare matrix product of that size, and
/// encodes a complete pack.
fn relighting(criterion: &mut Criterion) {
    use brdfc_formats::pwt::{LightBasis, LightCoordinates};
    use brdfc_pwt::design::Design;
    use brdfc_pwt::ptm::spread_lights;
    use brdfc_pwt::{LightSamples, PwtRecipe, fit};
    const SIDE: usize = 400;
    const LIGHTS: usize = 72;
    let lights = spread_lights(LIGHTS);
    let rendering = |light: &[f32; 3]| -> Vec<[f32; 3]> {
        let pixel = |k: usize| {
            let (x, y) = ((k % SIDE) as f32, (k / SIDE) as f32);
            let normal = [0.3 * (0.05 * x).sin(), 0.3 * (0.07 * y).cos(), 0.9];
            let cosine: f32 = normal.iter().zip(light).map(|(a, b)| a * b).sum();
            let value = cosine.max(0.0) + 0.3 * cosine.max(0.0).powi(20);
            [0.6 * value, 0.4 * value, 0.3 * value]
        };
        (0..SIDE * SIDE).map(pixel).collect()
    };
    let images: Vec<Vec<[f32; 3]>> = lights.iter().map(rendering).collect();
    let values: Vec<Vec<f32>> = images.iter().map(|image| image.iter().map(|c| c[0]).collect()).collect();
    let basis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 5 };
    let design = Design::new(basis, &lights, 1e-4);
    let samples = LightSamples::new([SIDE, SIDE], lights.clone(), images);
    let mut group = criterion.benchmark_group("relighting");
    group.throughput(Throughput::Elements((SIDE * SIDE * LIGHTS) as u64));
    group.bench_function("factorisation", |b| b.iter(|| Design::new(basis, black_box(&lights), 1e-4)));
    group.bench_function("fit, one channel", |b| b.iter(|| fit::coefficients(&design, black_box(&values))));
    let weights: Vec<f32> = (0..design.terms() * LIGHTS).map(|k| (k % 7) as f32).collect();
    let flat: Vec<f32> = values.concat();
    let mut product = vec![0.0; design.terms() * SIDE * SIDE];
    // One half per core, with the values of each half contiguous.
    let half = SIDE * SIDE / 2;
    group.bench_function("bare matrix product, two cores", |b| {
        b.iter(|| {
            let (left, right) = product.split_at_mut(design.terms() * half);
            let (first, second) = flat.split_at(LIGHTS * half);
            let bare = |values: &[f32], out: &mut [f32]| {
                fit::multiply_add(design.terms(), LIGHTS, half, black_box(&weights), values, out);
            };
            rayon::join(|| bare(first, left), || bare(second, right));
        });
    });
    group.bench_function("encode", |b| {
        b.iter(|| brdfc_pwt::encode(black_box(&samples), &PwtRecipe::default()).expect("renderings in range"));
    });
}

/// Few samples: stages differ by powers of ten, and a run should take about a minute.
fn short() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
        .nresamples(5000)
        .without_plots()
        .configure_from_args()
}

criterion_group! {
    name = benches;
    config = short();
    targets = read, resampling, importance, encoding, decoding, measuring, bandwidth, adaptive, relighting, packing
}
criterion_main!(benches);
