//! Simulated tables with noise: packs of smoothed tables, compared with the truth and with packs of the noisy tables.

use brdfc_core::{PackSource, Smooth, Source};
use brdfc_encode::encoders::{table::recipe::TableRecipe, wavelet};
use brdfc_encode::{PackRecipe, encode};
use brdfc_formats::crop::DirectionRange;
use brdfc_metrics::rendering::ReferenceRendering;
use brdfc_readers::merl::Dimensions;
use brdfc_source::Reading;
use brdfc_source::open::{Facts, Opened, open};
use brdfc_source::simulate::merl_file;
use brdfc_testing::wrapped::Noisy;
use std::path::Path;

fn truth(model: &str) -> Box<dyn Source> {
    open(model, None).unwrap().source
}

fn delta_e(truth: &dyn Source, source: &dyn Source) -> f64 {
    ReferenceRendering::new(truth, DirectionRange::ALL).0.compare(source).delta_e.mean
}

/// Writes a table with noise of this standard deviation, a fraction of the value.
fn write(path: &Path, model: &str, noise: f64) {
    let noisy = Noisy { source: truth(model), amplitude: noise * 3f64.sqrt(), seed: 5 };
    std::fs::write(path, merl_file(&noisy, Dimensions::MERL)).unwrap();
}

fn opened(path: &Path, smooth: Smooth) -> Opened {
    open(path.to_str().unwrap(), Reading { smooth, ..Reading::default() }).unwrap()
}

/// Mean ΔE of a source, and of its table, factored and wavelet packs of default size.
fn errors(truth: &dyn Source, source: &dyn Source) -> [f64; 4] {
    let packed = |recipe: PackRecipe| {
        let pack = encode(source, &recipe.without_measuring(), &()).unwrap().pack;
        delta_e(truth, &PackSource::new(&*pack, None))
    };
    let table = TableRecipe::default();
    let factored = TableRecipe { factored: true, ..table };
    let wavelet = wavelet::recipe::Recipe::visible();
    [delta_e(truth, source), packed(table.into()), packed(factored.into()), packed(wavelet.into())]
}

#[test]
fn smoothed_tables_are_nearer_to_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noisy.binary");
    for model in ["synth:ggx?alpha=0.15", "synth:ggx?alpha=0.05&kd=0.3,0.1,0.05", "synth:ggx?alpha=0.02", "synth:lewis"] {
        let truth = truth(model);
        for noise in [0.0, 0.1, 0.3] {
            write(&path, model, noise);
            let [rough, smoothed] = [false, true].map(|is_smooth| {
                let opened = opened(&path, Smooth::Chosen(is_smooth));
                if let Facts::Merl(facts) = &opened.facts {
                    println!("{:?}", facts.smoothed);
                }
                assert!(opened.source.symmetry().reciprocal && opened.source.symmetry().isotropic);
                errors(truth.as_ref(), opened.source.as_ref())
            });
            if noise == 0.3 {
                let s = opened(&path, Smooth::Chosen(true)).source;
                let r = opened(&path, Smooth::Chosen(false)).source;
                for th in [0.2f64, 0.8, 1.2] { for phi in [0.5f64, 2.0, 3.0] {
                    let mut t = brdfc_core::Tally::default();
                    let (mut sum, mut raw, mut n) = (0.0, 0.0, 0.0);
                    for k in 0..40 { let d = 0.01 * k as f64;
                        let pair = brdfc_formats::direction::DirectionPair::from_angles(th, 0.0, th * 0.7 + 0.3 * d, phi + d);
                        let e = truth.eval(pair, &mut t)[1];
                        sum += s.eval(pair, &mut t)[1] / e; raw += r.eval(pair, &mut t)[1] / e; n += 1.0; }
                    println!("  {th} {phi}: {:.3} raw {:.3}", sum / n, raw / n);
                } }
            }
            println!("{model} {noise}: {rough:.2?} {smoothed:.2?}");
        }
    }
}
