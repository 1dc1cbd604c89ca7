//! The files of an asset: written aside, and put in place when all are there.

use super::asset::PartFile;
use super::error::FlattenError;
use super::scratch::FolderScratch;
use crate::store::{Staging, abandoned, read_record, write_record};
use crate::write::{is_plain, write_atomic};
use brdfc_formats::container::Extent;
use brdfc_formats::flat_btf::{PART_EXTENSION, gpu_bytes, split_part_name};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files that are being made. Until [`Self::commit`] an asset that stands in the folder stays as it is, and what was
/// written goes away with this.
pub(super) struct Parts<'a> {
    name: &'a str,
    folder: &'a Path,
    aside: Staging,
    files: BTreeMap<String, PartFile>,
}

impl<'a> Parts<'a> {
    /// An asset of this name in this folder, which is there. What a killed process had begun to put in place is finished.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(super) fn new(name: &'a str, folder: &'a Path) -> Result<Self, FlattenError> {
        Moves::finish_abandoned(folder)?;
        let aside = Staging::new(folder).map_err(|error| FlattenError::write(folder, error))?;
        Ok(Self { name, folder, aside, files: BTreeMap::new() })
    }

    /// Storage for what is needed on the way and is no part of the asset.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn scratch(&self) -> Result<FolderScratch, FlattenError> {
        let folder = self.aside.path().join(SCRATCH);
        std::fs::create_dir(&folder).map_err(|error| FlattenError::write(self.folder, error))?;
        Ok(FolderScratch::new(folder, self.folder))
    }

    /// Writes a part of this extent and so many mipmap levels aside.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn add(&mut self, part: &str, bytes: &[u8], extent: Extent, levels: u32) -> Result<(), FlattenError> {
        self.add_sized(part, bytes, gpu_bytes(part, extent, levels))
    }

    /// The same of a part that takes so many bytes on a GPU.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub(super) fn add_sized(&mut self, part: &str, bytes: &[u8], gpu_bytes: u64) -> Result<(), FlattenError> {
        let file = format!("{}.{part}{PART_EXTENSION}", self.name);
        std::fs::write(self.aside.path().join(&file), bytes)
            .map_err(|error| FlattenError::write(&self.folder.join(&file), error))?;
        let blake3 = blake3::hash(bytes).to_hex().to_string();
        let listed = PartFile { file, bytes: bytes.len() as u64, gpu_bytes, blake3 };
        self.files.insert(part.to_owned(), listed);
        Ok(())
    }

    /// What was written so far, by part.
    pub(super) fn files(&self) -> &BTreeMap<String, PartFile> {
        &self.files
    }

    /// Puts everything in place, and the list of parts last. While files change places there is no list, so that no
    /// mixture passes for an asset; who is killed then leaves the rest for the next who makes something in the folder.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn commit(self, list: &str) -> Result<(), FlattenError> {
        let aside = self.aside.path();
        let files = self.files.into_values().map(|part| part.file).collect();
        let moves = Moves { name: self.name.to_owned(), files };
        std::fs::write(aside.join(moves.list()), list)
            .and_then(|()| write_atomic(&aside.join(MOVES), &write_record(&moves)))
            .map_err(|error| FlattenError::write(&self.folder.join(moves.list()), error))?;
        moves.finish(aside, self.folder)
    }
}

/// In the folder aside: what is needed on the way.
const SCRATCH: &str = "scratch";
/// In the folder aside, when all is there: what is to be moved out of it.
const MOVES: &str = "moves";

/// The files of a finished asset that change places.
#[derive(Debug, Serialize, Deserialize)]
struct Moves {
    /// The asset's.
    name: String,
    /// All but the list.
    files: Vec<String>,
}

impl Moves {
    fn list(&self) -> String {
        format!("{}.json", self.name)
    }

    /// Finishes what killed processes had begun in a folder.
    fn finish_abandoned(folder: &Path) -> Result<(), FlattenError> {
        for aside in abandoned(folder) {
            let moves = read_record::<Self>(&aside.join(MOVES));
            if let Some(moves) = moves.filter(|moves| moves.files.iter().chain([&moves.list()]).all(|n| is_plain(n))) {
                moves.finish(&aside, folder)?;
            }
        }
        Ok(())
    }

