//! Flat BTFs: their inputs are opened, `brdfc_flat_btf::encode` makes them, and their files are put in place.

mod asset;
mod comparison;
mod describe;
mod error;
mod files;
mod images;
mod input;
mod parts;
mod read;
mod run;
mod scratch;
mod store;
pub mod words;

pub use asset::{AssetFile, PartFile, Settings};
pub use comparison::{FlatComparison, compare_flat};
pub use describe::{MeshFacts, SurfaceFacts, describe_surface};
pub use error::FlattenError;
pub use input::{Geometry, MesoInputError, MesoOptions, PLANE, material_list, open_appearance, open_geometry};
pub use read::open_asset;
pub use run::{FlattenJob, Values, run};
