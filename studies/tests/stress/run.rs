//! Runs the stress tests of every stage.

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

/// Returns all rows. With `small` there are fewer cases, and grids only up to 16.
pub fn stress(stages: &Stages, small: bool) -> StressStudy {
    StressStudy { rows: ALL.iter().flat_map(|of_kind| of_kind(stages, small)).collect() }
}
