//! The study of numerical stress.

use super::arguments::Arguments;
use crate::Common;
use crate::output::remark;
use crate::table::plain;
use brdfc_studies::StudyResult;
use brdfc_studies::stress::{Measure, Stages, StressRow, StressStudy, stress};
use std::time::Instant;

pub(super) fn run(arguments: &Arguments, common: Common) -> StudyResult {
    let started = Instant::now();
    let done = |done: usize, all: usize| {
        let seconds = started.elapsed().as_secs_f64();
        let left = seconds / done as f64 * (all - done) as f64;
        remark(common, &format!("{done} of {all} kinds of stages, {seconds:.1} s, about {left:.0} s left"));
    };
    StudyResult::Stress(stress(&Stages::default(), arguments.small, &done))
}

/// The sentence about bounds that do not hold, if any.
pub(super) fn broken(study: &StressStudy) -> Option<String> {
    let broken: Vec<String> = study
        .broken()
        .map(|row| {
            let (error, bound) = (number(row.measure, row.error), number(row.measure, row.bound));
            format!("{}, fed {}: found {error} {}; allowed {bound}", row.stage, row.fed, row.measure.name())
        })
        .collect();
    (!broken.is_empty()).then(|| broken.join("\n"))
}

fn number(measure: Measure, value: f64) -> String {
    match measure {
        Measure::Count => format!("{value}"),
        Measure::OfBound | Measure::Steps => format!("{value:.3}"),
        _ if value == 0.0 => "0".to_owned(),
        _ => format!("{value:.1e}"),
    }
}

pub(super) fn text(study: &StressStudy) -> String {
    let header = ["stage, and what it is fed", "cases", "error", "worst", "bound", "holds"];
    let cells = |row: &StressRow| {
        vec![
            format!("{}: {}", row.stage, row.fed),
            row.cases.to_string(),
            row.measure.name().to_owned(),
            number(row.measure, row.error),
            number(row.measure, row.bound),
            if row.holds { "yes" } else { "NO" }.to_owned(),
        ]
    };
    let mut text = plain(&header, &study.rows.iter().map(cells).collect::<Vec<_>>());
    text += "\nWhy these bounds (of its bound: a share of what is said here):\n";
    for row in &study.rows {
        text += &format!("- {}: {}: {}\n", row.stage, row.fed, row.why);
    }
    let broken = study.broken().count();
    text + &match broken {
        0 => format!("\nAll {} bounds hold.\n", study.rows.len()),
        _ => format!("\n{broken} of {} bounds do not hold.\n", study.rows.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_bounds_are_told() {
        let row = |error: f64| StressRow {
            stage: "a stage".to_owned(),
            fed: "numbers".to_owned(),
            cases: 3,
            measure: Measure::Relative,
            error,
            bound: 1e-6,
            why: "it rounds".to_owned(),
            holds: error <= 1e-6,
        };
        let fine = StressStudy { rows: vec![row(1e-7)] };
        assert!(broken(&fine).is_none() && text(&fine).contains("All 1 bounds hold"));
        let wrong = StressStudy { rows: vec![row(1e-7), row(2e-6)] };
        assert_eq!(broken(&wrong).unwrap(), "a stage, fed numbers: found 2.0e-6 relative; allowed 1.0e-6");
        assert!(text(&wrong).contains("1 of 2 bounds do not hold") && text(&wrong).contains("NO"));
    }
}
