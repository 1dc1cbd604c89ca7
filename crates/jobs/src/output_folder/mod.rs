//! The output folder of a build, whose contents match the build report.
//!
//! A build puts all files in place together, when all are made. Its report lists them with hashes, so that the next
//! build may replace or remove them; files of others are never touched. A record in the store has the same list, and
//! the stamps by which unchanged files are recognised without reading them. The store may be deleted. A process that
//! is killed while it moves files leaves a journal, and the next process that opens the folder completes the moves.

mod journal;
mod placed;

use crate::error::Error;
use crate::store::{DONE, Digest, FOLDER, Store, read_record, write_record};
use brdfc_core::progress::Progress;
use brdfc_source::read::{MAX_FILE_BYTES, read_regular_file};
use journal::Journal;
use placed::{PLACED, Placed, Placements};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Lock file, locked while files are moved.
const LOCK: &str = "lock";
/// Time between two attempts to lock it.
const RETRY: Duration = Duration::from_millis(20);
/// Time after which a wait is reported.
const REPORTED: Duration = Duration::from_secs(1);
/// Maximum time that a reader waits for a build that moves files.
const PATIENCE: Duration = Duration::from_secs(3);

/// The bytes of a file to put in place.
#[derive(Debug, Clone, PartialEq)]
pub enum Contents {
    /// A file in the store.
    Cached(Digest),
    /// Bytes in memory, for example of a report.
    Bytes(Vec<u8>),
}

/// Changes that a build made in the folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Changes {
    /// Files that were written.
    pub written: Vec<String>,
    /// Files of earlier builds that were removed.
    pub removed: Vec<String>,
    /// Files of earlier builds that are no longer needed, but stay because they were edited.
    pub left: Vec<String>,
}

/// An output folder, with the record of the files that builds put there.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    root: PathBuf,
    placements: Placements,
}

impl OutputFolder {
    /// Completes the moves of a killed build, and reads the record of earlier builds.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be written to, or if the caller cancels while another build moves files.
    pub fn open(path: &Path, store: &Store, progress: &dyn Progress) -> Result<Self, Error> {
        let root = store.root().to_owned();
        let _lock = lock(path, &root, progress)?;
        Journal::finish(path, &root)?;
        let placements = read_record(&root.join(PLACED)).unwrap_or_default();
        Ok(Self { path: path.to_owned(), root, placements })
    }

    /// Returns true if a killed build left moves to complete.
    pub fn is_unfinished(path: &Path) -> bool {
        Journal::is_there(&path.join(crate::store::FOLDER))
    }

    /// Returns true if a build put files into a folder, according to its store.
    pub fn is_placed(path: &Path) -> bool {
        path.join(FOLDER).join(PLACED).exists()
    }

    /// Waits until no build moves files in a folder, and prevents new moves until the returned file is dropped; `None`
    /// if the folder has no store.
    ///
    /// # Errors
    /// Returns an error if a build still moves files after 3 s.
    pub fn hold_still(path: &Path) -> Result<Option<File>, Error> {
        let Ok(file) = File::open(path.join(FOLDER).join(LOCK)) else { return Ok(None) };
        let started = Instant::now();
        while let Err(TryLockError::WouldBlock) = file.try_lock_shared() {
            if started.elapsed() >= PATIENCE {
                let text = "a build is replacing files in this folder; try again later";
                return Err(Error::io(format!("{}: {text}", path.display())));
            }
            std::thread::sleep(RETRY);
        }
        Ok(Some(file))
    }

    /// Adds the files that a report lists, with their hashes. They count as files of a build even if the store was
    /// deleted.
    pub fn also_placed(&mut self, listed: impl IntoIterator<Item = (String, Digest)>) {
        self.placements.also(&self.path, listed);
    }

    /// Returns the bytes of a file that a build put in place; `None` if there is none with this hash.
    pub fn bytes(&self, digest: &Digest) -> Option<Vec<u8>> {
        let (name, _) = self.placements.files.iter().find(|(_, placed)| placed.digest == *digest)?;
        let bytes = read_regular_file(&self.path.join(name), MAX_FILE_BYTES).ok()?;
        (Digest::of(&bytes) == *digest).then_some(bytes)
    }

    /// Returns true if the folder has a file of this name.
    pub fn has(&self, name: &str) -> bool {
        self.path.join(name).is_file()
    }

    /// Returns true if the folder has a file of this name with other bytes.
    pub fn holds_other(&self, name: &str, digest: &Digest) -> bool {
        read_regular_file(&self.path.join(name), MAX_FILE_BYTES).is_ok_and(|bytes| Digest::of(&bytes) != *digest)
    }

