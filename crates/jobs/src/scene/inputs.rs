//! Inputs of a scene: a manifest, or a list of materials.

use super::batch::address_of;
use super::manifest::Manifest;
use super::patterns::Named;
use crate::error::Error;
use crate::write::or_here;
use brdfc_source::Kind;
use brdfc_source::read::{MAX_TEXT_BYTES, read_file};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Returns the manifest if the inputs are one. A single file with the extension of no asset counts as a
/// manifest.
///
/// # Errors
/// Returns an error if an input is `-`, or if a manifest is among other inputs.
pub fn manifest_among(inputs: &[OsString]) -> Result<Option<PathBuf>, Error> {
    let alone = inputs.len() == 1;
    if inputs.iter().any(|input| input == "-") {
        let text = "inputs: builds do not read stdin, only commands with one input do, such as \
                    'brdfc encode -'; for a file of this name, write ./-";
        return Err(Error::usage(text));
    }
    let is_manifest = |input: &OsString| {
        let path = Path::new(input);
        let kind = Kind::of_name(path);
        let is_file = address_of(input).is_none() && !path.is_dir() && !Named::new("", input).is_pattern();
        kind == Kind::Manifest || alone && is_file && matches!(kind, Kind::Other | Kind::Build)
    };
    match inputs.iter().find(|input| is_manifest(input)) {
        Some(_) if !alone => {
            let found = listed(inputs);
            Err(Error::wrong_usage("inputs", found, "one manifest, or files and folders"))
        }
        manifest => Ok(manifest.map(PathBuf::from)),
    }
}

/// The folders where a new file can become an input.
pub(crate) fn folders(named: &[Named]) -> Vec<PathBuf> {
    let folder = |input: &Named| {
        let base = if input.is_pattern() { input.base().0 } else { input.path() };
        Some(or_here(&base).to_owned()).filter(|base| base.is_dir())
    };
    named.iter().filter_map(folder).collect()
}

/// Joins the inputs for a message.
pub(crate) fn listed(inputs: &[OsString]) -> String {
    inputs.iter().map(|input| input.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Reads a manifest and expands its patterns. Also returns its text.
///
/// # Errors
/// Returns an error if the file cannot be read or breaks the rules of `docs/manifest.md`, or if no file matches a pattern.
pub fn read_manifest(path: &Path) -> Result<(String, Manifest), Error> {
    let bytes = read_file(path, MAX_TEXT_BYTES)?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let byte = bytes[error.valid_up_to()];
        Error::input(format!("{}: line {line}, text: found byte {byte:#04x}, expected UTF-8", path.display()))
    })?;
    let in_file = |error: &dyn std::fmt::Display| Error::input(format!("{}: {error}", path.display()));
    let manifest = Manifest::parse(text).map_err(|error| in_file(&error))?;
    let manifest = manifest.expanded(path.parent().unwrap_or(Path::new(""))).map_err(|error| in_file(&error))?;
    Ok((text.to_owned(), manifest))
}
