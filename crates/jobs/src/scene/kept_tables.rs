//! Tables of sources in the store of a build: where a ratio changes, or bits, nothing is evaluated again.

use crate::encode::TableShelf;
use crate::store::{Digest, Kept, Key, Store};
use brdfc_core::Tally;
use brdfc_wavelet::table::Grid;
use brdfc_wavelet::tabulated::Tabulated;
use std::collections::BTreeSet;

/// The tables of a source, in the store.
pub(super) struct KeptTables<'a> {
    pub(super) store: &'a Store,
    pub(super) source: Digest,
}

impl KeptTables<'_> {
    fn key(&self, grid: Grid) -> Key {
        Key::new("table", self.source, &(grid.parameterisation, grid.levels))
    }
}

impl TableShelf for KeptTables<'_> {
    fn take(&self, grid: Grid) -> Option<(Vec<u8>, Tally)> {
        let Kept { report, files } = self.store.look_up(&self.key(grid), &BTreeSet::new())?;
        Some((self.store.object(files.first()?)?, report))
    }

    fn put(&self, table: &Tabulated) {
        // Where it cannot be kept it is made again.
        let _ = self.store.keep(self.key(table.table.grid), &[table.to_bytes()], &table.tally);
    }
}
