//! Evaluation at lists with cached angles gives the same bits as pair by pair.

use brdfc_core::address::parse_synth;
use brdfc_core::{PackSource, Source};
use brdfc_formats::direction::DirectionPair;
use brdfc_metrics::rendering::rendering_pairs;
use brdfc_metrics::sampling::PairSet;
use brdfc_metrics::values::{values_at, values_of_list};
use brdfc_readers::merl::{Dimensions, Merl, write};
use brdfc_source::MerlSource;
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_testing::codecs::table::tables;

/// Tables with missing cells, over half a turn and over a whole one.
fn merl(phi_difference: usize) -> MerlSource {
    let dimensions = Dimensions { theta_half: 12, theta_difference: 10, phi_difference };
    let value = |[h, d, p]: [f64; 3]| {
        let missing = d > 1.2 || (h > 0.3 && h < 0.5 && p < 0.4);
        (!missing).then(|| [(-9.0 * h).exp() + 0.1, 0.2 + d, 1.5 + (2.0 * p).sin()])
    };
    let mut bytes = Vec::new();
    write(&mut bytes, dimensions, value).unwrap();
    MerlSource::new(Merl::from_bytes(&bytes).unwrap())
}

fn bits(values: &[[f64; 3]]) -> Vec<[u64; 3]> {
    values.iter().map(|value| value.map(f64::to_bits)).collect()
}

fn check(name: &str, source: &dyn Source) {
    for list in [PairSet::comparison().pairs, rendering_pairs()] {
        let (plain, of_list) = (values_at(source, &list), values_of_list(source, &list));
        assert!(bits(&plain.0) == bits(&of_list.0) && plain.1 == of_list.1, "{name}: {:?} {:?}", plain.1, of_list.1);
        // Control: values at other pairs differ.
        let exchanged: Vec<DirectionPair> = list.iter().rev().map(|pair| pair.exchanged()).collect();
        assert!(bits(&values_at(source, &exchanged).0) != bits(&of_list.0), "{name}");
    }
}

#[test]
fn measured_tables_are_the_same_bits() {
    for phi_difference in [20, 40] {
        let source = merl(phi_difference);
        let tally = values_at(&source, &PairSet::comparison().pairs).1;
        assert!(tally.partly_invalid > 100 && tally.nearest_valid > 100, "{tally:?}");
        check("merl", &source);
    }
}

#[test]
fn packs_and_models_are_the_same_bits() {
    for (name, pack) in tables() {
        check(&name, &PackSource::new(&pack, None));
    }
    let model = parse_synth("synth:ward?ax=0.1&ay=0.4").unwrap();
    check("model", model.as_ref());
    let recipe = TableRecipe { size: Size::Bytes(4096), ..TableRecipe::default() };
    check(
        "anisotropic pack",
        &PackSource::new(&brdfc_table::encode::encode(model.as_ref(), &recipe, &()).unwrap().pack, None),
    );
}
