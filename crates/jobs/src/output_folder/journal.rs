//! Many files that change places as one: written aside under their names, listed, then moved. Who is killed before the list stands
//! has changed nothing; what is listed is moved by whoever comes next. Where a file cannot be moved, all that were are moved back,
//! by this process or the next.

use super::placed::PLACED;
use crate::error::Error;
use crate::file_name::{folded, is_plain};
use crate::store::{read_record, write_record};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

const FOLDER: &str = "commit";
/// Inside it: what is to be done; its name once it is to be taken back.
const LIST: &str = "list";
const BACK: &str = "back";
/// Files that come, and those that stood in their places or go, under their names.
const NEW: &str = "new";
const OLD: &str = "old";

/// What is to be done, by the names of files in the output folder.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Moves {
    write: Vec<String>,
    remove: Vec<String>,
}

/// Moves that are being gathered.
#[derive(Debug)]
pub(super) struct Journal {
    aside: PathBuf,
    moves: Moves,
}

impl Journal {
    /// An empty one. The caller holds the folder's lock.
    pub(super) fn new(root: &Path) -> Self {
        Self { aside: root.join(FOLDER), moves: Moves::default() }
    }

    pub(super) fn is_there(root: &Path) -> bool {
        [LIST, BACK].iter().any(|name| root.join(FOLDER).join(name).exists())
    }

    /// Writes a file aside, under its own name: what the file system does not take is refused before anything moves.
    pub(super) fn write(&mut self, name: &str, bytes: &[u8]) -> std::io::Result<()> {
        let folder = self.aside.join(NEW);
        if self.moves.write.is_empty() {
            std::fs::create_dir_all(&folder)?;
        }
        std::fs::write(folder.join(name), bytes)?;
        self.moves.write.push(name.to_owned());
        Ok(())
    }

    /// A file will be removed.
    pub(super) fn remove(&mut self, name: &str) {
        self.moves.remove.push(name.to_owned());
    }

    /// Whether nothing is to be done.
    pub(super) fn is_empty(&self) -> bool {
        self.moves == Moves::default()
    }

    /// Does it all, and puts the record of what is placed then in place with it: whoever finishes it knows what is ours.
    ///
    /// # Errors
    /// The first file that cannot be moved: then nothing has changed.
    pub(super) fn commit(self, folder: &Path, root: &Path, placed: &[u8]) -> Result<(), Error> {
        self.list(placed).map_err(|error| Error::write(self.aside.join(LIST), &error))?;
        Self::finish(folder, root)
    }

    /// Writes the list: from then on whoever comes next does what it says.
    pub(super) fn list(&self, placed: &[u8]) -> std::io::Result<()> {
        std::fs::create_dir_all(self.aside.join(OLD))?;
        std::fs::write(self.aside.join(PLACED), placed)?;
        let begun = self.aside.join("list.new");
        std::fs::write(&begun, write_record(&self.moves))?;
        std::fs::rename(&begun, self.aside.join(LIST))
    }

    /// Does what a list says that somebody left, or takes it back where that was begun, and removes what was written aside without
    /// one. The caller holds the folder's lock.
    ///
    /// # Errors
    /// The first file that cannot be moved. Then all are moved back.
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
            // A list that cannot be read any more: what stood aside for it comes back.
            (None, None) => come_back(folder, &aside.join(OLD)),
        };
        // The list last: without one, what stands aside would be taken for lost.
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

/// Moves files to where they belong, as far as that was not done before.
fn forward(folder: &Path, root: &Path, aside: &Path, moves: &Moves) -> Result<(), Error> {
    let (new, old) = (aside.join(NEW), aside.join(OLD));
    // Where two names that differ in case alone are one file, the old one is to go before the new one comes; where that was done
    // before, the new one is there.
    let moved = |name: &&String| !new.join(name).exists();
    let come: BTreeSet<String> = moves.write.iter().filter(moved).map(|name| folded(name)).collect();
    for name in moves.remove.iter().filter(|name| is_plain(name) && !come.contains(&folded(name))) {
        step_aside(&folder.join(name), &old.join(name))?;
    }
    for name in moves.write.iter().filter(|name| is_plain(name)) {
        let (from, to) = (new.join(name), folder.join(name));
        // It was moved before.
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

/// Moves what stands in a place out of it, if anything does. Folders stay: they are nobody's but the user's.
fn step_aside(place: &Path, old: &Path) -> Result<(), Error> {
    let error = |error: std::io::Error| Error::write(place, &error);
    match place.symlink_metadata() {
        Err(found) if found.kind() == ErrorKind::NotFound => Ok(()),
        Err(found) => Err(error(found)),
        Ok(metadata) if metadata.is_dir() => Err(error(ErrorKind::IsADirectory.into())),
        Ok(_) => std::fs::rename(place, old).map_err(error),
    }
}

/// Moves files back that came, and those that had gone.
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

/// Moves files back whose places are empty.
fn come_back(folder: &Path, old: &Path) -> Result<(), Error> {
    for entry in std::fs::read_dir(old).into_iter().flatten().flatten() {
        let place = folder.join(entry.file_name());
        if place.symlink_metadata().is_err() {
            std::fs::rename(entry.path(), &place).map_err(|error| Error::write(&place, &error))?;
        }
    }
    Ok(())
}

impl Drop for Journal {
    /// After an error nothing is left aside. A list that stands is somebody's to finish.
    fn drop(&mut self) {
        if !self.aside.join(LIST).exists() && !self.aside.join(BACK).exists() {
            let _ = std::fs::remove_dir_all(&self.aside);
        }
    }
}
