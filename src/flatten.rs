//! Flat BTFs of surfaces with relief, and of ordinary BTFs: `brdfc flatten`.
//!
//! [`Surface::open`] reads the input of [`run`]; [`open_asset`] reads its output.

pub use brdfc_flat_btf::encode::{FlattenRecipe, Reflectance, ReliefForm, VdimRecipe};
pub use brdfc_flat_btf::factored::FactoredTarget;
pub use brdfc_flat_btf::fill::FillMethod;
pub use brdfc_flat_btf::probes::ColourErrors;
pub use brdfc_flat_btf::structures::{STRUCTURES, describe_structures};
pub use brdfc_formats::direction_set::DirectionSet;
pub use brdfc_jobs::btf_stack::StackFormat;
pub use brdfc_jobs::file_name::is_device;
pub use brdfc_jobs::flatten::{
    AssetFile, FlatAsset, FlattenJob, ImageFacts, MesoOptions, PLANE, Surface, Values, open_asset, read_report, run,
    words,
};
pub use brdfc_source::ordinary_btf::OrdinaryBtf;
pub use brdfc_source::photograph::CodeValues;
