//! What the page of a flat BTF is made of: its list of parts, and pictures of what they hold.

use super::error::GatherError;
use super::view_link::ViewLink;
use crate::flatten::{AssetFile, open_asset};
use crate::scene::plan::REPORT;
use brdfc_flat_btf::encode::Form;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::{FlatBtfDecoder, VisibilityMask};
use brdfc_render::flat::{FlatMaterial, FlatPictures, flat_pictures};
use brdfc_source::InputError;
use brdfc_source::flat_btf::{asset_of_part, check_flat_btf, open_flat_btf};
use brdfc_source::read::{MAX_FILE_BYTES, read_file};
use std::path::Path;

/// Tiles per unit of uv on the scenes: few enough that a relief shows.
const REPEAT: u32 = 4;
/// The part that says which texels are seen.
const MASK: &str = "mask";

/// A page, before it is written.
#[derive(Debug)]
pub struct FlatPage {
    /// What `brdfc flatten` says.
    pub asset: AssetFile,
    /// What the parts hold.
    pub pictures: FlatPictures,
    /// A page that draws it.
    pub view: Option<ViewLink>,
}

/// Whether a path is a flat BTF and no build: its list of parts, or a folder with parts and without a report.
pub fn is_flat_btf(path: &Path) -> bool {
    if !path.is_dir() {
        return path.is_file() && path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    }
    let is_part = |entry: std::fs::DirEntry| entry.file_name().to_str().and_then(asset_of_part).is_some();
    !path.join(REPORT).is_file() && std::fs::read_dir(path).is_ok_and(|files| files.flatten().any(is_part))
}

impl FlatPage {
    /// Reads all parts and draws them.
    ///
    /// # Errors
    /// Files that are missing, cannot be read, are not those of the list or do not fit together.
    pub fn open(path: &Path) -> Result<Self, GatherError> {
        let wrong = |error: FormatError| InputError::Format { name: path.display().to_string(), error };
        let Some(asset) = open_asset(path)? else {
            return Err(wrong(FormatError::whole("flat BTF", "no list of parts", "a finished asset")).into());
        };
        check_flat_btf(path)?;
        let parts = open_flat_btf(path, asset.settings.form == Form::Full)?;
        let material = FlatBtfDecoder::new(parts).and_then(|decoder| FlatMaterial::new(decoder, REPEAT));
        let material = material.map_err(wrong)?;
        let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
        let read = |file: &str| -> Result<VisibilityMask, InputError> {
            let path = folder.join(file);
            let of_file = |error| InputError::Format { name: path.display().to_string(), error };
            VisibilityMask::from_bytes(&read_file(&path, MAX_FILE_BYTES)?).map_err(of_file)
        };
        let mask = asset.parts.get(MASK).map(|part| read(&part.file)).transpose()?;
        let pictures = flat_pictures(&material, mask.as_ref());
        Ok(Self { asset, pictures, view: None })
    }
}
