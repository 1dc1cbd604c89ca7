//! Encodes a material and compares the bytes, and the decoded values, with the codec's list: see docs/goldens.md.

use crate::ENVIRONMENTS;
use brdfc_core::address::parse_synth;
use brdfc_lobes::{LobesRecipe, encode};
use brdfc_testing::golden::encodes::{Packs, check_encodes};

#[test]
fn packs_of_lobes() {
    let recipe = LobesRecipe { max_fetches: 4, ..LobesRecipe::default() };
    let source = parse_synth("synth:ggx?alpha=0.2").expect("a model");
    let encoded = encode(source.as_ref(), &ENVIRONMENTS, &recipe, &()).expect("an isotropic material");
    let packs = Packs::from([("ggx.ktx2".to_owned(), encoded.best().pack.to_bytes(true))]);
    check_encodes("lobes", &packs, |_| true);
}
