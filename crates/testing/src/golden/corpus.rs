//! Committed packs, which every version must decode to the same values.

use super::{Entries, Hashes, REFUSED, changes, folder, hash, lists, tell};
use crate::codecs::of_pack;
use brdfc_formats::FormatError;
use std::collections::BTreeMap;

const EXTENSION: &str = ".ktx2";

/// The committed packs of a codec by file name.
pub fn packs(codec: &str) -> BTreeMap<String, Vec<u8>> {
    let Ok(files) = std::fs::read_dir(folder(codec)) else { return BTreeMap::new() };
    let paths = files.map(|file| file.expect("the corpus can be listed").path());
    let read = |path: std::path::PathBuf| {
        let name = path.file_name()?.to_str()?.strip_suffix(EXTENSION)?.to_owned() + EXTENSION;
        let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Some((name, bytes))
    };
    paths.filter_map(read).collect()
}

/// Adds a pack to the corpus. An existing pack is not replaced, since it represents the version that wrote it.
pub fn add(codec: &str, name: &str, bytes: &[u8]) {
    let path = folder(codec).join(name.to_owned() + EXTENSION);
    if path.exists() {
        return;
    }
    std::fs::create_dir_all(folder(codec)).expect("the codec's folder can be made");
    std::fs::write(&path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    tell(&format!("{codec}/{name}{EXTENSION}: added, {} bytes", bytes.len()));
}

/// Hashes of one file, or the reader's error.
pub fn entry(bytes: &[u8]) -> Hashes {
    let mut hashes = of_pack(bytes).unwrap_or_else(refused);
    hashes.insert("file", hash(bytes));
    hashes
}

fn refused(error: FormatError) -> Hashes {
    Hashes::from([("values", format!("{REFUSED}{error}"))])
}

/// Hashes of packs by file name.
pub fn entries(packs: &BTreeMap<String, Vec<u8>>) -> Entries {
    packs.iter().map(|(file, bytes)| (file.clone(), entry(bytes))).collect()
}

/// Number of a codec's committed packs that decode to other values than listed.
pub fn moved(codec: &'static str) -> usize {
    let list = lists::corpus(codec);
    let found = list.expected(&list.read(), entries(&packs(codec)));
    let mut names: Vec<String> =
        changes(&list.read(), &found).into_iter().filter(|change| change.column != "file").map(|c| c.entry).collect();
    names.dedup();
    names.len()
}
