//! Flat BTFs as inputs.

use crate::pack::{kind_in, kind_of_file};
use crate::read::{MAX_FILE_BYTES, open_path};
use crate::{Input, InputError};
use brdfc_core::words::join_truncated;
use brdfc_formats::flat_btf::{FlatBtfFile, FlatView};
use brdfc_formats::{FormatError, PackKind};
use std::path::{Path, PathBuf};

/// Maximum number of files of a folder that are read.
const MAX_ENTRIES: usize = 1 << 16;
/// Maximum number of files in an error.
const MAX_LISTED: usize = 6;

/// The only flat BTF in a folder; `None` if there is none.
///
/// # Errors
/// Returns an error for several flat BTFs, and for a folder that cannot be read.
pub(crate) fn flat_btf_in(path: &Path) -> Result<Option<PathBuf>, InputError> {
    let io = |error| InputError::Io { name: path.display().to_string(), error };
    let mut found = Vec::new();
    for (number, entry) in std::fs::read_dir(path).map_err(io)?.enumerate() {
        if number == MAX_ENTRIES {
            let error = FormatError::whole("files", format!("more than {MAX_ENTRIES}"), "the folder of one flat BTF");
            return Err(InputError::format(path, error));
        }
        let file = entry.map_err(io)?.path();
        if is_flat_btf(&file) {
            found.push(file);
        }
    }
    if found.len() < 2 {
        return Ok(found.pop());
    }
    found.sort();
    let names: Vec<String> =
        found.iter().map(|file| file.file_name().unwrap_or_default().to_string_lossy().into_owned()).collect();
    let names = join_truncated(&names, MAX_LISTED);
    let allowed = "a folder with one flat BTF, or the path of a file";
    Err(InputError::format(path, FormatError::whole("flat BTFs", names, allowed)))
}

/// Returns true if a file starts like a flat BTF.
fn is_flat_btf(file: &Path) -> bool {
    kind_of_file(file).is_some_and(is_kind_of_flat_btf)
}

/// Returns true for both kinds of flat BTFs.
pub(crate) fn is_kind_of_flat_btf(kind: PackKind) -> bool {
    matches!(kind, PackKind::FlatBtf | PackKind::FlatBtfTrees)
}

/// The file of a flat BTF: the input itself, or the only flat BTF in a folder.
///
/// # Errors
/// Returns an error for a folder with several flat BTFs or without one, and for other inputs.
pub fn flat_btf_file(input: &Input) -> Result<Input, InputError> {
    let found = match input {
        Input::File(folder) if folder.is_dir() => match flat_btf_in(folder)? {
            Some(file) => return Ok(file.into()),
            None => "no flat BTF in this folder",
        },
        Input::File(file) if !is_flat_btf(file) => {
            // Reports a missing file.
            open_path(file)?;
            "not a flat BTF"
        }
        Input::Stdin(stdin) if !kind_in(stdin.bytes()?).is_some_and(is_kind_of_flat_btf) => "not a flat BTF",
        Input::Address(_) => "not a flat BTF",
        _ => return Ok(input.clone()),
    };
    let error = FormatError::whole("input", found, "the NAME.ktx2 of 'brdfc flatten', or its folder").problem();
    Err(InputError::format(input.named_path(), error))
}

/// Reads a flat BTF.
///
/// # Errors
/// Same as [`flat_btf_file`]. Also returns an error for a file that cannot be read or violates its layout.
pub fn open_flat_btf(input: impl Into<Input>) -> Result<FlatBtfFile, InputError> {
    let file = flat_btf_file(&input.into())?;
    let bytes = file.read(MAX_FILE_BYTES)?;
    FlatBtfFile::from_bytes(&bytes).map_err(|error| InputError::format(file.named_path(), error))
}

/// Decodes a view of a flat BTF, and returns the number of views; `None` if `view` is beyond them.
///
/// # Errors
/// Returns an error without components, which flat BTFs of known materials do not need.
pub fn flat_view(file: &FlatBtfFile, view: u32) -> Result<(Option<FlatView>, u32), FormatError> {
    let reflectance = &file.decoder.parts().reflectance;
    let Some(factors) = reflectance.factors().filter(|factors| factors.header().groups > 0) else {
        let found = if reflectance.trees().is_some() { "trees" } else { "no sampled views" };
        let allowed = "a flat BTF made with --reflectance factors";
        return Err(FormatError::whole("flat BTF", found, allowed).problem());
    };
    let count = factors.header().views.len() as u32;
    Ok(((view < count).then(|| factors.view(view)), count))
}
