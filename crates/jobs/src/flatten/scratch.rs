//! Scratch storage in a folder.

use crate::error::Error;
use brdfc_flat_btf::encode::Scratch;
use brdfc_source::InputError;
use std::path::{Path, PathBuf};

/// Scratch storage in a folder, a file for each view.
pub(super) struct FolderScratch {
    /// Folder of the scratch files.
    folder: PathBuf,
    /// Folder of the finished files, for errors.
    name: String,
}

impl FolderScratch {
    /// Scratch storage in the temporary `folder`. Errors name the folder `finished`.
    pub(super) fn new(folder: PathBuf, finished: &Path) -> Self {
        Self { folder, name: finished.display().to_string() }
    }

    fn file(&self, view: u32) -> PathBuf {
        self.folder.join(format!("view.{view}"))
    }

    fn label(&self, view: u32) -> String {
        format!("{}, scratch file of view {view}", self.name)
    }
}

impl Scratch for FolderScratch {
    type Error = Error;

    fn write_scratch(&self, view: u32, values: &[u8]) -> Result<(), Error> {
        std::fs::write(self.file(view), values).map_err(|error| Error::write(self.label(view), &error))
    }

    fn read_scratch(&self, view: u32) -> Result<Vec<u8>, Error> {
        std::fs::read(self.file(view)).map_err(|error| InputError::Io { name: self.label(view), error }.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_values_are_read_and_missing_ones_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let scratch = FolderScratch::new(folder.path().to_owned(), Path::new("button"));
        scratch.write_scratch(7, b"first").unwrap();
        scratch.write_scratch(7, b"values").unwrap();
        assert_eq!(scratch.read_scratch(7).unwrap(), b"values");
        let error = scratch.read_scratch(8).unwrap_err().to_string();
        assert!(error.starts_with("button, scratch file of view 8: "), "{error}");
    }

    /// A device that is always full.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_named() {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.path().join("view.3")).unwrap();
        let scratch = FolderScratch::new(folder.path().to_owned(), Path::new("button"));
        let error = scratch.write_scratch(3, &[0; 100]).unwrap_err();
        let text = "button, scratch file of view 3: cannot write: No space left on device";
        assert_eq!(error.to_string(), text);
    }
}
