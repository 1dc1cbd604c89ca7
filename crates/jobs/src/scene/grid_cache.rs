//! Sampled grids in the store of a build. A new ratio or number of bits reuses the grid of the source.

use crate::encode::GridCache;
use crate::store::{Cached, Digest, Key, Store};
use brdfc_core::Tally;
use std::collections::BTreeSet;

/// Cache of the grids of one source, in the store.
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
        let Cached { report, files } = self.store.look_up(&self.key(name), &BTreeSet::new())?;
        Some((self.store.object(files.first()?)?, report))
    }

    fn put(&self, name: &str, values: &dyn Fn() -> Vec<u8>, tally: &Tally) {
        // Without a cached grid, the next build evaluates the source again.
        let _ = self.store.keep(self.key(name), &[values()], tally);
    }
}
