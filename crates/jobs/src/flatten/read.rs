//! Reads an asset's list of parts again.

use super::asset::AssetFile;
use brdfc_formats::FormatError;
use brdfc_source::InputError;
use brdfc_source::flat_btf::asset_list;
use brdfc_source::json::json_problem;
use std::path::Path;

/// The list `NAME.json` of the asset that a path means, its folder or the list itself; nothing where there is no list.
///
/// # Errors
/// What is no flat BTF; a list that cannot be read or is damaged.
pub fn open_asset(path: &Path) -> Result<Option<AssetFile>, InputError> {
    let Some((file, bytes)) = asset_list(path)? else { return Ok(None) };
    serde_json::from_slice(&bytes).map(Some).map_err(|error| InputError::Format {
        name: file.display().to_string(),
        error: FormatError::whole("list of parts", json_problem(&error), "the whole list that 'brdfc flatten' wrote"),
    })
}
