//! What builds put into a folder.

use crate::file_name::is_plain;
use crate::store::{Digest, Stamp};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

/// The record of them, beside the store.
pub(super) const PLACED: &str = "placed";

/// A file that a build put in place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Placed {
    /// Of its bytes.
    pub(super) digest: Digest,
    /// By which it is known to be unchanged without being read.
    pub(super) stamp: Option<Stamp>,
}

/// Files by name.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Placements {
    pub(super) files: BTreeMap<String, Placed>,
}

impl Placements {
    /// Adds files that have these hashes and are not known, or by others.
    pub(super) fn also(&mut self, folder: &Path, listed: impl IntoIterator<Item = (String, Digest)>) {
        for (name, digest) in listed {
            let placed = Placed { digest, stamp: None };
            let is_known = self.files.get(&name).is_some_and(|known| known.digest == digest);
            if is_plain(&name) && !is_known && stamp_if_unchanged(folder, &name, &placed).is_some() {
                self.files.insert(name, placed);
            }
        }
    }

    /// Those that are unchanged, with the stamps by which they are known the next time.
    pub(super) fn verified(&self, folder: &Path) -> BTreeMap<String, Placed> {
        let now = SystemTime::now();
        let there = |(name, placed): (&String, &Placed)| {
            let stamp = stamp_if_unchanged(folder, name, placed)?;
            let stamp = Some(stamp).filter(|stamp| stamp.is_settled(now));
            Some((name.clone(), Placed { digest: placed.digest, stamp }))
        };
        self.files.iter().filter_map(there).collect()
    }

    /// Notes how files are known again that were just put in place.
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

/// What the file system says of a file that is still as it was put in place.
fn stamp_if_unchanged(folder: &Path, name: &str, placed: &Placed) -> Option<Stamp> {
    let path = folder.join(name);
    let stamp = Stamp::of(&path.symlink_metadata().ok()?)?;
    let unchanged =
        placed.stamp == Some(stamp) || std::fs::read(&path).is_ok_and(|bytes| Digest::of(&bytes) == placed.digest);
    unchanged.then_some(stamp)
}
