//! `brdfc pwt`: makes packs, polynomial texture maps, normals and images for web viewers from photographs under known lights.

mod compare;
mod evaluate;
mod input;
mod limits;
mod make;
mod options;
mod photographs;
mod report;
mod surface;
mod views;
mod web;

pub use compare::{PhotographComparison, PhotographErrors, compare_photographs};
pub use evaluate::{Relightable, open_flat_material};
pub use input::{LightInput, any_above_white};
pub use make::{HeldOut, HeldOutViews, HoldOut, PwtMade, make, make_map, permutation, recipe_of_map};
pub use options::PwtOptions;
pub use photographs::DistantPhotographs;
pub use report::{LevelReport, PwtReport};
pub use surface::{SurfaceReport, albedo_png, make_surface, normals_png};
pub use views::{BtfComparison, ViewChoice, ViewErrors, compare_btf};
pub(crate) use web::jpeg;
pub use web::{WebExport, WebReport, make_web, make_web_of_map};
