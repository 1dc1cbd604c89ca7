//! Sparse Cholesky factorisation `A = L Lᵀ` of symmetric positive definite matrices.
//!
//! Rows are eliminated in an order that keeps `L` sparse (Amestoy, Davis and Duff 1996, "An approximate minimum degree
//! ordering algorithm"). Columns of `L` with the same rows below them form a node, and each node is a small dense
//! factorisation, whose remainder is added to its parent in the tree of nodes: the multifrontal method (Duff and Reid
//! 1983, "The multifrontal solution of indefinite sparse symmetric linear equations"; Liu 1992, "The multifrontal
//! method for sparse matrix solution: theory and practice"). Notation follows Davis 2006, "Direct methods for sparse
//! linear systems", chapter 4.
//!
//! Summation order does not depend on the number of threads, and no instruction is selected by processor features:
//! results are the same everywhere.

use brdfc_core::progress::Cancelled;
mod elimination;
mod factor;
mod front;
mod nodes;
mod solve;
mod symbolic;
#[cfg(test)]
mod tests;

pub use factor::Cholesky;
pub use symbolic::Symbolic;

/// Errors of analysis and factorisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FactorError {
    /// A pivot is not above 0, or not finite.
    #[error("the matrix is not positive definite (row {row})")]
    NotPositiveDefinite {
        /// The row of the pivot.
        row: usize,
    },
    /// The matrix or its factor exceeds the index range or the memory.
    #[error("the factor of a matrix of {rows} rows is too large")]
    TooLarge {
        /// Rows of the matrix.
        rows: usize,
    },
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Rows of a tile of the factor: a column of a tile is the unit of storage and arithmetic.
const TILE: usize = 4;

/// A column of a tile.
type Lane = [f64; TILE];

/// Marks a missing node or row.
const NONE: u32 = u32::MAX;
