//! Simulated tables with noise: smoothed tables and their packs, compared with the truth and with the noisy tables.

use brdfc_core::{PackSource, Smooth, Source};
use brdfc_encode::encoders::{table::recipe::TableRecipe, wavelet};
use brdfc_encode::{PackRecipe, encode};
use brdfc_formats::crop::DirectionRange;
use brdfc_metrics::rendering::ReferenceRendering;
use brdfc_readers::merl::Dimensions;
use brdfc_source::Reading;
use brdfc_source::open::{Facts, Opened, open};
use brdfc_source::simulate::merl_file;
use brdfc_source::smooth::Smoothed;
use brdfc_testing::wrapped::Noisy;
use std::path::{Path, PathBuf};

fn truth(model: &str) -> Box<dyn Source> {
    open(model, None).unwrap().source
}

fn delta_e(truth: &dyn Source, source: &dyn Source) -> f64 {
    ReferenceRendering::new(truth, DirectionRange::ALL).0.compare(source).delta_e.mean
}

/// Writes a table with noise of this standard deviation, a fraction of the value.
fn written(folder: &Path, model: &str, noise: f64) -> PathBuf {
    let noisy = Noisy { source: truth(model), amplitude: noise * 3f64.sqrt(), seed: 5 };
    let path = folder.join("noisy.binary");
    std::fs::write(&path, merl_file(&noisy, Dimensions::MERL)).unwrap();
    path
}

fn opened(path: &Path, smooth: Option<Smooth>) -> Opened {
    open(path.to_str().unwrap(), Reading { smooth, ..Reading::default() }).unwrap()
}

fn smoothed(opened: &Opened) -> Option<Smoothed> {
    let Facts::Merl(facts) = &opened.facts else { panic!("a MERL table") };
    facts.smoothed
}

/// TEMP
#[test]
fn temp_measure() {
    let folder = tempfile::tempdir().unwrap();
    for model in std::env::var("MODELS").unwrap().split(' ') {
        let truth = truth(model);
        for noise in [0.0, 0.03, 0.1, 0.3] {
            let path = written(folder.path(), model, noise);
            let rough = delta_e(&*truth, &*opened(&path, None).source);
            let t = std::time::Instant::now();
            let o = opened(&path, Some(Smooth::Chosen(true)));
            let t = t.elapsed().as_secs_f64();
            println!("{model} {noise}: {rough:.3} -> {:.3} {:?} {t:.1} s", delta_e(&*truth, &*o.source), smoothed(&o));
        }
    }
}
