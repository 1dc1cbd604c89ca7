//! Searches within a range of directions.

use brdfc_codec::Budget;
use brdfc_core::address::parse_synth;
use brdfc_core::{PackSource, Source};
use brdfc_formats::BrdfPack;
use brdfc_formats::crop::{Crop, DirectionRange, Elevations};
use brdfc_metrics::compare::Reference;
use brdfc_metrics::sampling::PairSet;
use brdfc_table::crop::window;
use brdfc_table::search::recipe::SearchRecipe;
use brdfc_table::search::within::{search_within, smaller};
use brdfc_table::search::{Excess, search, smallest_tried};

fn recipe(directions: DirectionRange, delta_e: f64) -> SearchRecipe {
    let budget = Budget { delta_e: Some(delta_e), ..Budget::default() };
    let mut recipe = SearchRecipe { budget, ..SearchRecipe::default() };
    recipe.table.directions = directions;
    recipe
}

fn range(light: [f32; 2], view: [f32; 2]) -> DirectionRange {
    let [light, view] = [light, view].map(|[from, to]| Elevations { from, to });
    DirectionRange { light, view }
}

const RANGES: [([f32; 2], [f32; 2]); 5] = [
    ([85.0, 90.0], [0.0, 90.0]),
    ([0.0, 10.0], [0.0, 90.0]),
    ([0.0, 90.0], [0.0, 20.0]),
    ([60.0, 90.0], [60.0, 90.0]),
    ([20.0, 90.0], [35.0, 90.0]),
];

/// Bytes of the cropped pack for all directions, and whether it meets the budget within the range.
fn whole_within(source: &dyn Source, recipe: &SearchRecipe) -> (u64, bool) {
    let directions = recipe.table.directions;
    let mut everywhere = recipe.clone();
    everywhere.table.directions = DirectionRange::ALL;
    let whole = search(source, &everywhere, &()).expect("a pack").0.pack;
    let BrdfPack::Table(pack) = whole else { panic!("only tables are tried") };
    let window = window(pack.header(), directions);
    let pack = pack.cropped(Crop { directions, window }).expect("within the table");
    let error = Reference::new(source, PairSet::within(directions)).compare(&PackSource::new(&pack, None));
    (pack.gpu_bytes(), Excess::of(&recipe.budget, &error).is_met())
}

#[test]
fn a_range_costs_no_bytes_if_the_pack_for_all_directions_suffices() {
    let mut did = 0;
    for address in ["synth:ggx?kd=0.3,0.2,0.1&f0=0.04&alpha=0.15", "synth:ggx?kd=0.1,0.2,0.3&f0=0.04&alpha=0.4"] {
        let source = parse_synth(address).expect("an address");
        for (light, view) in RANGES {
            let recipe = recipe(range(light, view), 0.5);
            let made = search_within(source.as_ref(), &recipe, &()).expect("a pack");
            let (bytes, is_met) = whole_within(source.as_ref(), &recipe);
            // The smallest sizes differ by the remainder of 1 KiB.
            let bytes = bytes.max(smallest_tried(source.as_ref(), &recipe));
            assert!(!is_met || made.pack.gpu_bytes() <= bytes, "{address} {light:?} {view:?}: {:?}", made.tried);
            did += usize::from(is_met);
            assert!(made.missed.is_some() || Excess::of(&recipe.budget, &made.off_grid).is_met());
        }
    }
    assert!(did >= 2, "{did}");
}

/// The pack for all directions replaces a larger one, but only if it meets the limits.
#[test]
fn the_pack_for_all_directions_is_used_if_it_suffices() {
    let source = parse_synth("synth:ggx?kd=0.3,0.2,0.1&f0=0.04&alpha=0.3").expect("an address");
    let directions = range([20.0, 90.0], [35.0, 90.0]);
    let large = || search(source.as_ref(), &recipe(directions, 0.05), &()).expect("a pack");
    let (whole, _) = search(source.as_ref(), &recipe(DirectionRange::ALL, 0.5), &()).expect("a pack");
    let of_limit = |delta_e: f64| {
        let (made, reference) = large();
        smaller(&reference, &recipe(directions, delta_e), made, &whole)
    };
    let (taken, retained, before) = (of_limit(2.0), of_limit(0.05), large().0);
    assert!(taken.pack.gpu_bytes() < before.pack.gpu_bytes() && taken.pack.directions() == directions);
    assert!(taken.off_grid.rendering.delta_e.mean <= 2.0 && taken.tried.len() == before.tried.len() + 1);
    let [bytes, _] = [&taken, &retained].map(|made| made.of_all_directions);
    assert_eq!(bytes, Some(whole.pack.gpu_bytes()));
    assert!(retained.bytes == before.bytes && retained.tried.last().is_some_and(|trial| !trial.meets));
}
