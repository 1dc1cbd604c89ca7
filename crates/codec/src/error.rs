//! Encoding errors.

use super::Message;
use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_formats::crop::DirectionRange;

/// Reason why a source did not become a pack. Messages name an option by its key in a manifest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EncodeError {
    /// Limit of the relative error that the codec cannot meet.
    #[error("max_error: found ε_r {:.4} % with {best}, expected at most {} %", 100.0 * found, 100.0 * allowed)]
    BudgetMissed {
        /// The smallest `ε_r`, a fraction.
        found: f64,
        /// The limit, a fraction.
        allowed: f64,
        /// Settings of the pack with this error.
        best: String,
    },
    /// Error limit for a black material, whose errors cannot be measured.
    #[error("the material is black everywhere, so that no error can be measured; remove the limit of the error")]
    NothingMeasured,
    /// Limit of bytes below the smallest pack of the codec.
    #[error("max_bytes: found {allowed} bytes, expected at least {smallest}, the smallest pack")]
    TooFewBytes {
        /// Maximum bytes on a GPU that the caller allowed.
        allowed: u64,
        /// Bytes on a GPU of the smallest pack.
        smallest: u64,
    },
    /// Limit of fetches that no pack meets.
    #[error("max_fetches: found {allowed}, expected at least {fewest}; {why}")]
    TooFewFetches {
        /// Maximum texture fetches per look-up that the caller allowed.
        allowed: u32,
        /// Minimum number of fetches over all packs of the request.
        fewest: u32,
        /// Reason for the minimum.
        why: &'static str,
    },
    /// Invalid size in an option.
    #[error("{field}: found {found}, expected {allowed}")]
    Size {
        /// Name of the option.
        field: &'static str,
        /// Value of the option, as the message shows it.
        found: String,
        /// Range or list of valid values.
        allowed: String,
    },
    /// Source pack for other directions.
    #[error("directions: found a source pack for {has}, expected an overlap with the requested {needed}")]
    OtherDirections {
        /// Directions of the source.
        has: DirectionRange,
        /// Directions that the requested pack would cover.
        needed: DirectionRange,
    },
    /// Pack that breaks the rules of its own layout.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Cancellation by the caller.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl EncodeError {
    /// The message with the position of its key, if it concerns an option.
    pub fn message(&self) -> Message {
        let key = match self {
            Self::BudgetMissed { .. } => "max_error",
            Self::TooFewBytes { .. } => "max_bytes",
            Self::TooFewFetches { .. } => "max_fetches",
            Self::Size { field, .. } => field,
            _ => "",
        };
        let text = self.to_string();
        match text.strip_prefix(key) {
            Some(rest) if !key.is_empty() => Message::default().with_key(key).with_text(rest),
            _ => text.into(),
        }
    }
}
