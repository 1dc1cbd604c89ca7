//! Grids of sources in the store of a build: where a ratio changes, or bits, nothing is evaluated again.

use crate::encode::GridCache;
use crate::store::{Digest, Kept, Key, Store};
use brdfc_core::Tally;
use std::collections::BTreeSet;

/// The grids of a source, in the store.
pub(super) struct StoreGridCache<'a> {
    pub(super) store: &'a Store,
    pub(super) source: Digest,
}

impl StoreGridCache<'_> {
    fn key(&self, name: &str) -> Key {
        Key::new("grid", self.source, &name)
    }
}

impl GridCache for StoreGridCache<'_> {
    fn take(&self, name: &str) -> Option<(Vec<u8>, Tally)> {
        let Kept { report, files } = self.store.look_up(&self.key(name), &BTreeSet::new())?;
        Some((self.store.object(files.first()?)?, report))
    }

    fn put(&self, name: &str, values: &dyn Fn() -> Vec<u8>, tally: &Tally) {
        // What cannot be stored is made again.
        let _ = self.store.keep(self.key(name), &[values()], tally);
    }
}
