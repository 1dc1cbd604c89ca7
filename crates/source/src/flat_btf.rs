//! Flat BTFs as inputs.

use crate::InputError;
use crate::read::{MAX_FILE_BYTES, open_path, read_file};
use brdfc_core::words::join_truncated;
use brdfc_formats::bindings::PackFile;
use brdfc_formats::flat_btf::{FlatBtfFile, FlatView};
use brdfc_formats::{FormatError, PackKind};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Maximum number of files of a folder that are read.
const MAX_ENTRIES: usize = 1 << 16;
/// Maximum number of files in an error.
const MAX_LISTED: usize = 6;

/// Finds the file of a flat BTF: the path itself, or the only one in a folder. `None` if there is none.
///
/// # Errors
/// Returns an error for a folder with several flat BTFs, and for one that cannot be read.
pub fn flat_btf_file(path: &Path) -> Result<Option<PathBuf>, InputError> {
    if !path.is_dir() {
        return Ok(is_flat_btf(path).then(|| path.to_owned()));
    }
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
    if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ktx2")) {
        return false;
    }
    let mut head = Vec::with_capacity(PackFile::HEAD_BYTES);
    let read = std::fs::File::open(file).and_then(|file| file.take(PackFile::HEAD_BYTES as u64).read_to_end(&mut head));
    read.is_ok() && PackFile::decoder_in(&head).and_then(PackKind::from_name).is_some_and(is_kind_of_flat_btf)
}

/// Returns true for both kinds of flat BTFs.
fn is_kind_of_flat_btf(kind: PackKind) -> bool {
    matches!(kind, PackKind::FlatBtf | PackKind::FlatBtfTrees)
}

/// Reads the flat BTF at a path.
///
/// # Errors
/// Same as [`flat_btf_file`]. Also returns an error if the path has no flat BTF, and for a file that cannot be read or
/// violates its layout.
pub fn open_flat_btf(path: &Path) -> Result<FlatBtfFile, InputError> {
    let Some(file) = flat_btf_file(path)? else {
        if !path.is_dir() {
            // Reports a missing file.
            open_path(path)?;
        }
        let found = if path.is_dir() { "no flat BTF in this folder" } else { "not a flat BTF" };
        let error = FormatError::whole("input", found, "the NAME.ktx2 of 'brdfc flatten', or its folder").problem();
        return Err(InputError::format(path, error));
    };
    let bytes = read_file(&file, MAX_FILE_BYTES)?;
    FlatBtfFile::from_bytes(&bytes).map_err(|error| InputError::format(&file, error))
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