    /// Checks that a build may write files of these names.
    ///
    /// # Errors
    /// Returns an error at the first that exists and that no build wrote. With `force`, only folders are errors.
    pub fn refuse_foreign<'a>(&self, names: impl IntoIterator<Item = &'a str>, force: bool) -> Result<(), Error> {
        for name in names {
            let path = self.path.join(name);
            let Ok(metadata) = path.symlink_metadata() else { continue };
            let text = match () {
                () if metadata.is_dir() => "a folder is in the way; rename it, or choose another output folder",
                () if force || self.placements.files.contains_key(name) => continue,
                () if metadata.is_symlink() => "would overwrite a link that no build made; remove it, or use --force",
                () => "would overwrite a file that no build wrote; remove it, or use --force",
            };
            return Err(Error::io(format!("{}: {text}", path.display())));
        }
        Ok(())
    }

    /// Unchanged files of earlier builds, with their hashes.
    pub fn there(&self) -> BTreeMap<String, Digest> {
        let verified = self.placements.verified(&self.path).into_iter();
        verified.map(|(name, placed)| (name, placed.digest)).collect()
    }

    /// Checks that a build that writes files of these names removes none of its inputs.
    ///
    /// # Errors
    /// Returns an error at the first input that is a file of an earlier build and not among the names.
    pub fn refuse_removing<'a>(
        &self,
        inputs: impl Iterator<Item = &'a Path>,
        names: &BTreeSet<&str>,
    ) -> Result<(), Error> {
        let mut removed = self.placements.files.keys().filter(|name| !names.contains(name.as_str())).peekable();
        if removed.peek().is_none() {
            return Ok(());
        }
        let read: BTreeSet<PathBuf> = inputs.filter_map(|input| input.canonicalize().ok()).collect();
        match removed.find(|name| self.path.join(name).canonicalize().is_ok_and(|path| read.contains(&path))) {
            Some(name) => {
                let text = "the build would remove this input; choose another output folder, or use --keep";
                Err(Error::usage(format!("{}: {text}", self.path.join(name).display())))
            }
            None => Ok(()),
        }
    }

    /// Puts all files in place, and removes other files of earlier builds. The folder does not change until all files
    /// are written to the store. `files` receives the unchanged files of earlier builds, while no
    /// other build can change them, and returns the files to place, including unchanged ones.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written, if `files` fails, or if the caller cancels while another build
    /// moves files. The folder is unchanged then.
    pub fn place(
        &mut self,
        store: &Store,
        progress: &dyn Progress,
        files: impl FnOnce(&BTreeMap<String, Digest>) -> Result<Vec<(String, Contents)>, Error>,
    ) -> Result<Changes, Error> {
        let _lock = lock(&self.path, &self.root, progress)?;
        // Another build may have placed files since `open`.
        Journal::finish(&self.path, &self.root)?;
        if let Some(placements) = read_record::<Placements>(&self.root.join(PLACED)) {
            self.placements.files.extend(placements.files);
        }
        let unchanged: BTreeMap<String, Placed> = self.placements.verified(&self.path);
        let files = files(&unchanged.iter().map(|(name, placed)| (name.clone(), placed.digest)).collect())?;
        let mut journal = Journal::new(&self.root);
        let mut changes = Changes::default();
        let mut placements = Placements::default();
        for (name, contents) in files {
            let digest = match &contents {
                Contents::Cached(digest) => *digest,
                Contents::Bytes(bytes) => Digest::of(bytes),
            };
            if let Some(placed) = unchanged.get(&name).filter(|placed| placed.digest == digest) {
                placements.files.insert(name, placed.clone());
                continue;
            }
            let target = self.path.join(&name);
            let bytes = match contents {
                Contents::Bytes(bytes) => bytes,
                Contents::Cached(digest) => {
                    let found = store.object(&digest).or_else(|| self.bytes(&digest));
                    let lost = || std::io::Error::other("its contents are missing from the store");
                    found.ok_or_else(|| Error::write(&target, &lost()))?
                }
            };
            journal.write(&name, &bytes).map_err(|error| Error::write(&target, &error))?;
            placements.files.insert(name.clone(), Placed { digest, stamp: None });
            changes.written.push(name);
        }
        for name in self.placements.files.keys().filter(|name| !placements.files.contains_key(*name)) {
            if unchanged.contains_key(name) {
                journal.remove(name);
                changes.removed.push(name.clone());
            } else if self.path.join(name).exists() {
                changes.left.push(name.clone());
            }
        }
        let record = self.root.join(PLACED);
        if journal.is_empty() && placements == self.placements && record.exists() {
            return Ok(changes);
        }
        if !journal.is_empty() {
            journal.commit(&self.path, &self.root, &write_record(&placements))?;
        }
        placements.stamp(&self.path);
        // The files are in place, and the report lists them: without the stamps, the next build reads the files.
        let _ = crate::write::write_atomic(&record, &write_record(&placements));
        self.placements = placements;
        Ok(changes)
    }
}

/// Returns true if a path belongs to a build in an output folder: it has the extension of packs or reports, or is in
/// the store outside the folder of stamps. Both paths have their links resolved.
pub fn is_own(place: &Path, out: &Path) -> bool {
    const OWN: [&str; 2] = ["ktx2", "json"];
    let store = out.join(FOLDER);
    let is_product = place.extension().is_some_and(|found| OWN.iter().any(|own| found.eq_ignore_ascii_case(own)));
    place.parent() == Some(out) && is_product || place.starts_with(&store) && !place.starts_with(store.join(DONE))
}

/// Waits until no other process moves files or prevents moves.
fn lock(folder: &Path, root: &Path, progress: &dyn Progress) -> Result<File, Error> {
    let path = root.join(LOCK);
    let error = |error: std::io::Error| Error::write(&path, &error);
    let file = File::options().create(true).truncate(false).write(true).open(&path).map_err(error)?;
    let started = Instant::now();
    let mut is_reported = false;
    // On systems without file locks, the user has to avoid two builds at a time.
    while let Err(TryLockError::WouldBlock) = file.try_lock() {
        progress.check()?;
        if !is_reported && started.elapsed() >= REPORTED {
            progress.waits(&format!("another brdfc that works in {}", folder.display()));
            is_reported = true;
        }
        std::thread::sleep(RETRY);
    }
    Ok(file)
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod walk;
