//! Flat BTFs in folders: the files of one asset.

use super::read::open_path;
use crate::InputError;
use crate::json::json_problem;
use crate::read::{MAX_FILE_BYTES, MAX_TEXT_BYTES, read_file};
use brdfc_core::words::join_truncated;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::factored::{BasisMap, FactoredFlatBtf, ShadowMap, WeightMap};
use brdfc_formats::flat_btf::{
    DiffuseMap, DisplacementMap, FlatBtfParts, FlatPart, FlatValues, FlatView, IndirectionMap, NormalMap,
    PART_EXTENSION, ReferenceMap, SampledDirections, VisibilityMask, split_part_name, view_part,
};
use rayon::prelude::*;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What the name of the list of parts ends with.
const LIST: &str = ".json";
/// Parts that every asset has, of those that are drawn.
const PARTS: [&str; 3] = ["reference", "normal", "diffuse"];
/// The part that says which texels a view sees.
const MASK: &str = "mask";
/// Most files that are looked at.
const MAX_ENTRIES: usize = 1 << 16;
/// Most missing files that an error lists.
const MOST_LISTED: usize = 6;

/// The list of an asset's parts, `NAME.json`: what of it says which files belong together.
#[derive(Debug, Deserialize)]
struct Listing {
    parts: BTreeMap<String, Listed>,
}

/// A file of an asset.
#[derive(Debug, Deserialize)]
struct Listed {
    file: String,
    bytes: u64,
    blake3: String,
}

/// Reads a flat BTF: from the only asset of a folder, or from the files beside `NAME.json`.
///
/// With `values` the files of the full form are read, too: the factored ones, or all views. Files are held against the list
/// of parts, so that no part of another asset passes for one of this.
///
/// # Errors
/// Folders without a flat BTF or with several, a missing or damaged list, files that are missing, cannot be read, are not
/// those of the list or do not follow their layout. Whether sizes fit together is for `FlatBtfDecoder::new`.
pub fn open_flat_btf(path: &Path, values: bool) -> Result<FlatBtfParts, InputError> {
    let asset = Asset::open(path)?;
    if values {
        asset.check_views()?;
    }
    let mut names: Vec<String> = PARTS.map(str::to_owned).to_vec();
    names.insert(1, asset.indirection_part().name().to_owned());
    if values {
        names.push(FlatPart::Directions.name().to_owned());
        names.extend(asset.value_parts());
    }
    asset.check_listed(&names)?;
    let parts = FlatBtfParts {
        reference: asset.part("reference", ReferenceMap::from_bytes)?,
        indirection: match asset.indirection_part() {
            FlatPart::Displacement => asset.part("displacement", DisplacementMap::from_bytes)?.into(),
            _ => asset.part("indirection", IndirectionMap::from_bytes)?.into(),
        },
        normal: asset.part("normal", NormalMap::from_bytes)?,
        diffuse: asset.part("diffuse", DiffuseMap::from_bytes)?,
        values: if values { asset.values()? } else { FlatValues::None },
    };
    if values {
        asset.check_directions(&parts.values)?;
    }
    Ok(parts)
}

/// Reads one view of a flat BTF and says how many there are; no view where the number is beyond them. A factored one is
/// decoded.
///
/// # Errors
/// As [`open_flat_btf`], of the files that it takes.
pub fn open_flat_view(path: &Path, view: u32) -> Result<(Option<FlatView>, u32), InputError> {
    let asset = Asset::open(path)?;
    if asset.is_factored() {
        asset.check_listed(&asset.value_parts())?;
        let factored = asset.factored()?;
        let count = factored.header().views.len() as u32;
        let decoded = (view < count).then(|| factored.view(view));
        return Ok((decoded, count));
    }
    asset.check_views()?;
    let count = asset.views();
    if view >= count {
        return Ok((None, count));
    }
    let part = view_part(view, count);
    asset.check_listed(std::slice::from_ref(&part))?;
    Ok((Some(asset.part(&part, FlatView::from_bytes)?), count))
}

