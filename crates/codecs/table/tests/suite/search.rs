//! The search for the smallest table that meets a budget.

use brdfc_codec::{Budget, EncodeError, Trial};
use brdfc_core::address::parse_synth;
use brdfc_readers::merl::{Dimensions, Merl};
use brdfc_source::MerlSource;
use brdfc_source::simulate::merl_file;
use brdfc_table::levels::MAX_LEVELS;
use brdfc_table::recipe::TableRecipe;
use brdfc_table::search::recipe::{LARGEST, SearchRecipe, Tables};
use brdfc_table::search::{EncodedTable, SMALLEST, has_stalled, search, sizes};
use std::collections::BTreeSet;

fn searched(address: &str, budget: Budget) -> EncodedTable {
    let source = parse_synth(address).unwrap();
    search(source.as_ref(), &SearchRecipe { budget, ..SearchRecipe::default() }, &()).unwrap().0
}

const NONE: Budget = Budget::NONE;

#[test]
fn sizes_double_up_to_the_budget() {
    assert_eq!(sizes(1024, Some(5000), LARGEST), [1024, 2048, 4096, 5000]);
    assert_eq!(sizes(1024, Some(100), LARGEST), [100]);
    assert_eq!(sizes(4096, None, 1 << 19).last(), Some(&(1 << 19)));
    assert_eq!(sizes(4096, Some(1 << 40), LARGEST), sizes(4096, None, LARGEST));
}

/// The result is the smallest tried table that meets the budget, and none skipped since the last miss does.
#[test]
fn the_result_is_the_smallest_that_meets() {
    for limit in [0.6, 0.3, 0.15] {
        let made = searched("synth:ggx?kd=0.3,0.1,0.05&alpha=0.1", Budget { delta_e: Some(limit), ..NONE });
        let meeting = made.tried.iter().filter(|trial| trial.meets);
        assert_eq!(meeting.map(|trial| trial.bytes_on_gpu).min(), Some(made.pack.gpu_bytes()));
        assert!(made.missed.is_none() && made.off_grid.rendering.delta_e.mean <= limit);
    }
    assert!(searched("synth:lambert", Budget::default()).pack.gpu_bytes() <= SMALLEST);
}

/// If no table meets the budget, the largest was tried, and the result is the best.
#[test]
fn the_result_is_the_best_where_none_meets() {
    let budget = Budget { error: Some(1e-7), bytes: Some(20_000), ..NONE };
    let made = searched("synth:ggx?kd=0.3,0.1,0.05&alpha=0.1", budget);
    let least = made.tried.iter().map(|trial| trial.relative_error).fold(f64::INFINITY, f64::min);
    assert!(made.off_grid.norms.relative_mean == least && made.missed.is_some());
    assert!(made.tried.iter().any(|trial| trial.bytes_on_gpu > 19_000), "{:?}", made.tried);
}

/// The maximum number of levels, with colours, which take most bytes.
#[test]
fn any_number_of_levels_is_searched() {
    for address in ["synth:ggx?kd=0.3,0.1,0.05&f0=0.5&alpha=0.1", "synth:velvet?kd=0.1,0.2,0.4", "synth:lambert?kd=0"] {
        let source = parse_synth(address).unwrap();
        let table = TableRecipe { levels: MAX_LEVELS, ..TableRecipe::default() };
        for bytes in [None, Some(2048)] {
            let budget = Budget { bytes, ..Budget::default() };
            let recipe = SearchRecipe { budget, is_asked: false, table: table.clone(), tables: Tables::Factored };
            let (made, _) = search(source.as_ref(), &recipe, &()).unwrap();
            assert!(made.pack.levels() == MAX_LEVELS && made.pack.gpu_bytes() <= bytes.unwrap_or(LARGEST));
        }
    }
}

/// A table fits into fewer bytes than a curve.
#[test]
fn few_bytes_hold_a_table() {
    let made = searched("synth:ggx?kd=0.3,0.1,0.05&alpha=0.3", Budget { bytes: Some(200), ..NONE });
    assert!(made.pack.gpu_bytes() <= 200 && made.tried.iter().all(|trial| trial.codec == "table"));
    let none = Budget { bytes: Some(100), ..NONE };
    let source = parse_synth("synth:ggx").unwrap();
    let refused =
        search(source.as_ref(), &SearchRecipe { budget: none, ..SearchRecipe::default() }, &()).map(|(made, _)| made);
    assert!(matches!(refused, Err(EncodeError::TooFewBytes { .. })), "{refused:?}");
}

