//! The study of numerical stability.

use super::arguments::Arguments;
use brdfc_studies::StudyResult;
use brdfc_studies::stress::{BrokenRow, Measure, StressRow, StressStudy, stress_with_controls};
use brdfc_terminal::output::remark;
use brdfc_terminal::table::plain;
use brdfc_terminal::{Common, Error};

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let study = stress_with_controls(arguments.small, |done, all| remark(common, &format!("{done} of {all} steps")));
    Ok(StudyResult::Stress(study))
}

/// Returns an error if a bound does not hold, or does not detect any broken stage.
pub(super) fn check(result: &StudyResult) -> Result<(), Error> {
    let StudyResult::Stress(study) = result else { return Ok(()) };
    let refuse = |what: &str, rows: Vec<&StressRow>| {
        let names: Vec<String> = rows.iter().map(|row| format!("{}, {}", row.stage, row.fed)).collect();
        if names.is_empty() { Ok(()) } else { Err(Error::check(format!("{what}: {}", names.join("; ")))) }
    };
    refuse("above their bound", study.broken().collect())?;
    refuse("without a negative control", study.rows.iter().filter(|row| row.control.is_none()).collect())
}

pub(super) fn text(study: &StressStudy) -> String {
    let header = ["stage", "condition", "measured", "bound", "unit", "negative control"];
    let cells: Vec<Vec<String>> = study
        .rows
        .iter()
        .map(|row| {
            let of_control = |broken: &BrokenRow| match broken.error {
                f64::MAX => format!("not finite: {}", broken.change),
                error => format!("{error:.0e}: {}", broken.change),
            };
            vec![
                row.stage.clone(),
                row.fed.clone(),
                format!("{:.0e}", row.error),
                format!("{:.1e}", row.bound),
                unit(row.measure).to_owned(),
                row.control.as_ref().map_or("-".to_owned(), of_control),
            ]
        })
        .collect();
    let broken = study.broken().count();
    plain(&header, &cells)
        + &format!(
            "\n{} rows, {broken} above their bound. Negative control: error of the stage with this change.\n",
            study.rows.len()
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
