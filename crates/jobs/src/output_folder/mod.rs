//! The folder that a build fills: what stands there is what its report says.
//!
//! Files are put in place all together, when all are made. What a build puts there its report lists with hashes, so that the next
//! one may replace or remove it; what anybody else puts there is never touched. A record in the store says the same, and by which
//! stamps files are known without being read: the store may be deleted. A process that is killed while files change places
//! leaves a journal, by which whoever opens the folder next finishes what was begun.

mod journal;
mod placed;

use crate::error::Error;
use crate::store::{DONE, Digest, FOLDER, Store, read_record, write_record};
use brdfc_core::progress::Progress;
use journal::Journal;
use placed::{PLACED, Placed, Placements};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Held while files change places.
const LOCK: &str = "lock";
/// Between two tries to take it.
const RETRY: Duration = Duration::from_millis(20);
/// A wait of this time is reported.
const REPORTED: Duration = Duration::from_secs(1);
/// Who only reads waits so long for a build that moves files.
const PATIENCE: Duration = Duration::from_secs(3);

/// The bytes of a file to put in place.
#[derive(Debug, Clone, PartialEq)]
pub enum Contents {
    /// A file of the store.
    Kept(Digest),
    /// These.
    Bytes(Vec<u8>),
}

/// What changed in the folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Changes {
    /// Files that were written.
    pub written: Vec<String>,
    /// Files of earlier builds that were removed.
    pub removed: Vec<String>,
    /// Files of earlier builds that are no longer needed, but were changed by somebody since, and stay.
    pub left: Vec<String>,
}

/// An output folder.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    root: PathBuf,
    placements: Placements,
}

impl OutputFolder {
    /// Finishes what a killed build had begun, and reads what earlier builds put here.
    ///
    /// # Errors
    /// A folder that cannot be written to; cancellation while another build moves files.
    pub fn open(path: &Path, store: &Store, progress: &dyn Progress) -> Result<Self, Error> {
        let root = store.root().to_owned();
        let _lock = lock(path, &root, progress)?;
        Journal::finish(path, &root)?;
        let placements = read_record(&root.join(PLACED)).unwrap_or_default();
        Ok(Self { path: path.to_owned(), root, placements })
    }

    /// Whether a killed build left files between two places.
    pub fn is_unfinished(path: &Path) -> bool {
        Journal::is_there(&path.join(crate::store::FOLDER))
    }

    /// Whether a build put files into a folder, by its store.
    pub fn is_placed(path: &Path) -> bool {
        path.join(FOLDER).join(PLACED).exists()
    }

    /// Keeps builds from moving files in a folder as long as what is returned lives, once none does; nothing where no build was.
    ///
    /// # Errors
    /// A build that goes on moving files.
    pub fn hold_still(path: &Path) -> Result<Option<File>, Error> {
        let Ok(file) = File::open(path.join(FOLDER).join(LOCK)) else { return Ok(None) };
        let started = Instant::now();
        while let Err(TryLockError::WouldBlock) = file.try_lock_shared() {
            if started.elapsed() >= PATIENCE {
                let found = "a build at work, which puts files in place";
                return Err(Error::io(format!("{}: found {found}; allowed once it has ended", path.display())));
            }
            std::thread::sleep(RETRY);
        }
        Ok(Some(file))
    }

    /// Files of earlier builds that a report lists, with their hashes: ours even where the store was deleted.
    pub fn also_placed(&mut self, listed: impl IntoIterator<Item = (String, Digest)>) {
        self.placements.also(&self.path, listed);
    }

    /// The bytes of a file that a build put in place.
    pub fn bytes(&self, digest: &Digest) -> Option<Vec<u8>> {
        let (name, _) = self.placements.files.iter().find(|(_, placed)| placed.digest == *digest)?;
        let bytes = std::fs::read(self.path.join(name)).ok()?;
        (Digest::of(&bytes) == *digest).then_some(bytes)
    }

    /// True if a file of this name is there.
    pub fn has(&self, name: &str) -> bool {
        self.path.join(name).is_file()
    }

