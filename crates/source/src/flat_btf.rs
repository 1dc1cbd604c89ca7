//! Flat BTFs: whether a path means one, and reading it.

use crate::InputError;
use crate::read::{MAX_FILE_BYTES, open_path, read_file};
use brdfc_core::words::join_truncated;
use brdfc_formats::bindings::PackFile;
use brdfc_formats::flat_btf::{FlatBtfFile, FlatView};
use brdfc_formats::{FormatError, PackKind};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Most files that are looked at in a folder.
const MAX_ENTRIES: usize = 1 << 16;
/// Most files that an error lists.
const MAX_LISTED: usize = 6;

/// The file of the flat BTF that a path means: the path itself, or the only one in a folder. Nothing where there is none.
///
/// # Errors
/// A folder with several, or that cannot be read.
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
    Err(InputError::format(path, FormatError::whole("flat BTFs", names, "one in a folder, or the path of its file")))
}

/// Whether a file begins as a flat BTF does.
fn is_flat_btf(file: &Path) -> bool {
    if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ktx2")) {
        return false;
    }
    let mut head = Vec::with_capacity(PackFile::HEAD_BYTES);
    let read = std::fs::File::open(file).and_then(|file| file.take(PackFile::HEAD_BYTES as u64).read_to_end(&mut head));
    read.is_ok() && PackFile::decoder_in(&head) == Some(PackKind::FlatBtf.name())
}

/// Reads the flat BTF that a path means.
///
/// # Errors
/// As [`flat_btf_file`]; a path that means none; a file that cannot be read or breaks the rules of its layout.
pub fn open_flat_btf(path: &Path) -> Result<FlatBtfFile, InputError> {
    let Some(file) = flat_btf_file(path)? else {
        if !path.is_dir() {
            // Says so if there is nothing.
            open_path(path)?;
        }
        let found = if path.is_dir() { "no file of one" } else { "another file" };
        let error = FormatError::whole("flat BTF", found, "the NAME.ktx2 that 'brdfc flatten' writes, or its folder");
        return Err(InputError::format(path, error));
    };
    let bytes = read_file(&file, MAX_FILE_BYTES)?;
    FlatBtfFile::from_bytes(&bytes).map_err(|error| InputError::format(&file, error))
}

/// A view of a flat BTF, decoded, and how many there are; no view where the number is beyond them.
///
/// # Errors
/// The light form, which has none.
pub fn flat_view(file: &FlatBtfFile, view: u32) -> Result<(Option<FlatView>, u32), FormatError> {
    let Some(factored) = file.decoder.parts().values.factored() else {
        return Err(FormatError::whole("flat BTF", "the light form, which has no views", "one of the full form"));
    };
    let count = factored.header().views.len() as u32;
    Ok(((view < count).then(|| factored.view(view)), count))
}
