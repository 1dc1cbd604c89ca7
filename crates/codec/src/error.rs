//! Encoding errors.

use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_formats::crop::DirectionRange;

/// Why a source did not become a pack.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EncodeError {
    /// An error budget that the codec cannot meet.
    #[error("error budget: found {:.4} % relative error with {best}, expected {} %", 100.0 * found, 100.0 * allowed)]
    BudgetMissed {
        /// The smallest `ε_r`, a fraction.
        found: f64,
        /// The budget.
        allowed: f64,
        /// How it was reached.
        best: String,
    },
    /// A limit of error that was asked of a black material, of which nothing is measured.
    #[error(
        "error budget: found a material that is black everywhere, expected one with reflectance, or the budget says \
         nothing"
    )]
    NothingMeasured,
    /// A byte budget below the smallest pack of the codec.
    #[error("{field}: found {allowed} bytes, expected at least {smallest}, which hold {what}")]
    TooFewBytes {
        /// Which budget.
        field: &'static str,
        /// The budget.
        allowed: u64,
        /// Bytes of the smallest pack.
        smallest: u64,
        /// What the smallest pack is.
        what: &'static str,
    },
    /// A fetch budget below that of any pack.
    #[error("fetch budget: found {allowed}, expected at least {fewest}, which is what is asked for needs: {why}")]
    TooFewFetches {
        /// The budget.
        allowed: u32,
        /// Fewest that any pack has.
        fewest: u32,
        /// What these are for, in words.
        why: &'static str,
    },
    /// A size that no pack has, asked for by an option.
    #[error("{field}: found {found}, expected {allowed}")]
    Size {
        /// Of what.
        field: &'static str,
        /// The size.
        found: String,
        /// What it may be.
        allowed: String,
    },
    /// A source that is a pack for other directions.
    #[error(
        "directions: found a pack for {has}, as a source, expected one that has some of those that are needed: {needed}"
    )]
    OtherDirections {
        /// Directions of the source.
        has: DirectionRange,
        /// Directions that are needed.
        needed: DirectionRange,
    },
    /// A pack that breaks the rules of its own layout.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
