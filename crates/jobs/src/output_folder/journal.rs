//! Many files that change places as one: written aside, listed, then moved. Who is killed before the list stands has changed
//! nothing; what is listed is moved by whoever comes next.

use super::placed::PLACED;
use crate::error::Error;
use crate::store::{read_record, write_record};
use crate::write::is_plain;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

const FOLDER: &str = "commit";
const LIST: &str = "list";

/// What is to be done, by the names of files in the output folder.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Moves {
    /// The k-th stands aside under the name k.
    write: Vec<String>,
    remove: Vec<String>,
}

/// Moves that are being gathered.
#[derive(Debug)]
pub(super) struct Journal {
    folder: PathBuf,
    moves: Moves,
}

impl Journal {
    /// An empty one. The caller holds the folder's lock.
    pub(super) fn new(root: &Path) -> Self {
        Self { folder: root.join(FOLDER), moves: Moves::default() }
    }

    pub(super) fn is_there(root: &Path) -> bool {
        root.join(FOLDER).join(LIST).exists()
    }

    /// Writes a file aside.
    pub(super) fn write(&mut self, name: &str, bytes: &[u8]) -> std::io::Result<()> {
        if self.moves.write.is_empty() {
            std::fs::create_dir_all(&self.folder)?;
        }
        std::fs::write(self.folder.join(self.moves.write.len().to_string()), bytes)?;
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
    pub(super) fn commit(self, folder: &Path, root: &Path, placed: &[u8]) -> Result<(), Error> {
        let list = self.folder.join(LIST);
        let error = |error: std::io::Error| Error::write(&list, &error);
        std::fs::create_dir_all(&self.folder).map_err(error)?;
        std::fs::write(self.folder.join(PLACED), placed).map_err(error)?;
        let aside = self.folder.join("list.new");
        std::fs::write(&aside, write_record(&self.moves)).map_err(error)?;
        std::fs::rename(&aside, &list).map_err(error)?;
        Self::finish(folder, root)
    }

    /// Does what a list says that somebody left, and removes what was written aside without one. The caller holds the
    /// folder's lock.
    pub(super) fn finish(folder: &Path, root: &Path) -> Result<(), Error> {
        let aside = root.join(FOLDER);
        let moves: Moves = read_record(&aside.join(LIST)).unwrap_or_default();
        // Where two names that differ in case alone are one file, the old one is to go before the new one comes; where that was
        // done before, the new one is there.
        let moved = |number: &usize| !aside.join(number.to_string()).exists();
        let is_new = |name: &str| {
            let same = |(_, new): &(usize, &String)| new.eq_ignore_ascii_case(name);
            moves.write.iter().enumerate().filter(same).any(|(number, _)| moved(&number))
        };
        for name in moves.remove.iter().filter(|name| is_plain(name) && !is_new(name)) {
            let path = folder.join(name);
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(Error::write(&path, &error)),
                _ => {}
            }
        }
        for (number, name) in moves.write.iter().enumerate().filter(|(_, name)| is_plain(name)) {
            let (from, to) = (aside.join(number.to_string()), folder.join(name));
            match std::fs::rename(&from, &to) {
                // It was moved before.
                Err(error) if error.kind() == std::io::ErrorKind::NotFound && !from.exists() => {}
                moved => moved.map_err(|error| Error::write(&to, &error))?,
            }
        }
        let (from, to) = (aside.join(PLACED), root.join(PLACED));
        if moves != Moves::default() && from.exists() {
            std::fs::rename(&from, &to).map_err(|error| Error::write(&to, &error))?;
        }
        match std::fs::remove_dir_all(&aside) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::write(&aside, &error)),
            _ => Ok(()),
        }
    }
}

impl Drop for Journal {
    /// After an error nothing is left aside. A list that stands is somebody's to finish.
    fn drop(&mut self) {
        if !self.folder.join(LIST).exists() {
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}
