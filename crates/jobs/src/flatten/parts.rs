//! The files of an asset: written aside, and put in place when all are there.

use super::asset::PartFile;
use super::error::FlattenError;
use crate::store::Staging;
use crate::write::write_atomic;
use brdfc_formats::container::Extent;
use brdfc_formats::flat_btf::gpu_bytes;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the names of parts' files end with.
const EXTENSION: &str = ".ktx2";

/// Files that are being made. Until [`Self::commit`] an asset that stands in the folder stays as it is, and what was
/// written goes away with this.
pub(super) struct Parts<'a> {
    name: &'a str,
    folder: &'a Path,
    aside: Staging,
    files: BTreeMap<String, PartFile>,
}

impl<'a> Parts<'a> {
    /// An asset of this name in this folder, which is there.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(super) fn new(name: &'a str, folder: &'a Path) -> Result<Self, FlattenError> {
        let aside = Staging::new(folder).map_err(|error| FlattenError::write(folder, error))?;
        Ok(Self { name, folder, aside, files: BTreeMap::new() })
    }

    /// Writes a part of this extent aside.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn add(&mut self, part: &str, bytes: &[u8], extent: Extent) -> Result<(), FlattenError> {
        let file = format!("{}.{part}{EXTENSION}", self.name);
        std::fs::write(self.aside.path().join(&file), bytes)
            .map_err(|error| FlattenError::write(&self.folder.join(&file), error))?;
        let blake3 = blake3::hash(bytes).to_hex().to_string();
        let listed = PartFile { file, bytes: bytes.len() as u64, gpu_bytes: gpu_bytes(part, extent), blake3 };
        self.files.insert(part.to_owned(), listed);
        Ok(())
    }

    /// What was written so far, by part.
    pub(super) fn files(&self) -> &BTreeMap<String, PartFile> {
        &self.files
    }

    /// Puts everything in place, and the list of parts last. While files change places there is no list, so that no
    /// mixture passes for an asset.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn commit(self, list: &str) -> Result<(), FlattenError> {
        let listing = self.folder.join(format!("{}.json", self.name));
        match std::fs::remove_file(&listing) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(FlattenError::write(&listing, error));
            }
            _ => {}
        }
        for part in self.files.values() {
            let target = self.folder.join(&part.file);
            std::fs::rename(self.aside.path().join(&part.file), &target)
                .map_err(|error| FlattenError::write(&target, error))?;
        }
        self.remove_stale();
        write_atomic(&listing, list.as_bytes()).map_err(|error| FlattenError::write(&listing, error))
    }

    /// Views of an earlier asset of the same name that had more of them.
    fn remove_stale(&self) {
        let prefix = format!("{}.flat.", self.name);
        let Ok(entries) = std::fs::read_dir(self.folder) else { return };
        let is_view = |name: &str| {
            let number = name.strip_prefix(&prefix).and_then(|rest| rest.strip_suffix(EXTENSION));
            number.is_some_and(|n| (3..=4).contains(&n.len()) && n.bytes().all(|byte| byte.is_ascii_digit()))
        };
        let listed = |name: &str| self.files.values().any(|part| part.file == name);
        let stale: Vec<PathBuf> = entries
            .flatten()
            .filter(|entry| entry.file_name().to_str().is_some_and(|name| is_view(name) && !listed(name)))
            .map(|entry| entry.path())
            .collect();
        stale.iter().for_each(|path| drop(std::fs::remove_file(path)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            first.add(part, b"first", EXTENT).unwrap();
        }
        assert_eq!(names(path).len(), 1, "nothing but the folder aside");
        first.commit("first list").unwrap();
        let whole = ["a.flat.000.ktx2", "a.flat.001.ktx2", "a.json", "a.normal.ktx2"];
        assert_eq!(names(path), whole);

        let mut second = Parts::new("a", path).unwrap();
        second.add("normal", b"second", EXTENT).unwrap();
        drop(second);
        assert_eq!(names(path), whole);
        assert_eq!(std::fs::read(path.join("a.normal.ktx2")).unwrap(), b"first");
        assert_eq!(std::fs::read(path.join("a.json")).unwrap(), b"first list");

        let mut third = Parts::new("a", path).unwrap();
        third.add("normal", b"third", EXTENT).unwrap();
        third.add("flat.000", b"third", EXTENT).unwrap();
        third.commit("third list").unwrap();
        assert_eq!(names(path), ["a.flat.000.ktx2", "a.json", "a.normal.ktx2"]);
        assert_eq!(std::fs::read(path.join("a.normal.ktx2")).unwrap(), b"third");
    }
}
