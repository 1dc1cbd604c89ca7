//! What the page of a flat BTF is made of: its report, and pictures of what it holds.

use super::view_link::ViewLink;
use crate::error::Error;
use crate::flatten::{FlatAsset, open_asset};
use crate::scene::plan::REPORT;
use brdfc_render::flat::{FlatMaterial, FlatPictures, flat_pictures};
use brdfc_source::InputError;
use brdfc_source::flat_btf::flat_btf_file;
use std::path::Path;

/// Tiles per unit of uv on the scenes: few enough that a relief shows.
const REPEAT: u32 = 4;

/// A page, before it is written.
#[derive(Debug)]
pub struct FlatPage {
    /// What `brdfc flatten` says.
    pub asset: FlatAsset,
    /// What it holds.
    pub pictures: FlatPictures,
    /// A page that draws it.
    pub view: Option<ViewLink>,
}

/// Whether a path is a flat BTF and no build: its file, or a folder with one and without a report.
pub fn is_flat_btf(path: &Path) -> bool {
    !path.join(REPORT).is_file() && !matches!(flat_btf_file(path), Ok(None))
}

impl FlatPage {
    /// Reads a flat BTF and draws it.
    ///
    /// # Errors
    /// A file that cannot be read, or breaks the rules of its layout.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let (file, asset) = open_asset(path)?;
        let material = FlatMaterial::new(file.decoder, REPEAT).map_err(|error| InputError::format(path, error))?;
        let pictures = flat_pictures(&material, file.mask.as_ref());
        Ok(Self { asset, pictures, view: None })
    }
}
