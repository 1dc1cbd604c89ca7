//! From a meso-structure, or an ordinary BTF, to the packs of a flat BTF.

mod asset;
mod input;
mod recipe;
mod run;

pub use asset::{AssetErrors, AssetFile, AssetReport, PartFile};
pub use input::{Geometry, MesoInputError, MesoOptions, material_list, open_appearance, open_geometry};
pub use recipe::{FlattenRecipe, Form, Settings};
pub use run::{FlattenError, FlattenJob, FlattenWatcher, Values, run};
