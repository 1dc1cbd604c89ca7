//! Descriptions of inputs: `brdfc info`.
//!
//! Start with [`Material::facts`](crate::Material::facts) for materials and packs, [`describe_surface`] for geometry
//! and ordinary BTFs, and [`files`] for the textures of a pack.

pub use brdfc_core::Symmetry;
pub use brdfc_core::address::{SYNTH_PREFIX, split_query};
pub use brdfc_flat_btf::structures::STRUCTURES;
pub use brdfc_formats::{Pack as AnyPack, PackKind};
pub use brdfc_importance::ImportanceFacts;
pub use brdfc_jobs::flatten::{MeshFacts, SurfaceFacts, describe_surface, open_asset, surface};
pub use brdfc_jobs::pack_files::PackFile;
pub use brdfc_pwt::PwtFacts;
pub use brdfc_shaders::DeviceNeeds;
pub use brdfc_source::Kind;
pub use brdfc_source::flat_btf::{flat_btf_file, open_flat_btf};
pub use brdfc_source::open::{Opened, known_files, open, opened};
pub use brdfc_source::pack::open_pack;
pub use brdfc_source::ptm::{PtmFacts, open_ptm};
pub use brdfc_source::rti::{RtiFacts, open_rti};
pub use brdfc_source::rti_capture::{RtiCapture, RtiCaptureFacts};

use crate::{Error, Input, InputError};
use brdfc_jobs::pack_files::pack_files;
use brdfc_source::read::MAX_FILE_BYTES;
use std::collections::BTreeMap;

/// Lists the textures of a pack by file name; textures in key/value data are named `NAME#KEY`.
///
/// # Errors
/// Returns an error if the file cannot be read, is not a pack or is damaged.
pub fn files(input: &Input) -> Result<BTreeMap<String, PackFile>, Error> {
    let wrong = |error| InputError::Format { name: input.to_string(), error };
    let kind = Kind::of(input)?;
    if !kind.is_ktx2() {
        return Err(kind.refused(input, "a pack").into());
    }
    let input = if kind.is_flat_btf() { &flat_btf_file(input)? } else { input };
    let bytes = input.read(MAX_FILE_BYTES)?;
    AnyPack::from_bytes(&bytes).map_err(wrong)?;
    Ok(pack_files(&input.short_name(), &bytes).map_err(wrong)?)
}

/// Lists the features that a device needs for all textures of a pack.
///
/// # Errors
/// Returns the errors of [`files`].
pub fn device_needs(input: &Input) -> Result<DeviceNeeds, Error> {
    Ok(files(input)?.into_values().fold(DeviceNeeds::default(), |all, file| all.with(file.device)))
}
