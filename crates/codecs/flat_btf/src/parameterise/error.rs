//! Why a surface cannot be laid flat, and the limits that say so.

use brdfc_core::progress::Cancelled;
/// Drift at which the tilt is found, in tiles.
pub(super) const DRIFT_LIMIT: f64 = 1e-12;
/// Largest residual of the linear system, in tiles.
pub const RESIDUAL_LIMIT: f64 = 1e-9;
/// Most vertices of a surface.
pub const MAX_VERTICES: usize = 1 << 20;

/// Why a surface cannot be laid flat.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameteriseError {
    /// The linear system has no usable solution.
    #[error("parameterisation: found a residual of {found:e} tiles, expected at most {RESIDUAL_LIMIT:e}")]
    Residual {
        /// Residual.
        found: f64,
    },
    /// The solver gave up.
    #[error("parameterisation: the linear system cannot be solved: {reason}")]
    Singular {
        /// What the solver says.
        reason: String,
    },
    /// No tilt was found that stops the drift.
    #[error(
        "parameterisation: found weights that drift by {found:e} tiles a step whatever their tilt, expected at most \
         {DRIFT_LIMIT:e} (angles may be too thin)"
    )]
    Drift {
        /// The drift that is left.
        found: f64,
    },
    /// More vertices than can be laid flat in a reasonable time.
    #[error("vertices: found {found}, expected at most {MAX_VERTICES}")]
    TooLarge {
        /// How many.
        found: usize,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Triangles lie upside down: angles so thin that arithmetic fails.
    #[error(
        "parameterisation: found {count} flipped triangles, the first at ({:.4}, {:.4}, {:.4}), expected none (its \
         angles may be too thin)",
        .at[0], .at[1], .at[2]
    )]
    Flipped {
        /// How many.
        count: usize,
        /// A corner of the first, in tiles.
        at: [f64; 3],
    },
}
