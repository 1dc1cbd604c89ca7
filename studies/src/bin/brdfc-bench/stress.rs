//! The study of numerical stability.

use super::arguments::Arguments;
use brdfc_studies::StudyResult;
use brdfc_studies::stress::{Measure, StressStudy, stress_with_controls};
use brdfc_terminal::output::remark;
use brdfc_terminal::table::plain;
use brdfc_terminal::{Common, Error};

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let study = stress_with_controls(arguments.small, |done, all| remark(common, &format!("{done} of {all} steps")));
    Ok(StudyResult::Stress(study))
}

/// Returns an error if a bound does not hold.
pub(super) fn check(result: &StudyResult) -> Result<(), Error> {
    let StudyResult::Stress(study) = result else { return Ok(()) };
    let broken: Vec<String> = study.broken().map(|row| format!("{}, {}", row.stage, row.fed)).collect();
    if broken.is_empty() { Ok(()) } else { Err(Error::check(format!("above their bound: {}", broken.join("; ")))) }
}

pub(super) fn text(study: &StressStudy) -> String {
    let header = ["stage", "condition", "cases", "measured", "bound", "unit", "negative control"];
    let cells: Vec<Vec<String>> = study
        .rows
        .iter()
        .map(|row| {
            let control = row.control.as_ref();
            vec![
                row.stage.clone(),
                row.fed.clone(),
                row.cases.to_string(),
                format!("{:.1e}", row.error),
                format!("{:.1e}", row.bound),
                unit(row.measure).to_owned(),
                control.map_or_else(|| "-".to_owned(), |broken| format!("{:.1e}: {}", broken.error, broken.change)),
            ]
        })
        .collect();
    let broken = study.broken().count();
    let (rows, controls) = (study.rows.len(), study.rows.iter().filter(|row| row.control.is_some()).count());
    plain(&header, &cells)
        + &format!(
            "\n{rows} rows, {broken} above their bound. Negative control: error of a stage that is broken on purpose, where it \
             exceeds the bound ({controls} rows).\n"
        )
}

/// Unit of errors.
fn unit(measure: Measure) -> &'static str {
    match measure {
        Measure::Absolute => "of the value",
        Measure::Relative => "share",
        Measure::Steps => "steps",
        Measure::OfBound => "of bound",
        Measure::Count => "wrong",
    }
}
