//! `brdfc pwt`: makes packs and polynomial texture maps from photographs under known lights.

mod compare;
mod evaluate;
mod input;
mod make;
mod report;

pub use compare::{PhotographComparison, PhotographErrors, compare_photographs};
pub use evaluate::{Relightable, open_flat_material};
pub use input::{LightInput, any_above_white};
pub use make::{HeldOut, Missed, PwtMade, make, make_map, permutation, recipe_of_map};
pub use report::{LevelReport, PwtReport};
