//! Flat BTFs: opens their inputs, encodes them with `brdfc_flat_btf::encode`, and writes their file.

mod asset;
mod comparison;
mod describe;
mod flat_images;
mod images;
mod input;
mod read;
mod run;
mod scratch;
pub mod surface;
mod trees;
pub mod words;

pub use asset::{AssetFile, FlatAsset, Settings};
pub use comparison::compare_flat;
pub use describe::{MeshFacts, SurfaceFacts, describe_surface};
pub use input::{
    Geometry, ImageFacts, MesoOptions, PLANE, Surface, Values, material_list, open_appearance, open_geometry,
};
pub use read::{open_asset, read_report};
pub use run::{FlattenJob, run};
