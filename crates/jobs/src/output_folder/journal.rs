//! Atomic moves of several files: commits moves and record together, for crash recovery. New files are written aside
//! and listed, then moved. A process that is killed before it writes the list has changed nothing; after that, the
//! next process completes the moves. If a file cannot be moved, this process or the next one moves all files back.

use super::placed::PLACED;
use crate::error::Error;
use crate::file_name::{folded, is_plain};
use crate::store::{read_record, write_record};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

const FOLDER: &str = "commit";
/// The list of moves, inside the folder.
const LIST: &str = "list";
/// The list after a failure, when the moves are rolled back.
const BACK: &str = "back";
/// Subfolder of new files, under their own names.
const NEW: &str = "new";
/// Subfolder of replaced and removed files, under their own names.
const OLD: &str = "old";

/// Names of the files in the output folder that are written and removed.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Moves {
    write: Vec<String>,
    remove: Vec<String>,
}

/// A journal of moves that are not yet committed.
#[derive(Debug)]
pub(super) struct Journal {
    aside: PathBuf,
    moves: Moves,
}

impl Journal {
    /// Creates an empty journal. The caller holds the lock of the folder.
    pub(super) fn new(root: &Path) -> Self {
        Self { aside: root.join(FOLDER), moves: Moves::default() }
    }

    /// Returns true if a killed process left a list.
    pub(super) fn is_there(root: &Path) -> bool {
        [LIST, BACK].iter().any(|name| root.join(FOLDER).join(name).exists())
    }

    /// Writes a file aside, under its own name. Names that the file system rejects fail here, before any file moves.
    pub(super) fn write(&mut self, name: &str, bytes: &[u8]) -> std::io::Result<()> {
        let folder = self.aside.join(NEW);
        if self.moves.write.is_empty() {
            std::fs::create_dir_all(&folder)?;
        }
        std::fs::write(folder.join(name), bytes)?;
        self.moves.write.push(name.to_owned());
        Ok(())
    }

    /// Adds a file to remove.
    pub(super) fn remove(&mut self, name: &str) {
        self.moves.remove.push(name.to_owned());
    }

    /// Returns true if there are no moves.
    pub(super) fn is_empty(&self) -> bool {
        self.moves == Moves::default()
    }

    /// Commits the moves together with the record of the placed files, so that crash recovery also has the record.
    ///
    /// # Errors
    /// Returns an error at the first file that cannot be moved. The folder is unchanged then.
    pub(super) fn commit(self, folder: &Path, root: &Path, placed: &[u8]) -> Result<(), Error> {
        self.list(placed).map_err(|error| Error::write(self.aside.join(LIST), &error))?;
        Self::finish(folder, root)
    }

    /// Writes the list. From then on, the next process completes the moves if this one is killed.
    pub(super) fn list(&self, placed: &[u8]) -> std::io::Result<()> {
        std::fs::create_dir_all(self.aside.join(OLD))?;
        std::fs::write(self.aside.join(PLACED), placed)?;
        let begun = self.aside.join("list.new");
        std::fs::write(&begun, write_record(&self.moves))?;
        std::fs::rename(&begun, self.aside.join(LIST))
    }

    /// Completes the moves of a list, or the rollback of a failed list, and removes files that were written aside
    /// without a list. The caller holds the lock of the folder.
    ///
    /// # Errors
    /// Returns an error at the first file that cannot be moved, after moving all files back.
    pub(super) fn finish(folder: &Path, root: &Path) -> Result<(), Error> {
        let aside = root.join(FOLDER);
        let list = |name: &str| -> Option<Moves> { read_record(&aside.join(name)) };
        let result = match (list(BACK), list(LIST)) {
            (Some(moves), _) => take_back(folder, &aside, &moves),
            (None, Some(moves)) => match forward(folder, root, &aside, &moves) {
                Ok(()) => Ok(()),
                Err(error) => {
                    let back = aside.join(BACK);
                    std::fs::rename(aside.join(LIST), &back).map_err(|error| Error::write(&back, &error))?;
                    take_back(folder, &aside, &moves)?;
                    Err(error)
                }
            },
            // The list is damaged: restore the files that were moved aside for it.
            (None, None) => restore(folder, &aside.join(OLD)),
        };
        // Remove the list last: without it, the files in the old folder would be restored.
        for done in [aside.join(OLD), aside.join(NEW), aside] {
            match std::fs::remove_dir_all(&done) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    let text =
                        format!("{}: cannot remove: {error}; the files of the folder are in place", done.display());
                    return result.and(Err(Error::io(text)));
                }
                _ => {}
            }
        }
        result
    }
}

