//! Reads a flat BTF with its report.

use super::asset::{AssetFile, FlatAsset};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_source::InputError;
use brdfc_source::flat_btf::{flat_btf_file, open_flat_btf};
use brdfc_source::json::json_problem;
use std::path::Path;

/// Reads a flat BTF from its file, or from a folder with one such file, with its report.
///
/// # Errors
/// Returns the errors of [`open_flat_btf`], and an error if the report is missing or damaged.
pub fn open_asset(path: &Path) -> Result<(FlatBtfFile, FlatAsset), InputError> {
    let file = open_flat_btf(path)?;
    let place = flat_btf_file(path)?.unwrap_or_else(|| path.to_owned());
    let about = read_report(&file).map_err(|error| InputError::format(&place, error))?;
    let bytes =
        std::fs::metadata(&place).map_err(|error| InputError::Io { name: place.display().to_string(), error })?.len();
    let asset = FlatAsset::new(about, &file, bytes);
    Ok((file, asset))
}

/// The report in a file.
///
/// # Errors
/// Returns an error if the report is missing or damaged.
pub fn read_report(file: &FlatBtfFile) -> Result<AssetFile, FormatError> {
    let allowed = "the report that 'brdfc flatten' writes into it";
    if file.report.is_empty() {
        return Err(FormatError::whole("report of a flat BTF", "missing", allowed).problem());
    }
    serde_json::from_str(&file.report)
        .map_err(|error| FormatError::whole("report of a flat BTF", json_problem(&error), allowed))
}
