//! `brdfc pwt`: photographs under known lights become a pack, or a polynomial texture map.

mod error;
mod evaluate;
mod input;
mod make;
mod report;

pub use error::PwtError;
pub use evaluate::Relightable;
pub use input::{LightInput, photographs};
pub use make::{HeldOut, PwtMade, errors_of, make, make_map, permutation, recipe_of_map, to_png};
pub use report::{LevelReport, PwtReport, TextureReport};
