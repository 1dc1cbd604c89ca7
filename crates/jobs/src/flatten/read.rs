//! Reads a flat BTF with its report.

use super::asset::{AssetFile, FlatAsset};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_source::flat_btf::flat_btf_file;
use brdfc_source::json::json_problem;
use brdfc_source::read::MAX_FILE_BYTES;
use brdfc_source::{Input, InputError};

/// Reads a flat BTF from its file, or from a folder with one such file, with its report.
///
/// # Errors
/// Returns the errors of [`flat_btf_file`] and of reading the file, and an error if the report is missing or damaged.
pub fn open_asset(input: impl Into<Input>) -> Result<(FlatBtfFile, FlatAsset), InputError> {
    let place = flat_btf_file(&input.into())?;
    let wrong = |error| InputError::Format { name: place.to_string(), error };
    let bytes = place.read(MAX_FILE_BYTES)?;
    let file = FlatBtfFile::from_bytes(&bytes).map_err(wrong)?;
    let about = read_report(&file).map_err(wrong)?;
    let asset = FlatAsset::new(about, &file, bytes.len() as u64);
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
