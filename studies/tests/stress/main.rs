//! Every stage at the ends of its range: bounds of `brdfc-bench --study stress` hold, and detect broken stages.

use brdfc_studies::stress::{
    CONTROLS, Measure, Stages, StressRow, StressStudy, Worst, stress as rows, stress_with_controls,
};

#[test]
fn every_bound_holds() {
    let small = std::env::var_os("BRDFC_ENGINES").is_none();
    if small {
        println!("skipped: grids of 32 and 64 and most cases: half a minute, with BRDFC_ENGINES set");
    }
    let study = rows(&Stages::default(), small);
    for row in &study.rows {
        println!("{}: {}: {:.2e} {:?} of {:.2e}: {}", row.stage, row.fed, row.error, row.measure, row.bound, row.why);
    }
    let broken: Vec<&StressRow> = study.broken().collect();
    assert!(study.rows.len() > 40 && broken.is_empty(), "{broken:#?}");
    assert!(study.rows.iter().all(|row| row.error.is_finite() && row.cases > 0 && !row.why.is_empty()));
}

#[test]
fn a_bound_that_is_too_tight_is_broken() {
    let row = |error: f64, bound: f64| {
        let mut worst = Worst::default();
        worst.add(error);
        worst.row(["stage", "fed"], Measure::Relative, bound, "why")
    };
    assert!(row(-1e-7, 1e-7).holds);
    for (error, bound) in [(1.1e-7, 1e-7), (f64::NAN, 1e300), (f64::INFINITY, 1e300)] {
        let row = row(error, bound);
        assert!(!row.holds && row.error.is_finite(), "{row:?}");
        assert_eq!(StressStudy { rows: vec![row] }.broken().count(), 1);
    }
    assert!(!Worst::default().row(["stage", "fed"], Measure::Count, 0.0, "why").holds, "nothing was compared");
    // For every row that is not exact: a bound below the observed error.
    let study = rows(&Stages::default(), true);
    let tightened = study.rows.into_iter().filter(|row| row.error > 0.0).map(holds_below);
    assert!(tightened.clone().count() > 20);
    tightened.for_each(|holds| assert!(!holds));
}

fn holds_below(row: StressRow) -> bool {
    let mut worst = Worst::default();
    worst.add(row.error);
    worst.row([&row.stage, &row.fed], row.measure, 0.99 * row.error, &row.why).holds
}

/// Negative control: each stage is deliberately broken, some only by a few roundings, and its row must detect it.
#[test]
fn broken_stages_are_detected() {
    for control in CONTROLS {
        assert!(!control.detected(true).is_empty(), "{}: broken, but not detected", control.stage);
    }
}

/// The study lists the errors of broken stages next to the bounds that detect them.
#[test]
fn the_study_has_rows_and_controls() {
    let stress = stress_with_controls(true, |_, _| {});
    assert_eq!(stress.rows.len(), rows(&Stages::default(), true).rows.len());
    for row in stress.rows {
        let control = row.control.as_ref().unwrap_or_else(|| panic!("no negative control: {row:?}"));
        assert!(row.holds && row.error <= row.bound && control.error > row.bound, "{row:?}");
    }
}
