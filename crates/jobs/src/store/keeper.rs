//! The store itself: entries by key, files by the hash of their bytes, sources by their stamps.

use super::digest::{Digest, Key};
use super::record::{read_record, write_record};
use super::staging::Staging;
use super::stamp::Stamp;
use crate::error::Error;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

/// The store's folder, inside the output folder. It may be deleted unless a build was killed while it placed files.
pub const FOLDER: &str = ".brdfc-cache";
/// Inside it: marks of what is done.
pub const DONE: &str = "done";
const ENTRIES: &str = "entries";
const OBJECTS: &str = "objects";
const SOURCES: &str = "sources";
/// By which backups and version control leave the folder out.
const MARKS: [(&str, &str); 2] = [
    (
        "CACHEDIR.TAG",
        "Signature: 8a477f597d28d172789f06886806bc55\n# Made by brdfc; may be deleted after a build that came to its end.\n",
    ),
    (".gitignore", "*\n"),
];
/// What no build has asked for in this time is removed.
const KEPT_FOR: Duration = Duration::from_secs(30 * 24 * 3600);
/// Times of use are noted this coarsely.
const NOTED: Duration = Duration::from_secs(24 * 3600);

/// What an entry says: a report, and the files that were made.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept<T> {
    /// What was measured.
    pub report: T,
    /// The files, in the order in which they were kept.
    pub files: Vec<Digest>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Entry<T> {
    /// Its own: an entry in another's place is none.
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
    /// Of this output folder, which is there. Without `looks_up` everything is made again.
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

    /// The store's folder.
    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    /// The hash of a source that has not changed since it was read.
    pub fn known(&self, path: &Path) -> Option<Digest> {
        if !self.looks_up {
            return None;
        }
        let known: KnownSource = read_record(&self.source_path(path))?;
        let stamp = Stamp::of(&std::fs::metadata(path).ok()?)?;
        (known.path == name_of(path) && known.stamp == stamp).then_some(known.digest)
    }

    /// Notes by what a source is known again. Where that cannot be kept it is read again, and nothing else happens.
    pub fn remember(&self, path: &Path, stamp: Stamp, digest: Digest) {
        let known = KnownSource { path: name_of(path), stamp, digest };
        let _ = self.write(&self.source_path(path), &write_record(&known));
    }

    /// What was made for this key, if all its files are still there: in the store, or among those that are `placed`.
    pub fn look_up<T: DeserializeOwned>(&self, key: &Key, placed: &BTreeSet<Digest>) -> Option<Kept<T>> {
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
        Some(Kept { report: entry.report, files: entry.files })
    }

    /// Keeps what was made: first its files, then the entry that names them.
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

    /// The bytes of a file, if they are what its name says.
    pub fn object(&self, digest: &Digest) -> Option<Vec<u8>> {
        let bytes = std::fs::read(self.object_path(digest)).ok()?;
        (Digest::of(&bytes) == *digest).then_some(bytes)
    }

    /// Takes what another store holds and this one does not, such as that of another machine. What is broken there is never
    /// believed: it is checked when it is looked up.
    ///
    /// # Errors
    /// A folder without a store; what cannot be read or written.
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

    /// Removes what no build has asked for in a month.
    pub fn prune(&self) {
        for folder in [ENTRIES, OBJECTS, SOURCES] {
            let Ok(files) = std::fs::read_dir(self.root.join(folder)) else { continue };
            for file in files.flatten() {
                let used = file.metadata().and_then(|metadata| metadata.modified());
                if used.is_ok_and(|used| used.elapsed().is_ok_and(|age| age > KEPT_FOR)) {
                    let _ = std::fs::remove_file(file.path());
                }
            }
        }
    }

    /// Writes a file whole or not at all.
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

/// A path that does not depend on the working folder.
fn name_of(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

/// Keeps a file from being pruned.
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

    fn found(store: &Store, number: u32) -> Option<Kept<String>> {
        store.look_up(&key(number), &BTreeSet::new())
    }

    #[test]
    fn what_was_kept_is_found_by_its_key_alone() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), true).unwrap();
        let files = store.keep(key(1), &[b"pack".to_vec(), b"map".to_vec()], &"report").unwrap();
        let kept = Kept { report: "report".to_owned(), files: files.clone() };
        assert_eq!((found(&store, 1), found(&store, 2)), (Some(kept), None));
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
        assert_eq!(found(&store, 2), None, "an entry in another's place");
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
