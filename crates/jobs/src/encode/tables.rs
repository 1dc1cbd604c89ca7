//! Tables of sources that were made before: another ratio needs no other table.

use brdfc_source::{Source, Tally};
use brdfc_wavelet::table::Grid;
use brdfc_wavelet::tabulated::Tabulated;

/// Where tables of one source are kept.
pub trait TableShelf {
    /// The values of a table, and what was mended in it.
    fn take(&self, grid: Grid) -> Option<(Vec<u8>, Tally)>;
    /// Keeps them.
    fn put(&self, grid: Grid, values: Vec<u8>, tally: &Tally);
}

/// Keeps none.
impl TableShelf for () {
    fn take(&self, _: Grid) -> Option<(Vec<u8>, Tally)> {
        None
    }

    fn put(&self, _: Grid, _: Vec<u8>, _: &Tally) {}
}

/// The table of a source: from the shelf, or made and kept there.
pub(super) fn tabulated(source: &dyn Source, grid: Grid, shelf: &dyn TableShelf) -> Tabulated {
    let kept = shelf.take(grid).and_then(|(values, tally)| Tabulated::from_bytes(source, grid, &values, tally));
    kept.unwrap_or_else(|| {
        let made = Tabulated::new(source, grid);
        shelf.put(grid, made.to_bytes(), &made.tally);
        made
    })
}
