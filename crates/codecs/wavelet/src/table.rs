//! The table: a source on the 4D grid, stored once per mirror orbit of outer cells.

use super::fold::Fold;
use brdfc_formats::direction::Parameterisation;
use ndarray::Array3;

/// Size and parameterisation of the two hemispheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Parameterisation of the hemispheres.
    pub parameterisation: Parameterisation,
    /// `N`: `2^N x 2^N` cells per hemisphere, 1 to 6.
    pub levels: u32,
}

impl Grid {
    /// Number of cells per axis.
    pub fn n(self) -> usize {
        1 << self.levels
    }

    /// Number of cells per hemisphere.
    pub fn cells(self) -> usize {
        self.n() * self.n()
    }
}

/// Values over `[outer][inner][channel]`, folded by mirror symmetry along the outer axis.
#[derive(Debug, Clone)]
pub struct Table {
    /// Grid of directions that the values are at.
    pub grid: Grid,
    /// Stored outer cells, and the map from the others to them.
    pub fold: Fold,
    /// `[channel][row][inner cell]`: 1 or 3 channels, `fold.rows().len()` rows, `grid.cells()` inner cells.
    pub values: Array3<f32>,
}

impl Table {
    /// Number of stored channels: 1 or 3.
    pub fn channels(&self) -> usize {
        self.values.dim().0
    }

    /// All inner cells of a stored row, for one channel.
    pub fn row(&self, channel: usize, row: usize) -> &[f32] {
        let (_, rows, cells) = self.values.dim();
        let all = self.values.as_slice().expect("tables are stored in standard layout");
        &all[(channel * rows + row) * cells..][..cells]
    }

    /// Mean of all samples of all channels, in f64. Rows of the fundamental domain have equal weight, so the mean over
    /// the stored rows is the mean over the whole grid.
    pub fn mean(&self) -> f64 {
        let (channels, rows, _) = self.values.dim();
        let mut sum = 0.0;
        for channel in 0..channels {
            for row in 0..rows {
                sum += self.row(channel, row).iter().map(|v| f64::from(*v)).sum::<f64>();
            }
        }
        sum / self.values.len() as f64
    }
}
