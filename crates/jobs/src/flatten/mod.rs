//! From a meso-structure, or an ordinary BTF, to the packs of a flat BTF.

mod asset;
mod check;
mod comparison;
mod describe;
mod error;
mod factors;
mod files;
mod input;
mod parts;
mod pass;
mod probing;
mod read;
mod recipe;
mod run;
mod stack;
pub mod words;

pub use asset::{AssetErrors, AssetFile, AssetReport, PartFile};
pub use comparison::{FlatComparison, compare_flat};
pub use describe::{MeshFacts, SurfaceFacts, describe_surface};
pub use error::FlattenError;
pub use input::{Geometry, MesoInputError, MesoOptions, PLANE, material_list, open_appearance, open_geometry};
pub use read::open_asset;
pub use recipe::{FlattenRecipe, Form, Settings};
pub use run::{FlattenJob, Values, run};
