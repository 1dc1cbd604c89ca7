//! Reads a flat BTF with what its file says of itself.

use super::asset::{AssetFile, FlatAsset};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_source::InputError;
use brdfc_source::flat_btf::{flat_btf_file, open_flat_btf};
use brdfc_source::json::json_problem;
use std::path::Path;

/// The flat BTF that a path means, its file or the only one of a folder, with its report.
///
/// # Errors
/// As [`open_flat_btf`]; a file without a report, or with a damaged one.
pub fn open_asset(path: &Path) -> Result<(FlatBtfFile, FlatAsset), InputError> {
    let file = open_flat_btf(path)?;
    let place = flat_btf_file(path)?.unwrap_or_else(|| path.to_owned());
    let about = read_report(&file).map_err(|error| InputError::format(&place, error))?;
    let bytes =
        std::fs::metadata(&place).map_err(|error| InputError::Io { name: place.display().to_string(), error })?.len();
    let asset = FlatAsset::new(about, &file, bytes);
    Ok((file, asset))
}

/// What a file says of itself.
///
/// # Errors
/// No report, or a damaged one.
pub fn read_report(file: &FlatBtfFile) -> Result<AssetFile, FormatError> {
    let allowed = "the report that 'brdfc flatten' writes into it";
    if file.report.is_empty() {
        return Err(FormatError::whole("report of a flat BTF", "none", allowed));
    }
    serde_json::from_str(&file.report)
        .map_err(|error| FormatError::whole("report of a flat BTF", json_problem(&error), allowed))
}
