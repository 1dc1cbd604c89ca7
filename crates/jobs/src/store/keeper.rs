//! The store: entries by key, files by the hash of their bytes, sources by their paths.

use super::digest::{Digest, Key};
use super::record::{read_record, write_record};
use super::staging::Staging;
use super::stamp::Stamp;
use crate::error::Error;
use brdfc_source::read::{MAX_FILE_BYTES, read_regular_file};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

/// The store's folder, inside the output folder. It may be deleted unless a build was killed while it placed files.
pub const FOLDER: &str = ".brdfc-cache";
/// Subfolder of the stamp files of completed work items.
pub const DONE: &str = "done";
const ENTRIES: &str = "entries";
const OBJECTS: &str = "objects";
const SOURCES: &str = "sources";
/// Files that exclude the folder from backups and version control.
const MARKS: [(&str, &str); 2] = [
    (
        "CACHEDIR.TAG",
        "Signature: 8a477f597d28d172789f06886806bc55\n# Made by brdfc; may be deleted after a build that came to its end.\n",
    ),
    (".gitignore", "*\n"),
];
/// Files that no build has used for this long are removed.
const MAX_AGE: Duration = Duration::from_secs(30 * 24 * 3600);
/// Resolution of the times of last use.
const NOTED: Duration = Duration::from_secs(24 * 3600);

/// A cached result: a report, and the files that belong to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Cached<T> {
    /// Measurements that were made with the result.
    pub report: T,
    /// Hashes of the files, in the order in which [`Store::keep`] received them.
    pub files: Vec<Digest>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Entry<T> {
    /// Its own key, which detects entries under wrong names.
    key: Key,
    files: Vec<Digest>,
    report: T,
}

#[derive(Debug, Serialize, Deserialize)]
struct KnownSource {
    path: String,
    stamp: Stamp,
    digest: Digest,
}

/// The store of an output folder.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
    looks_up: bool,
    staging: Staging,
    staged: AtomicU64,
}

impl Store {
    /// Opens the store of an existing output folder. Without `looks_up`, all look-ups are misses.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be written to.
    pub fn open(folder: &Path, looks_up: bool) -> Result<Self, Error> {
        let root = folder.join(FOLDER);
        let new = |folder: &Path| std::fs::create_dir_all(folder).map_err(|error| Error::write(folder, &error));
        [ENTRIES, OBJECTS, SOURCES].iter().try_for_each(|name| new(&root.join(name)))?;
        let staging = Staging::new(&root).map_err(|error| Error::write(&root, &error))?;
        let store = Self { root, looks_up, staging, staged: AtomicU64::new(0) };
        for (name, text) in MARKS {
            if !store.root.join(name).exists() {
                store.write(&store.root.join(name), text.as_bytes())?;
            }
        }
        Ok(store)
    }

    /// Folder of the store.
    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    /// Returns the hash of a source if its stamp has not changed since [`Self::remember`].
    pub fn known(&self, path: &Path) -> Option<Digest> {
        if !self.looks_up {
            return None;
        }
        let known: KnownSource = read_record(&self.source_path(path))?;
        let stamp = Stamp::of(&std::fs::metadata(path).ok()?)?;
        (known.path == name_of(path) && known.stamp == stamp).then_some(known.digest)
    }

    /// Records the stamp and the hash of a source. Errors are ignored: the next build reads the source again.
    pub fn remember(&self, path: &Path, stamp: Stamp, digest: Digest) {
        let known = KnownSource { path: name_of(path), stamp, digest };
        let _ = self.write(&self.source_path(path), &write_record(&known));
    }

    /// Returns the result for a key if all its files still exist, in the store or among the `placed` files.
    pub fn look_up<T: DeserializeOwned>(&self, key: &Key, placed: &BTreeSet<Digest>) -> Option<Cached<T>> {
        if !self.looks_up {
            return None;
        }
        let path = self.entry_path(key);
        let entry: Entry<T> = read_record(&path)?;
        let there = |digest: &Digest| placed.contains(digest) || self.object(digest).is_some();
        if entry.key != *key || !entry.files.iter().all(there) {
            return None;
        }
        note_use(&path);
        entry.files.iter().for_each(|digest| note_use(&self.object_path(digest)));
        Some(Cached { report: entry.report, files: entry.files })
    }