/// Reads which texels of a flat BTF are seen in which view; nothing of an asset without that part.
///
/// # Errors
/// As [`open_flat_btf`], of this file alone.
pub fn open_flat_mask(path: &Path) -> Result<Option<VisibilityMask>, InputError> {
    let asset = Asset::open(path)?;
    if !asset.listing.parts.contains_key(MASK) {
        return Ok(None);
    }
    asset.check_listed(&[MASK.to_owned()])?;
    asset.part(MASK, VisibilityMask::from_bytes).map(Some)
}

/// Holds every file of an asset against its list of parts.
///
/// # Errors
/// As [`open_flat_btf`], but layouts are not looked at.
pub fn check_flat_btf(path: &Path) -> Result<(), InputError> {
    let asset = Asset::open(path)?;
    let names: Vec<String> = asset.listing.parts.keys().cloned().collect();
    asset.check_listed(&names)?;
    let checked: Vec<Result<(), InputError>> = names.par_iter().map(|part| asset.part(part, |_| Ok(()))).collect();
    checked.into_iter().collect()
}

struct Asset {
    folder: PathBuf,
    name: String,
    listing: Listing,
}

impl Asset {
    fn open(path: &Path) -> Result<Self, InputError> {
        let (folder, name) = asset(path)?;
        let file = folder.join(format!("{name}{LIST}"));
        if !file.is_file() {
            let found = format!("no {name}{LIST}");
            return Err(format_error(&folder, FormatError::whole("flat BTF", found, "a finished asset")));
        }
        let wrong = |error: serde_json::Error| {
            format_error(&file, FormatError::whole("list of parts", json_problem(&error), "what 'brdfc flatten' wrote"))
        };
        let listing = serde_json::from_slice(&read_file(&file, MAX_TEXT_BYTES)?).map_err(wrong)?;
        Ok(Self { folder, name, listing })
    }

    /// Which of the two parts says how what is seen moves with the view.
    fn indirection_part(&self) -> FlatPart {
        let compact = FlatPart::Displacement;
        if self.listing.parts.contains_key(compact.name()) { compact } else { FlatPart::Indirection }
    }

    /// What the full form takes: factors, where the list has them, or all views.
    fn value_parts(&self) -> Vec<String> {
        if self.is_factored() {
            let shadow = FlatPart::Shadow.name();
            let shadow = self.listing.parts.contains_key(shadow).then_some(shadow);
            let parts = [FlatPart::Basis.name(), FlatPart::Weights.name()].into_iter().chain(shadow);
            return parts.map(str::to_owned).collect();
        }
        let count = self.views();
        (0..count).map(|view| view_part(view, count)).collect()
    }

    /// That there is something to be seen in views.
    fn check_views(&self) -> Result<(), InputError> {
        if self.is_factored() || self.views() > 0 {
            return Ok(());
        }
        let found = "the light form, which has no views";
        Err(format_error(&self.folder, FormatError::whole("flat BTF", found, "one of the full form")))
    }

    fn is_factored(&self) -> bool {
        self.listing.parts.contains_key(FlatPart::Basis.name())
    }

    /// The values, whose files are there.
    fn values(&self) -> Result<FlatValues, InputError> {
        if self.is_factored() {
            return Ok(FlatValues::Factored(Box::new(self.factored()?)));
        }
        let views: Vec<Result<FlatView, InputError>> =
            self.value_parts().par_iter().map(|part| self.part(part, FlatView::from_bytes)).collect();
        Ok(FlatValues::Views(views.into_iter().collect::<Result<_, _>>()?))
    }

    /// The factors, whose files are there.
    fn factored(&self) -> Result<FactoredFlatBtf, InputError> {
        let [basis, weights, shadow] = [FlatPart::Basis, FlatPart::Weights, FlatPart::Shadow].map(FlatPart::name);
        let has_shadow = self.listing.parts.contains_key(shadow);
        let shadow = has_shadow.then(|| self.part(shadow, ShadowMap::from_bytes)).transpose()?;
        let weights = self.part(weights, WeightMap::from_bytes)?;
        let asset = FactoredFlatBtf::new(self.part(basis, BasisMap::from_bytes)?, weights, shadow);
        asset.map_err(|error| format_error(&self.folder.join(self.file(basis)), error))
    }

