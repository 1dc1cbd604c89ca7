//! Errors and limits of the parameterisation.

use brdfc_core::progress::Cancelled;
/// Drift at which the iteration for the tilt stops, in tiles.
pub(super) const DRIFT_LIMIT: f64 = 1e-12;
/// Largest residual of the linear system, in tiles.
pub const RESIDUAL_LIMIT: f64 = 1e-9;
/// Maximum number of vertices of a surface.
pub const MAX_VERTICES: usize = 1 << 20;

/// Errors of the parameterisation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameteriseError {
    /// The linear system has no usable solution.
    #[error("parameterisation: found a residual of {found:e} tiles, expected at most {RESIDUAL_LIMIT:e}")]
    Residual {
        /// Largest residual, in tiles.
        found: f64,
    },
    /// The linear system cannot be solved.
    #[error("parameterisation: the linear system cannot be solved: {reason}")]
    Singular {
        /// Message of the solver.
        reason: String,
    },
    /// No tilt cancels the drift.
    #[error(
        "parameterisation: found a drift of {found:e} tiles per step under the best tilt, expected at most \
         {DRIFT_LIMIT:e}; angles of triangles may be too thin"
    )]
    Drift {
        /// Remaining drift, in tiles per step.
        found: f64,
    },
    /// More vertices than can be parameterised in reasonable time.
    #[error("vertices: found {found}, expected at most {MAX_VERTICES}")]
    TooLarge {
        /// Number of vertices of the mesh.
        found: usize,
    },
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Triangles are flipped: angles so thin that arithmetic fails.
    #[error(
        "parameterisation: {count} flipped triangles, the first at ({:.4}, {:.4}, {:.4}); angles of triangles may be \
         too thin",
        .at[0], .at[1], .at[2]
    )]
    Flipped {
        /// Number of flipped triangles.
        count: usize,
        /// A corner of the first, in tiles.
        at: [f64; 3],
    },
}
