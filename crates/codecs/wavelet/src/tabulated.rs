//! A source on a grid, the common input of packs of all ratios, bits and rankings.

use super::fold::Fold;
use super::resample::resample;
use super::table::{Grid, Table};
use brdfc_core::{Source, Tally};
use ndarray::Array3;

/// A table with the repairs made in it.
#[derive(Debug, Clone)]
pub struct Tabulated {
    /// Table of values at the grid's directions.
    pub table: Table,
    /// Counts of repairs in the source's values.
    pub tally: Tally,
}

impl Tabulated {
    /// Evaluates a source at every cell, which is most of the work of encoding a scan.
    pub fn new(source: &dyn Source, grid: Grid) -> Self {
        let (table, tally) = resample(source, grid);
        Self { table, tally }
    }

    /// All values, little-endian f32: `[channel][row][inner cell]`.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.table.values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    /// Restores the table of a source from [`Self::to_bytes`]; `None` if the number of values differs.
    pub fn from_bytes(source: &dyn Source, grid: Grid, bytes: &[u8], tally: Tally) -> Option<Self> {
        let channels = if source.is_grey() { 1 } else { 3 };
        let fold = Fold::new(grid.n(), grid.parameterisation, source.symmetry());
        let (values, []) = bytes.as_chunks::<4>() else { return None };
        let values = values.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let values = Array3::from_shape_vec((channels, fold.rows().len(), grid.cells()), values).ok()?;
        Some(Self { table: Table { grid, fold, values }, tally })
    }
}
