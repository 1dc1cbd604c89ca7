//! Encoding errors.

use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_formats::crop::DirectionRange;

/// Reason why a source did not become a pack.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EncodeError {
    /// Error budget that the codec cannot meet.
    #[error("error budget: found {:.4} % relative error with {best}, expected {} %", 100.0 * found, 100.0 * allowed)]
    BudgetMissed {
        /// The smallest `ε_r`, a fraction.
        found: f64,
        /// The budget.
        allowed: f64,
        /// Settings that reached it.
        best: String,
    },
    /// Error limit for a black material, where no error can be measured.
    #[error(
        "error budget: found a material that is black everywhere, expected one with reflectance, or no \
         limit of error"
    )]
    NothingMeasured,
    /// Byte budget below the smallest pack of the codec.
    #[error("{field}: found {allowed} bytes, expected at least {smallest}, the size of {what}")]
    TooFewBytes {
        /// Name of the budget.
        field: &'static str,
        /// The budget.
        allowed: u64,
        /// Bytes of the smallest pack.
        smallest: u64,
        /// Contents of the smallest pack.
        what: &'static str,
    },
    /// Fetch budget below that of any pack.
    #[error("fetch budget: found {allowed}, expected at least {fewest}: {why}")]
    TooFewFetches {
        /// The budget.
        allowed: u32,
        /// Minimum over all packs of the request.
        fewest: u32,
        /// Reason for the minimum.
        why: &'static str,
    },
    /// Invalid size in an option.
    #[error("{field}: found {found}, expected {allowed}")]
    Size {
        /// Name of the option.
        field: &'static str,
        /// The size.
        found: String,
        /// Valid sizes.
        allowed: String,
    },
    /// Source pack for other directions.
    #[error("directions: found a source pack for {has}, expected one that overlaps the requested {needed}")]
    OtherDirections {
        /// Directions of the source.
        has: DirectionRange,
        /// Requested directions.
        needed: DirectionRange,
    },
    /// Pack that breaks the rules of its own layout.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Cancellation by the caller.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
