//! Encodes training environments and compares the bytes, and the decoded values, with the codec's list: see
//! docs/goldens.md.

use brdfc_environment::prefilter;
use brdfc_environment::training::TrainingEnvironment;
use brdfc_testing::golden::encodes::{Packs, check_encodes};

#[test]
fn prefiltered_environments() {
    let pack = |seed: u64| {
        let environment = TrainingEnvironment::new(seed);
        prefilter(&|direction| environment.radiance(direction), 16, 2, &()).expect("radiance in range").to_bytes(true)
    };
    let packs = Packs::from([("noise.ktx2".to_owned(), pack(0)), ("sky.ktx2".to_owned(), pack(1))]);
    check_encodes("environment", &packs, |_| true);
}
