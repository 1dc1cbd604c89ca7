//! Runs the stress tests of every stage.

use super::controls::CONTROLS;
use super::row::{BrokenRow, StressRow, StressStudy};
use super::stages::Stages;
use super::{decode, directions, encode, logarithms, neighbourhoods, pack, propagation, tables, texels, transforms};

/// Rows of one kind of stage.
type Rows = fn(&Stages, bool) -> Vec<StressRow>;

const ALL: [Rows; 10] = [
    directions::rows,
    logarithms::rows,
    transforms::rows,
    texels::rows,
    pack::rows,
    decode::rows,
    tables::rows,
    neighbourhoods::rows,
    propagation::rows,
    encode::rows,
];

/// Returns all rows. With `small` there are fewer cases, and grids only up to 16.
pub fn stress(stages: &Stages, small: bool) -> StressStudy {
    StressStudy { rows: ALL.iter().flat_map(|of_kind| of_kind(stages, small)).collect() }
}

/// Returns all rows of the program's own stages, and the errors of broken stages where they exceed the bound. Calls
/// `progress` with the number of finished steps and their total.
pub fn stress_with_controls(small: bool, progress: impl Fn(usize, usize)) -> StressStudy {
    let steps = 1 + CONTROLS.len();
    let mut study = stress(&Stages::default(), small);
    progress(1, steps);
    for (number, control) in CONTROLS.iter().enumerate() {
        for broken in control.detected(small) {
            let same = |row: &&mut StressRow| row.stage == broken.stage && row.fed == broken.fed && row.holds;
            for row in study.rows.iter_mut().filter(same).filter(|row| row.control.is_none()) {
                row.control = Some(BrokenRow { change: control.change.to_owned(), error: broken.error });
            }
        }
        progress(2 + number, steps);
    }
    study
}