/// Symmetrising causes the error, and more nodes do not reduce it.
#[test]
fn stalled_searches_stop() {
    let one_way = brdfc_testing::wrapped::OneWay(parse_synth("synth:ggx?kd=0.3,0.1,0.05&alpha=0.3").unwrap());
    let table = TableRecipe { reciprocal: true, ..TableRecipe::default() };
    let recipe = SearchRecipe { table, ..SearchRecipe::default() };
    let (made, _) = search(&one_way, &recipe, &()).unwrap();
    assert!(made.missed.is_some() && made.pack.gpu_bytes() < LARGEST / 4, "{:?}", made.tried);
}

/// Tables for a dark mirror as a MERL file: between the samples of its highlight nothing is known, and more nodes do not help.
fn of_dark_mirror(alpha: f64) -> EncodedTable {
    let model = parse_synth(&format!("synth:ggx?kd=0.002&f0=0.04&alpha={alpha}")).unwrap();
    let file = merl_file(model.as_ref(), Dimensions::MERL);
    let mirror = MerlSource::new(Merl::from_bytes(&file).unwrap());
    let budget = Budget { delta_e: Some(0.03), ..NONE };
    search(&mirror, &SearchRecipe { budget, ..SearchRecipe::default() }, &()).unwrap().0
}

/// Factored tables are tried from where the errors of plain ones stall, and again below one that meets the limits.
#[test]
fn no_size_is_tried_twice() {
    let made = of_dark_mirror(0.02);
    let of = |trial: &Trial| (trial.codec.clone(), trial.size.clone(), trial.bytes_on_gpu);
    let distinct: BTreeSet<_> = made.tried.iter().map(of).collect();
    assert_eq!(distinct.len(), made.tried.len(), "{:?}", made.tried);
    assert!(made.tried.iter().any(|trial| trial.meets) && made.tried.len() > 5, "{:?}", made.tried);
}

#[test]
fn a_dark_mirror_gets_no_more_bytes_than_help() {
    let made = of_dark_mirror(0.01);
    let least = made.tried.iter().map(|trial| trial.delta_e).fold(f64::INFINITY, f64::min);
    assert!(made.missed.is_none() || made.off_grid.rendering.delta_e.mean < 1.1 * least, "{:?}", made.tried);
    assert!(made.tried.iter().all(|trial| trial.bytes_on_gpu < LARGEST / 4), "{:?}", made.tried);
    assert!(made.pack.gpu_bytes() < LARGEST / 8, "{:?}", made.tried);
}

#[test]
fn errors_that_fall_slowly_have_stalled() {
    let of = |excesses: &[f64]| excesses.iter().enumerate().map(|(k, e)| (1 << (10 + k), *e)).collect::<Vec<_>>();
    let largest = 1 << 19;
    assert!(!has_stalled(&of(&[3.0, 2.9]), largest), "a single step is not enough");
    assert!(has_stalled(&of(&[3.0, 2.9, 2.95]), largest) && has_stalled(&of(&[1.5, 1.6, 1.5]), largest));
    assert!(!has_stalled(&of(&[8.0, 5.0, 3.2]), largest) && !has_stalled(&of(&[3.0, 4.0, 1.5]), largest));
    assert!(!has_stalled(&of(&[1.1, 1.09, 1.05]), largest), "a little is enough");
}

#[test]
fn bytes_alone_get_the_closest_that_fits() {
    let made = searched("synth:ward?ax=0.15&ay=0.5", Budget { bytes: Some(16_384), ..NONE });
    let least = made.tried.iter().map(|trial| trial.delta_e).fold(f64::INFINITY, f64::min);
    assert!(made.tried.len() == 4 && made.off_grid.rendering.delta_e.mean == least, "{:?}", made.tried);
    assert!(made.tried.iter().all(|trial| trial.bytes_on_gpu <= 16_384));
}