    /// Stores a result: first its files, then the entry that lists them. Returns the hashes of the files.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn keep<T: Serialize>(&self, key: Key, files: &[Vec<u8>], report: &T) -> Result<Vec<Digest>, Error> {
        let mut digests = Vec::new();
        for bytes in files {
            let digest = Digest::of(bytes);
            self.write(&self.object_path(&digest), bytes)?;
            digests.push(digest);
        }
        let path = self.entry_path(&key);
        self.write(&path, &write_record(&Entry { key, files: digests.clone(), report }))?;
        Ok(digests)
    }

    /// Returns the bytes of a file if they match the hash.
    pub fn object(&self, digest: &Digest) -> Option<Vec<u8>> {
        let bytes = read_regular_file(&self.object_path(digest), MAX_FILE_BYTES).ok()?;
        (Digest::of(&bytes) == *digest).then_some(bytes)
    }

    /// Copies the entries and files that only the store of another output folder has, for example of another machine.
    /// Damaged entries do no harm: each look-up checks what it returns.
    ///
    /// # Errors
    /// Returns an error if the folder has no store, or if a file cannot be read or written.
    pub fn take_from(&self, folder: &Path) -> Result<(), Error> {
        for kind in [OBJECTS, ENTRIES] {
            let other = folder.join(FOLDER).join(kind);
            let error = |error: std::io::Error| Error::read(&other, &error);
            for file in std::fs::read_dir(&other).map_err(error)? {
                let from = file.map_err(error)?.path();
                let to = self.root.join(kind).join(from.file_name().unwrap_or_default());
                if !to.exists() {
                    self.write(&to, &std::fs::read(&from).map_err(|error| Error::read(&from, &error))?)?;
                }
            }
        }
        Ok(())
    }

    /// Removes entries and files that no build has used for 30 days.
    pub fn prune(&self) {
        for folder in [ENTRIES, OBJECTS, SOURCES] {
            let Ok(files) = std::fs::read_dir(self.root.join(folder)) else { continue };
            for file in files.flatten() {
                let used = file.metadata().and_then(|metadata| metadata.modified());
                if used.is_ok_and(|used| used.elapsed().is_ok_and(|age| age > MAX_AGE)) {
                    let _ = std::fs::remove_file(file.path());
                }
            }
        }
    }

    /// Writes a file atomically.
    fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        let number = self.staged.fetch_add(1, Ordering::Relaxed);
        let aside = self.staging.path().join(number.to_string());
        let written = std::fs::write(&aside, bytes).and_then(|()| std::fs::rename(&aside, path));
        written.map_err(|error| {
            let _ = std::fs::remove_file(&aside);
            Error::write(path, &error)
        })
    }

    fn entry_path(&self, key: &Key) -> PathBuf {
        self.root.join(ENTRIES).join(key.to_string())
    }

    fn object_path(&self, digest: &Digest) -> PathBuf {
        self.root.join(OBJECTS).join(digest.to_string())
    }

    fn source_path(&self, path: &Path) -> PathBuf {
        self.root.join(SOURCES).join(Digest::of(name_of(path).as_bytes()).to_string())
    }
}

/// Absolute path, as text.
fn name_of(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

/// Updates the time of last use of a file, so that it is not pruned.
fn note_use(path: &Path) {
    let now = SystemTime::now();
    let noted = path.metadata().and_then(|metadata| metadata.modified());
    if noted.is_ok_and(|noted| now.duration_since(noted).is_ok_and(|age| age > NOTED)) {
        let _ = File::options().write(true).open(path).and_then(|file| file.set_modified(now));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(number: u32) -> Key {
        Key::new("brdf", Digest::of(b"source"), &number)
    }

    fn found(store: &Store, number: u32) -> Option<Cached<String>> {
        store.look_up(&key(number), &BTreeSet::new())
    }

    #[test]
    fn a_result_is_found_only_by_its_key() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), true).unwrap();
        let files = store.keep(key(1), &[b"pack".to_vec(), b"map".to_vec()], &"report").unwrap();
        let cached = Cached { report: "report".to_owned(), files: files.clone() };
        assert_eq!((found(&store, 1), found(&store, 2)), (Some(cached), None));
        assert_eq!(store.object(&files[0]).as_deref(), Some(&b"pack"[..]));
        assert_eq!(found(&Store::open(folder.path(), false).unwrap(), 1), None);
        drop(store);
        let left = std::fs::read_dir(folder.path().join(FOLDER)).unwrap().flatten().map(|entry| entry.file_name());
        assert!(left.into_iter().all(|name| !name.to_string_lossy().ends_with(".tmp")));
    }

    #[test]
    fn broken_swapped_and_lost_files_are_misses() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), true).unwrap();
        let files = store.keep(key(1), &[b"pack".to_vec()], &"report").unwrap();
        std::fs::copy(store.entry_path(&key(1)), store.entry_path(&key(2))).unwrap();
        assert_eq!(found(&store, 2), None, "an entry under the name of another");
        std::fs::write(store.object_path(&files[0]), "pick").unwrap();
        assert_eq!(found(&store, 1), None, "other bytes");
        let placed = BTreeSet::from([files[0]]);
        assert!(store.look_up::<String>(&key(1), &placed).is_some(), "the file is in place");
        std::fs::remove_file(store.object_path(&files[0])).unwrap();
        assert_eq!(found(&store, 1), None);
    }

    #[test]
    fn sources_are_known_until_they_change() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), true).unwrap();
        let path = folder.path().join("scan.brdf");
        std::fs::write(&path, "rows").unwrap();
        let stamp = || Stamp::of(&std::fs::metadata(&path).unwrap()).unwrap();
        assert_eq!(store.known(&path), None);
        store.remember(&path, stamp(), Digest::of(b"rows"));
        assert_eq!(store.known(&path), Some(Digest::of(b"rows")));
        std::fs::write(&path, "other rows").unwrap();
        assert_eq!(store.known(&path), None);
    }
}
