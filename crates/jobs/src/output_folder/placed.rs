//! Records of the files that builds put into a folder.

use crate::file_name::is_plain;
use crate::store::{Digest, Stamp};
use brdfc_source::read::{MAX_FILE_BYTES, read_regular_file};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

/// File name of the record, in the folder of the store.
pub(super) const PLACED: &str = "placed";

/// A file that a build put in place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Placed {
    /// Hash of its bytes.
    pub(super) digest: Digest,
    /// Stamp by which the unchanged file is recognised without reading it.
    pub(super) stamp: Option<Stamp>,
}

/// Placed files, by name.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Placements {
    pub(super) files: BTreeMap<String, Placed>,
}

impl Placements {
    /// Adds files, and updates the hashes of recorded files, if the contents have the listed hashes.
    pub(super) fn also(&mut self, folder: &Path, listed: impl IntoIterator<Item = (String, Digest)>) {
        for (name, digest) in listed {
            let placed = Placed { digest, stamp: None };
            let is_known = self.files.get(&name).is_some_and(|known| known.digest == digest);
            if is_plain(&name) && !is_known && stamp_if_unchanged(folder, &name, &placed).is_some() {
                self.files.insert(name, placed);
            }
        }
    }

    /// The unchanged files, with their current stamps.
    pub(super) fn verified(&self, folder: &Path) -> BTreeMap<String, Placed> {
        let now = SystemTime::now();
        let there = |(name, placed): (&String, &Placed)| {
            let stamp = stamp_if_unchanged(folder, name, placed)?;
            let stamp = Some(stamp).filter(|stamp| stamp.is_settled(now));
            Some((name.clone(), Placed { digest: placed.digest, stamp }))
        };
        self.files.iter().filter_map(there).collect()
    }

    /// Records the stamps of files that were just put in place.
    pub(super) fn stamp(&mut self, folder: &Path) {
        let now = SystemTime::now();
        for (name, placed) in &mut self.files {
            if placed.stamp.is_none() {
                let stamp = std::fs::metadata(folder.join(name)).ok().and_then(|metadata| Stamp::of(&metadata));
                placed.stamp = stamp.filter(|stamp| stamp.is_settled(now));
            }
        }
    }
}

/// Returns the current stamp of a file if its contents are unchanged.
fn stamp_if_unchanged(folder: &Path, name: &str, placed: &Placed) -> Option<Stamp> {
    let path = folder.join(name);
    let stamp = Stamp::of(&path.symlink_metadata().ok()?)?;
    let unchanged = placed.stamp == Some(stamp)
        || read_regular_file(&path, MAX_FILE_BYTES).is_ok_and(|bytes| Digest::of(&bytes) == placed.digest);
    unchanged.then_some(stamp)
}