    /// Whether a file of this name is there that has other bytes.
    pub fn holds_other(&self, name: &str, digest: &Digest) -> bool {
        std::fs::read(self.path.join(name)).is_ok_and(|bytes| Digest::of(&bytes) != *digest)
    }

    /// Whether a build may write files of these names.
    ///
    /// # Errors
    /// The first that is there and that no build wrote.
    pub fn refuse_foreign<'a>(&self, names: impl IntoIterator<Item = &'a str>, force: bool) -> Result<(), Error> {
        for name in names {
            let path = self.path.join(name);
            let Ok(metadata) = path.symlink_metadata() else { continue };
            let found = match () {
                () if metadata.is_dir() => "a folder",
                () if force || self.placements.files.contains_key(name) => continue,
                () if metadata.is_symlink() => "a link that no build made",
                () => "a file that no build wrote",
            };
            let allowed = "nothing, or what an earlier build wrote there (--force replaces a file)";
            return Err(Error::io(format!("{}: found {found}; allowed {allowed}", path.display())));
        }
        Ok(())
    }

    /// Files of earlier builds that are there and unchanged.
    pub fn there(&self) -> BTreeMap<String, Digest> {
        let verified = self.placements.verified(&self.path).into_iter();
        verified.map(|(name, placed)| (name, placed.digest)).collect()
    }

    /// Whether none of these inputs is a file of an earlier build that is removed when files of these names are put in place.
    ///
    /// # Errors
    /// The first that is.
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
                let found = "an input, which this build would remove, as it makes no file of that name";
                let allowed = "another output folder, or --keep";
                Err(Error::wrong_usage(self.path.join(name).display(), found, allowed))
            }
            None => Ok(()),
        }
    }

    /// Puts all files in place by their names, and removes those of earlier builds that are not among them. Until all are
    /// written aside the folder stays as it is. `files` is given those of earlier builds that are there and unchanged, while no
    /// other build can change them: what of them is to stay is to be among what it returns.
    ///
    /// # Errors
    /// A file that cannot be written, what `files` fails by, cancellation while another build moves files: then nothing has changed.
    pub fn place(
        &mut self,
        store: &Store,
        progress: &dyn Progress,
        files: impl FnOnce(&BTreeMap<String, Digest>) -> Result<Vec<(String, Contents)>, Error>,
    ) -> Result<Changes, Error> {
        let _lock = lock(&self.path, &self.root, progress)?;
        // Another build may have been faster.
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
                Contents::Kept(digest) => *digest,
                Contents::Bytes(bytes) => Digest::of(bytes),
            };
            if let Some(placed) = unchanged.get(&name).filter(|placed| placed.digest == digest) {
                placements.files.insert(name, placed.clone());
                continue;
            }
            let target = self.path.join(&name);
            let bytes = match contents {
                Contents::Bytes(bytes) => bytes,
                Contents::Kept(digest) => {
                    let found = store.object(&digest).or_else(|| self.bytes(&digest));
                    let lost = || std::io::Error::other("what was made for it is gone from the store");
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
        // The files are in place, and the report lists them: where stamps cannot be kept, files are read again.
        let _ = crate::write::write_atomic(&record, &write_record(&placements));
        self.placements = placements;
        Ok(changes)
    }
}

/// Whether a place is one of a build's own in an output folder, both without links: it is called as packs and reports are, or is
/// in the store, but where marks of what is done are.
pub fn is_own(place: &Path, out: &Path) -> bool {
    const OWN: [&str; 2] = ["ktx2", "json"];
    let store = out.join(FOLDER);
    let is_called_so = place.extension().is_some_and(|found| OWN.iter().any(|own| found.eq_ignore_ascii_case(own)));
    place.parent() == Some(out) && is_called_so || place.starts_with(&store) && !place.starts_with(store.join(DONE))
}

/// Waits until no other process moves files or holds them still.
fn lock(folder: &Path, root: &Path, progress: &dyn Progress) -> Result<File, Error> {
    let path = root.join(LOCK);
    let error = |error: std::io::Error| Error::write(&path, &error);
    let file = File::options().create(true).truncate(false).write(true).open(&path).map_err(error)?;
    let started = Instant::now();
    let mut is_reported = false;
    // Where files cannot be locked, two builds at a time are the user's to avoid.
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
