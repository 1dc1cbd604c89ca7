//! Encodes committed inputs and compares the bytes, and the decoded values, with the codec's list: see docs/goldens.md.

use brdfc_importance::{HalfGrid, ImportanceRecipe, importance_samples};
use brdfc_source::open::open;
use brdfc_testing::golden::encodes::{Packs, check_encodes};
use brdfc_testing::testdata;

#[test]
fn importance_sample_packs() {
    let recipe = ImportanceRecipe {
        isotropic_polar: 6,
        anisotropic_polar: 3,
        anisotropic_azimuths: 4,
        samples: 16,
        grid: HalfGrid { polar: 32, azimuths: 16 },
        defensive: 0.1,
    };
    let pack = |input: &str| {
        let source = open(input, None).unwrap_or_else(|error| panic!("{error}")).source;
        importance_samples(source.as_ref(), &recipe).expect("sizes in range").0.to_bytes(true)
    };
    let packs = Packs::from([
        ("isotropic.ktx2".to_owned(), pack(&testdata("demo/red_plastic.binary"))),
        ("anisotropic.ktx2".to_owned(), pack("synth:ward?ax=0.15&ay=0.5")),
    ]);
    check_encodes("importance", &packs, |_| true);
}
