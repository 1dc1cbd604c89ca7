//! Flat BTFs of surfaces with relief, and of ordinary BTFs: `brdfc flatten`.
//!
//! [`open_geometry`] and [`open_appearance`] read what [`run`] flattens; [`open_asset`] reads what it wrote.

pub use brdfc_flat_btf::encode::{FlattenRecipe, Form};
pub use brdfc_flat_btf::factored::FactoredTarget;
pub use brdfc_flat_btf::fill::FillMethod;
pub use brdfc_flat_btf::probes::ColourErrors;
pub use brdfc_flat_btf::structures::{STRUCTURES, describe_structures};
pub use brdfc_jobs::btf_stack::StackFormat;
pub use brdfc_jobs::flatten::{
    AssetFile, FlatAsset, FlattenError, FlattenJob, Geometry, MesoOptions, PLANE, Values, material_list,
    open_appearance, open_asset, open_geometry, read_report, run, words,
};
pub use brdfc_source::ordinary_btf::OrdinaryBtf;