    /// That the part `directions` is for as many views and lights as the values have.
    fn check_directions(&self, values: &FlatValues) -> Result<(), InputError> {
        let part = FlatPart::Directions.name();
        let found: SampledDirections = self.part(part, SampledDirections::from_bytes)?;
        let numbers = [found.views.directions(), found.lights.directions()];
        match values.directions().map(|directions| directions.map(<[_]>::len)) {
            Some(allowed) if allowed != numbers => {
                let words = |[views, lights]: [usize; 2]| format!("{views} views and {lights} lights");
                let error = FormatError::whole("directions", words(numbers), words(allowed));
                Err(format_error(&self.folder.join(self.file(part)), error))
            }
            _ => Ok(()),
        }
    }

    /// Views in the list.
    fn views(&self) -> u32 {
        let is_view = |part: &&String| FlatPart::from_name(part) == Some(FlatPart::View);
        self.listing.parts.keys().filter(is_view).count() as u32
    }

    fn file(&self, part: &str) -> String {
        format!("{}.{part}{PART_EXTENSION}", self.name)
    }

    /// That parts are in the list, under their names, and that their files are there.
    fn check_listed(&self, parts: &[String]) -> Result<(), InputError> {
        let is_there = |part: &&String| {
            self.listing.parts.get(*part).is_some_and(|listed| listed.file == self.file(part))
                && self.folder.join(self.file(part)).is_file()
        };
        let missing: Vec<String> = parts.iter().filter(|part| !is_there(part)).map(|part| self.file(part)).collect();
        if missing.is_empty() {
            return Ok(());
        }
        let found = format!("no {}", join_truncated(&missing, MOST_LISTED));
        Err(format_error(&self.folder, FormatError::whole("flat BTF", found, "all of its files")))
    }

    /// Reads a part that is in the list.
    fn part<T>(&self, part: &str, parse: impl Fn(&[u8]) -> Result<T, FormatError>) -> Result<T, InputError> {
        let path = self.folder.join(self.file(part));
        let listed = &self.listing.parts[part];
        let bytes = read_file(&path, MAX_FILE_BYTES)?;
        let other = |found: String, allowed: String| {
            Err(format_error(&path, FormatError::whole("part of a flat BTF", found, allowed)))
        };
        if bytes.len() as u64 != listed.bytes {
            let allowed = format!("{}, as {}{LIST} says", listed.bytes, self.name);
            return other(format!("{} bytes", bytes.len()), allowed);
        }
        if blake3::hash(&bytes).to_hex().as_str() != listed.blake3 {
            let allowed = format!("those that {}{LIST} lists", self.name);
            return other("other bytes than were written, or a part of another asset".to_owned(), allowed);
        }
        parse(&bytes).map_err(|error| format_error(&path, error))
    }
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
        names.extend(split_part_name(&file).filter(|(_, part, _)| part.is_drawn()).map(|(name, ..)| name.to_owned()));
    }
    let found = match names.len() {
        1 => return Ok((path.to_owned(), names.into_iter().next().unwrap_or_default())),
        0 => "no files NAME.PART.ktx2".to_owned(),
        _ => names.into_iter().collect::<Vec<_>>().join(", "),
    };
    Err(format_error(path, FormatError::whole("flat BTFs", found, "one in a folder, or the path of its NAME.json")))
}

/// The files of the asset that a path means: the list of its parts and those that it names; none of another path.
pub(crate) fn files_of_asset(path: &Path) -> Vec<PathBuf> {
    let Ok(Asset { folder, name, listing }) = Asset::open(path) else { return Vec::new() };
    let parts = listing.parts.values().map(|listed| listed.file.clone());
    parts.chain([format!("{name}{LIST}")]).map(|file| folder.join(file)).collect()
}

/// NAME of a file `NAME.PART.ktx2` of a flat BTF.
pub fn asset_of_part(file: &str) -> Option<&str> {
    split_part_name(file).map(|(name, ..)| name)
}

fn format_error(path: &Path, error: FormatError) -> InputError {
    InputError::Format { name: path.display().to_string(), error }
}
