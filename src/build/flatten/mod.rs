//! From a meso-structure, or an ordinary BTF, to the packs of a flat BTF.

mod asset;
mod check;
mod input;
mod parts;
mod pass;
mod probing;
mod recipe;
mod run;
mod stack;

pub use asset::{AssetErrors, AssetFile, AssetReport, PartFile};
pub use input::{Geometry, MesoInputError, MesoOptions, material_list, open_appearance, open_geometry};
pub use recipe::{FlattenRecipe, Form, Settings};
pub use run::{FlattenError, FlattenJob, FlattenWatcher, Values, run};
