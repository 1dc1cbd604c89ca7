//! What an input is: `brdfc info`.

pub use brdfc_core::Symmetry;
pub use brdfc_core::address::{SYNTH_PREFIX, split_query};
pub use brdfc_flat_btf::structures::STRUCTURES;
pub use brdfc_formats::{Pack as AnyPack, PackKind};
pub use brdfc_importance::ImportanceFacts;
pub use brdfc_jobs::flatten::{MeshFacts, SurfaceFacts, describe_surface, open_asset, surface};
pub use brdfc_jobs::pack_files::PackFile;
pub use brdfc_pwt::PwtFacts;
pub use brdfc_shaders::DeviceNeeds;
pub use brdfc_source::flat_btf::{flat_btf_file, open_flat_btf};
pub use brdfc_source::light_stack::{self, LightStack, LightStackFacts, is_light_stack};
pub use brdfc_source::open::{Opened, known_files, open, opened};
pub use brdfc_source::pack::open_pack;
pub use brdfc_source::ptm::{self, PtmFacts, open_ptm};

use crate::{Error, FormatError, Input, InputError};
use brdfc_jobs::pack_files::pack_files;
use brdfc_source::read::MAX_FILE_BYTES;
use std::collections::BTreeMap;
use std::fs::File;

/// The textures of a pack by the name of the file, those in its key/value data as `NAME#KEY`.
///
/// # Errors
/// A file that cannot be read, is no pack or is damaged.
pub fn files(input: &Input) -> Result<BTreeMap<String, PackFile>, Error> {
    let wrong = |error| InputError::Format { name: input.to_string(), error };
    if input.extension()? != "ktx2" {
        // What cannot be read says so first.
        if let Some(path) = input.path() {
            File::open(path).map_err(|error| Error::from(InputError::Io { name: input.to_string(), error }))?;
        }
        return Err(wrong(FormatError::whole("input", "no pack", "a pack")).into());
    }
    let bytes = input.read(MAX_FILE_BYTES)?;
    AnyPack::from_bytes(&bytes).map_err(wrong)?;
    Ok(pack_files(&input.short_name(), &bytes).map_err(wrong)?)
}

/// The features that a device needs for all textures of a pack.
///
/// # Errors
/// As [`files`].
pub fn device_needs(input: &Input) -> Result<DeviceNeeds, Error> {
    Ok(files(input)?.into_values().fold(DeviceNeeds::default(), |all, file| all.with(file.device)))
}