    /// Moves what was not moved before.
    fn finish(&self, aside: &Path, folder: &Path) -> Result<(), FlattenError> {
        let (list, listing) = (aside.join(self.list()), folder.join(self.list()));
        if !list.exists() {
            return Ok(());
        }
        match std::fs::remove_file(&listing) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(FlattenError::write(&listing, error));
            }
            _ => {}
        }
        for file in &self.files {
            let (from, to) = (aside.join(file), folder.join(file));
            match std::fs::rename(&from, &to) {
                Err(error) if error.kind() == std::io::ErrorKind::NotFound && !from.exists() => {}
                moved => moved.map_err(|error| FlattenError::write(&to, error))?,
            }
        }
        self.remove_stale(folder);
        std::fs::rename(&list, &listing).map_err(|error| FlattenError::write(&listing, error))
    }

    /// Parts of an earlier asset of the same name that this one has not: views, factors, one of the two kinds of indirection.
    fn remove_stale(&self, folder: &Path) {
        let Ok(entries) = std::fs::read_dir(folder) else { return };

        let is_own = |name: &str| {
            split_part_name(name).is_some_and(|(asset, part, _)| asset == self.name && !part.is_in_every_asset())
        };
        let listed = |name: &str| self.files.iter().any(|file| file == name);
        let stale: Vec<PathBuf> = entries
            .flatten()
            .filter(|entry| entry.file_name().to_str().is_some_and(|name| is_own(name) && !listed(name)))
            .map(|entry| entry.path())
            .collect();
        stale.iter().for_each(|path| drop(std::fs::remove_file(path)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_flat_btf::encode::Scratch as _;

    const EXTENT: Extent = Extent::D2([1, 1]);

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn an_asset_is_replaced_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let mut first = Parts::new("a", path).unwrap();
        for part in ["normal", "flat.000", "flat.001"] {
            first.add(part, b"first", EXTENT, 1).unwrap();
        }
        assert_eq!(names(path).len(), 1, "nothing but the folder aside");
        first.commit("first list").unwrap();
        let whole = ["a.flat.000.ktx2", "a.flat.001.ktx2", "a.json", "a.normal.ktx2"];
        assert_eq!(names(path), whole);

        let mut second = Parts::new("a", path).unwrap();
        second.add("normal", b"second", EXTENT, 1).unwrap();
        drop(second);
        assert_eq!(names(path), whole);
        assert_eq!(std::fs::read(path.join("a.normal.ktx2")).unwrap(), b"first");
        assert_eq!(std::fs::read(path.join("a.json")).unwrap(), b"first list");

        let mut third = Parts::new("a", path).unwrap();
        third.add("normal", b"third", EXTENT, 1).unwrap();
        third.add("flat.000", b"third", EXTENT, 1).unwrap();
        third.commit("third list").unwrap();
        assert_eq!(names(path), ["a.flat.000.ktx2", "a.json", "a.normal.ktx2"]);
        assert_eq!(std::fs::read(path.join("a.normal.ktx2")).unwrap(), b"third");
    }

    #[test]
    fn factors_take_the_place_of_views_and_views_that_of_factors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        for parts in [&["flat.000", "flat.001"][..], &["basis", "shadow", "weights"], &["flat.000"]] {
            let mut asset = Parts::new("a", path).unwrap();
            asset.scratch().unwrap().write_scratch(7, b"on the way").unwrap();
            parts.iter().for_each(|part| asset.add(part, b"some", EXTENT, 1).unwrap());
            asset.commit("list").unwrap();
            let mut expected: Vec<String> = parts.iter().map(|part| format!("a.{part}.ktx2")).collect();
            expected.push("a.json".to_owned());
            expected.sort();
            assert_eq!(names(path), expected);
        }
    }

    #[test]
    fn the_next_finishes_what_a_killed_process_had_begun_to_move() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let mut old = Parts::new("a", path).unwrap();
        ["normal", "flat.000", "flat.001"].iter().for_each(|part| old.add(part, b"old", EXTENT, 1).unwrap());
        old.commit("old list").unwrap();
        // One that had moved a file, and one that was killed before all was there.
        let aside = |name: &str| {
            let aside = path.join(format!(".brdfc-{name}.tmp"));
            std::fs::create_dir(&aside).unwrap();
            std::fs::write(aside.join("lock"), "").unwrap();
            aside
        };
        let (dead, early) = (aside("dead"), aside("early"));
        std::fs::write(early.join("a.normal.ktx2"), "never finished").unwrap();
        std::fs::write(path.join("a.normal.ktx2"), "new").unwrap();
        std::fs::write(dead.join("a.flat.000.ktx2"), "new").unwrap();
        std::fs::write(dead.join("a.json"), "new list").unwrap();
        let moves = |files: &[&str]| {
            let files = files.iter().map(|file| (*file).to_owned()).collect();
            std::fs::write(dead.join(MOVES), write_record(&Moves { name: "a".to_owned(), files })).unwrap();
        };
        std::fs::remove_file(path.join("a.json")).unwrap();
        // Nothing outside the folder is anybody's to move.
        moves(&["a.normal.ktx2", "../a.flat.000.ktx2"]);
        Moves::finish_abandoned(path).unwrap();
        assert!(!path.join("a.json").exists());
        moves(&["a.normal.ktx2", "a.flat.000.ktx2"]);
        drop(Parts::new("b", path).unwrap());
        assert_eq!(names(path), ["a.flat.000.ktx2", "a.json", "a.normal.ktx2"]);
        for (file, text) in [("a.json", "new list"), ("a.normal.ktx2", "new"), ("a.flat.000.ktx2", "new")] {
            assert_eq!(std::fs::read_to_string(path.join(file)).unwrap(), text, "{file}");
        }
    }
}
