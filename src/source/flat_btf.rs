//! Flat BTFs in folders: the files of one asset.

use super::open::{InputError, MAX_TEXT_BYTES, open_path, read_all, read_file};
use brdfc_formats::FormatError;
use brdfc_formats::pack::flat_btf::{
    DiffuseMap, FlatBtfParts, FlatView, IndirectionMap, NormalMap, ReferenceMap, view_part,
};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What the name of every part's file ends with.
const EXTENSION: &str = ".ktx2";
/// Parts that every asset has, of those that are drawn.
const PARTS: [&str; 4] = ["reference", "indirection", "normal", "diffuse"];
/// Parts that are not drawn.
const OTHER_PARTS: [&str; 2] = ["position", "mask"];
/// Part of the first view; the others are found through it.
const VIEW: &str = "flat";
/// Most files that are looked at.
const MAX_ENTRIES: usize = 1 << 16;
/// Most missing files that an error lists.
const MOST_LISTED: usize = 6;

/// Reads a flat BTF: from the only asset of a folder, or from the files beside `NAME.json`.
///
/// With `views` the large files of the full form are read, too; without, [`FlatBtfParts::views`] is empty.
///
/// # Errors
/// Folders without a flat BTF or with several, files that are missing, cannot be read or do not follow their layout.
/// Whether the parts belong together is for `FlatBtfDecoder::new`.
pub fn open_flat_btf(path: &Path, views: bool) -> Result<FlatBtfParts, InputError> {
    let (folder, name) = asset(path)?;
    let file = |part: &str| folder.join(format!("{name}.{part}{EXTENSION}"));
    let first_view = [view_part(0, 1), view_part(0, 1000)].into_iter().find(|part| file(part).is_file());
    let mut missing: Vec<String> =
        PARTS.iter().filter(|part| !file(part).is_file()).map(|part| part.to_string()).collect();
    if views && first_view.is_none() {
        missing.push(view_part(0, 1));
    }
    check_missing(&folder, &name, &missing)?;
    let mut parts = FlatBtfParts {
        reference: read(&file("reference"), ReferenceMap::from_bytes)?,
        indirection: read(&file("indirection"), IndirectionMap::from_bytes)?,
        normal: read(&file("normal"), NormalMap::from_bytes)?,
        diffuse: read(&file("diffuse"), DiffuseMap::from_bytes)?,
        views: Vec::new(),
    };
    if let Some(first) = first_view.filter(|_| views) {
        let first = read(&file(&first), FlatView::from_bytes)?;
        let count = first.header().views.len() as u32;
        let others: Vec<String> = (1..count).map(|view| view_part(view, count)).collect();
        let missing: Vec<String> = others.iter().filter(|part| !file(part).is_file()).cloned().collect();
        check_missing(&folder, &name, &missing)?;
        let others: Vec<Result<FlatView, InputError>> =
            others.par_iter().map(|part| read(&file(part), FlatView::from_bytes)).collect();
        parts.views.push(first);
        for view in others {
            parts.views.push(view?);
        }
    }
    Ok(parts)
}

/// Path and bytes of the asset's list of parts, `NAME.json`, where there is one.
///
/// # Errors
/// What is no flat BTF; a list that cannot be read.
pub fn asset_list(path: &Path) -> Result<Option<(PathBuf, Vec<u8>)>, InputError> {
    let (folder, name) = asset(path)?;
    let file = folder.join(format!("{name}.json"));
    if !file.is_file() {
        return Ok(None);
    }
    let bytes = read_file(&file, MAX_TEXT_BYTES)?;
    Ok(Some((file, bytes)))
}

/// Folder and name of the asset that a path means.
fn asset(path: &Path) -> Result<(PathBuf, String), InputError> {
    if !path.is_dir() {
        // Says so if there is nothing.
        open_path(path)?;
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        return match (stem, path.extension().is_some_and(|extension| extension == "json")) {
            (Some(stem), true) => Ok((path.parent().unwrap_or(Path::new("")).to_owned(), stem.to_owned())),
            _ => {
                let found = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let allowed = "a folder, or NAME.json beside the files NAME.PART.ktx2";
                Err(format_error(path, FormatError::whole("flat BTF", found, allowed)))
            }
        };
    }
    let io = |error| InputError::Io { name: path.display().to_string(), error };
    let mut names = BTreeSet::new();
    for (number, entry) in std::fs::read_dir(path).map_err(io)?.enumerate() {
        if number == MAX_ENTRIES {
            let found = format!("more than {MAX_ENTRIES}");
            return Err(format_error(path, FormatError::whole("files", found, "the files of one flat BTF")));
        }
        let file = entry.map_err(io)?.file_name().to_string_lossy().into_owned();
        names.extend(
            name_and_part(&file).filter(|(_, part)| !OTHER_PARTS.contains(part)).map(|(name, _)| name.to_owned()),
        );
    }
    let found = match names.len() {
        1 => return Ok((path.to_owned(), names.into_iter().next().unwrap_or_default())),
        0 => "no files NAME.PART.ktx2".to_owned(),
        _ => names.into_iter().collect::<Vec<_>>().join(", "),
    };
    Err(format_error(path, FormatError::whole("flat BTFs", found, "one in a folder, or the path of its NAME.json")))
}

/// NAME of a file `NAME.PART.ktx2` of a flat BTF.
pub fn asset_of_part(file: &str) -> Option<String> {
    name_and_part(file).map(|(name, _)| name.to_owned())
}

/// NAME and PART of a file `NAME.PART.ktx2`; of views the part is [`VIEW`] without their number.
fn name_and_part(file: &str) -> Option<(&str, &str)> {
    let (name, part) = file.strip_suffix(EXTENSION)?.rsplit_once('.')?;
    if PARTS.contains(&part) || OTHER_PARTS.contains(&part) {
        return Some((name, part));
    }
    let is_number = part.len() >= 3 && part.bytes().all(|digit| digit.is_ascii_digit());
    name.strip_suffix(VIEW)?.strip_suffix('.').filter(|_| is_number).map(|name| (name, VIEW))
}

fn check_missing(folder: &Path, name: &str, missing: &[String]) -> Result<(), InputError> {
    if missing.is_empty() {
        return Ok(());
    }
    let listed: Vec<String> =
        missing.iter().take(MOST_LISTED).map(|part| format!("{name}.{part}{EXTENSION}")).collect();
    let more = match missing.len() - listed.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let found = format!("no {}{more}", listed.join(", "));
    Err(format_error(folder, FormatError::whole("flat BTF", found, "all of its files")))
}

fn read<T>(path: &Path, parse: fn(&[u8]) -> Result<T, FormatError>) -> Result<T, InputError> {
    let (file, length) = open_path(path)?;
    parse(&read_all(path, file, length)?).map_err(|error| format_error(path, error))
}

fn format_error(path: &Path, error: FormatError) -> InputError {
    InputError::Format { name: path.display().to_string(), error }
}
