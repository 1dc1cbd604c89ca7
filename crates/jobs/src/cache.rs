//! The build cache: what files were made from, so that what is unchanged is not made again.
//!
//! A `bincode` file for each pack, and for the maps of each material and of the scene, in a folder beside them. A stale or
//! broken entry is no error: the files are made again.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Folder of the cache, inside the output folder.
pub const FOLDER: &str = ".brdfc-cache";

/// What was put in, options apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Hash of the program: a new version makes everything again.
    pub program: [u8; 32],
    /// Hash of the source's bytes, or of its address.
    pub source: [u8; 32],
}

/// What is kept of files that were made together. `R` is all options, `T` what was measured.
#[derive(Debug, Serialize, Deserialize)]
struct Entry<R, T> {
    origin: Origin,
    recipe: R,
    /// Hash of each file.
    files: Vec<[u8; 32]>,
    report: T,
}

/// Hash of a file's bytes.
pub fn hash_file(path: &Path) -> std::io::Result<[u8; 32]> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(std::fs::File::open(path)?)?;
    Ok(*hasher.finalize().as_bytes())
}

/// Hash of bytes in memory.
pub fn hash(bytes: &[u8]) -> [u8; 32] {
    *blake3::hash(bytes).as_bytes()
}

/// Hash of this very program.
pub fn hash_program() -> std::io::Result<[u8; 32]> {
    hash_file(&std::env::current_exe()?)
}

/// Files that are made together, and what decides their bytes.
#[derive(Debug)]
pub struct Slot<'a, R> {
    /// The output folder.
    pub out: &'a Path,
    /// Name of the entry.
    pub name: String,
    /// The files, relative to the output folder.
    pub files: Vec<String>,
    /// Without one nothing is looked up or kept.
    pub origin: Option<Origin>,
    /// All options.
    pub recipe: R,
}

impl<R: Clone + PartialEq + Serialize + DeserializeOwned> Slot<'_, R> {
    fn path(&self) -> PathBuf {
        self.out.join(FOLDER).join(format!("{}.bincode", self.name))
    }

    /// The report of files that are there, whole, and made from the same.
    pub fn look_up<T: DeserializeOwned>(&self) -> Option<T> {
        let origin = self.origin?;
        let bytes = std::fs::read(self.path()).ok()?;
        let config = bincode::config::standard().with_limit::<{ 1 << 20 }>();
        let (entry, _): (Entry<R, T>, usize) = bincode::serde::decode_from_slice(&bytes, config).ok()?;
        let whole =
            |(file, hash): (&String, &[u8; 32])| hash_file(&self.out.join(file)).is_ok_and(|found| found == *hash);
        let same = entry.origin == origin && entry.recipe == self.recipe && entry.files.len() == self.files.len();
        (same && self.files.iter().zip(&entry.files).all(whole)).then_some(entry.report)
    }

    /// Keeps a report of files with these bytes. A cache that cannot be kept costs time in the next build, nothing else.
    pub fn store<T: Serialize>(&self, files: &[Vec<u8>], report: &T) {
        let Some(origin) = self.origin else { return };
        let files = files.iter().map(|bytes| hash(bytes)).collect();
        let entry = Entry { origin, recipe: self.recipe.clone(), files, report };
        let Ok(bytes) = bincode::serde::encode_to_vec(&entry, bincode::config::standard()) else { return };
        if std::fs::create_dir_all(self.out.join(FOLDER)).is_ok() {
            let _ = super::write::write_atomic(&self.path(), &bytes);
        }
    }
}
