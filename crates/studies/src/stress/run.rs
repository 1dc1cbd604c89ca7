//! Puts every stage to stress.

use super::row::{StressRow, StressStudy};
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

/// All rows; of the small form fewer cases, and grids to 16. `done` is told how many of how many kinds of stages are done.
pub fn stress(stages: &Stages, small: bool, done: &dyn Fn(usize, usize)) -> StressStudy {
    let mut rows = Vec::new();
    for (number, of_kind) in ALL.iter().enumerate() {
        rows.extend(of_kind(stages, small));
        done(number + 1, ALL.len());
    }
    StressStudy { rows }
}