/// Completes the remaining moves of a list.
fn forward(folder: &Path, root: &Path, aside: &Path, moves: &Moves) -> Result<(), Error> {
    let (new, old) = (aside.join(NEW), aside.join(OLD));
    // On systems where names that differ only in case are one file, the old file is removed before the new one is
    // moved in. A name that has already been moved in must not be removed.
    let moved = |name: &&String| !new.join(name).exists();
    let arrived: BTreeSet<String> = moves.write.iter().filter(moved).map(|name| folded(name)).collect();
    for name in moves.remove.iter().filter(|name| is_plain(name) && !arrived.contains(&folded(name))) {
        step_aside(&folder.join(name), &old.join(name))?;
    }
    for name in moves.write.iter().filter(|name| is_plain(name)) {
        let (from, to) = (new.join(name), folder.join(name));
        // An earlier process moved it.
        if !from.exists() {
            continue;
        }
        step_aside(&to, &old.join(name))?;
        std::fs::rename(&from, &to).map_err(|error| Error::write(&to, &error))?;
    }
    let (from, to) = (aside.join(PLACED), root.join(PLACED));
    if from.exists() {
        std::fs::rename(&from, &to).map_err(|error| Error::write(&to, &error))?;
    }
    Ok(())
}

/// Moves an existing file out of the way. Folders are an error: they belong to the user.
fn step_aside(place: &Path, old: &Path) -> Result<(), Error> {
    let error = |error: std::io::Error| Error::write(place, &error);
    match place.symlink_metadata() {
        Err(found) if found.kind() == ErrorKind::NotFound => Ok(()),
        Err(found) => Err(error(found)),
        Ok(metadata) if metadata.is_dir() => Err(error(ErrorKind::IsADirectory.into())),
        Ok(_) => std::fs::rename(place, old).map_err(error),
    }
}

/// Rolls back: moves new files out and old files back in.
fn take_back(folder: &Path, aside: &Path, moves: &Moves) -> Result<(), Error> {
    let (new, old) = (aside.join(NEW), aside.join(OLD));
    let back = |from: PathBuf, to: PathBuf| match std::fs::rename(&from, &to) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::write(&to, &error)),
        _ => Ok(()),
    };
    for name in moves.write.iter().filter(|name| is_plain(name) && !new.join(name).exists()) {
        back(folder.join(name), new.join(name))?;
    }
    for name in moves.write.iter().chain(&moves.remove).filter(|name| is_plain(name)) {
        back(old.join(name), folder.join(name))?;
    }
    Ok(())
}

/// Moves old files back to their places where these are empty.
fn restore(folder: &Path, old: &Path) -> Result<(), Error> {
    for entry in std::fs::read_dir(old).into_iter().flatten().flatten() {
        let place = folder.join(entry.file_name());
        if place.symlink_metadata().is_err() {
            std::fs::rename(entry.path(), &place).map_err(|error| Error::write(&place, &error))?;
        }
    }
    Ok(())
}

impl Drop for Journal {
    /// Removes the files written aside after an error, unless there is a list for the next process to complete.
    fn drop(&mut self) {
        if !self.aside.join(LIST).exists() && !self.aside.join(BACK).exists() {
            let _ = std::fs::remove_dir_all(&self.aside);
        }
    }
}
