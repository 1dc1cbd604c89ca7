//! Simulated tables with noise: smoothed tables and their packs, compared with the truth and with the noisy tables.

use brdfc_core::{PackSource, Smooth, Source};
use brdfc_encode::encoders::{table::recipe::TableRecipe, wavelet};
use brdfc_encode::{PackRecipe, encode};
use brdfc_formats::crop::DirectionRange;
use brdfc_metrics::rendering::ReferenceRendering;
use brdfc_readers::merl::Dimensions;
use brdfc_source::Reading;
use brdfc_source::open::{Facts, open};
use brdfc_source::simulate::merl_file;
use brdfc_source::smooth::Smoothed;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

fn truth(model: &str) -> Box<dyn Source> {
    open(model, None).unwrap().source
}

fn delta_e(truth: &dyn Source, source: &dyn Source) -> f64 {
    ReferenceRendering::new(truth, DirectionRange::ALL).0.compare(source).delta_e.mean
}

/// Half the samples of the MERL database along each axis, which is faster.
const DIMENSIONS: Dimensions = Dimensions { theta_half: 45, theta_difference: 45, phi_difference: 90 };
/// Bytes before the values of a table.
const HEADER: usize = 12;

/// Writes a table whose values are multiplied by log-normal noise, the same in all channels, as in simulated scans.
fn write(path: &Path, truth: &dyn Source, noise: f64) {
    let mut bytes = merl_file(truth, DIMENSIONS);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut normal = || {
        let [a, b]: [f64; 2] = random.random();
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    };
    let factors: Vec<f64> = (0..DIMENSIONS.cells()).map(|_| (noise * normal()).exp()).collect();
    for (cell, factor) in bytes[HEADER..].chunks_exact_mut(8).zip(factors.iter().cycle()) {
        let value = f64::from_le_bytes(cell.try_into().unwrap());
        cell.copy_from_slice(&(value * factor).to_le_bytes());
    }
    std::fs::write(path, bytes).unwrap();
}

fn opened(path: &Path, smooth: Option<Smooth>) -> (Box<dyn Source>, Option<Smoothed>) {
    let opened = open(path.to_str().unwrap(), Reading { smooth, ..Reading::default() }).unwrap();
    let Facts::Merl(facts) = &opened.facts else { panic!("a MERL table") };
    (opened.source, facts.smoothed)
}

const CHOSEN: Option<Smooth> = Some(Smooth::Chosen(true));

/// The radii were tuned on the first three models.
const MODELS: [&str; 6] = [
    "synth:ggx?alpha=0.15",
    "synth:ggx?alpha=0.05&kd=0.3,0.1,0.05",
    "synth:lewis",
    "synth:lambert?kd=0.4,0.2,0.1",
    "synth:ward?ax=0.1&ay=0.1",
    "synth:ggx?alpha=0.4&kd=0.1",
];

#[test]
fn smoothed_tables_are_nearer_to_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noisy.binary");
    for model in MODELS {
        let truth = truth(model);
        for (noise, allowed) in [(0.1, 0.25), (0.3, 0.6)] {
            write(&path, &*truth, noise);
            let (rough, none) = opened(&path, None);
            let (smooth, found) = opened(&path, CHOSEN);
            let (before, after) = (delta_e(&*truth, &*rough), delta_e(&*truth, &*smooth));
            println!("{model}, noise {noise}: ΔE {before:.3} before, {after:.3} after, {found:?}");
            let estimate = found.unwrap().noise;
            assert!(
                none.is_none() && after < 0.2 * before && after < allowed && before > 2.0 * allowed,
                "{model} {noise}: {before} {after}"
            );
            assert!((estimate / noise - 1.0).abs() < 0.05, "{model} {noise}: {estimate}");
            assert_eq!(smooth.symmetry(), rough.symmetry(), "{model}");
        }
    }
}

/// Without noise there is nothing to gain, and left-out cells choose to lose nothing. A radius for all cells is the
/// control: it blurs the highlight.
#[test]
fn tables_without_noise_keep_their_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clean.binary");
    for model in [MODELS[0], MODELS[1], MODELS[3], MODELS[5]] {
        let truth = truth(model);
        write(&path, &*truth, 0.0);
        let [before, after, wide] =
            [None, CHOSEN, Some(Smooth::Radius(8))].map(|s| delta_e(&*truth, &*opened(&path, s).0));
        println!("{model}: ΔE {before:.4} before, {after:.4} after, {wide:.4} with radius 8");
        assert!(after < before + 0.01, "{model}: {before} {after}");
        assert!(wide > 2.0 * after || model.contains("lambert"), "{model}: {wide} {after}");
    }
}

/// Every codec encodes the smoothed values.
#[test]
fn packs_of_smoothed_tables_are_nearer_to_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noisy.binary");
    let truth = truth(MODELS[0]);
    write(&path, &*truth, 0.3);
    let [rough, smooth] = [None, CHOSEN].map(|smooth| opened(&path, smooth).0);
    let table = |factored| TableRecipe { factored, ..TableRecipe::default() };
    let recipes: [PackRecipe; 3] = [table(false).into(), table(true).into(), wavelet::recipe::Recipe::visible().into()];
    for recipe in recipes.map(PackRecipe::without_measuring) {
        let [before, after] = [&rough, &smooth].map(|source| {
            let pack = encode(source.as_ref(), &recipe, &()).unwrap().pack;
            delta_e(&*truth, &PackSource::new(&*pack, None))
        });
        println!("{recipe:?}: ΔE {before:.3} before, {after:.3} after");
        assert!(after < 0.6 * before, "{recipe:?}: {before} {after}");
    }
}

#[test]
fn radii_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.binary");
    write(&path, &*truth("synth:lambert"), 0.0);
    for radius in [0, 1, 17, usize::MAX] {
        let reading = Reading { smooth: Some(Smooth::Radius(radius)), ..Reading::default() };
        let error = open(path.to_str().unwrap(), reading).err().unwrap().to_string();
        let expected = format!("found {radius}, expected true, false, or a radius of 2 to 16 cells");
        assert!(error.contains(&expected), "{error}");
    }
}
