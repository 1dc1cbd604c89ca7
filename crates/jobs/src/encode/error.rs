//! Why there is no pack.

use brdfc_core::progress::Cancelled;
use brdfc_formats::crop::DirectionRange;

/// Why there is no pack.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PackError {
    /// The encoder of wavelet packs.
    #[error(transparent)]
    Wavelet(brdfc_wavelet::encode::EncodeError),
    /// The encoder of table packs.
    #[error(transparent)]
    Table(brdfc_table::encode::EncodeError),
    /// An error budget for a black material.
    #[error(
        "error budget: found a material that is black everywhere; allowed one with reflectance, or the budget says \
         nothing"
    )]
    NothingMeasured,
    /// No codec is that cheap to look up.
    #[error(
        "fetch budget: found {allowed}; allowed at least {fewest}, which is what is asked for needs: 1 for an isotropic table, 2 for others, 1 more with a curve or levels"
    )]
    TooFewFetches {
        /// The budget.
        allowed: u32,
        /// Fewest that any codec has.
        fewest: u32,
    },
    /// A pack that is for other directions.
    #[error(
        "directions: found a pack for {has}, as a source; allowed one that has some of those that are needed: {needed}"
    )]
    OtherDirections {
        /// What the source is for.
        has: DirectionRange,
        /// What is needed.
        needed: DirectionRange,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<brdfc_wavelet::encode::EncodeError> for PackError {
    fn from(error: brdfc_wavelet::encode::EncodeError) -> Self {
        match error {
            brdfc_wavelet::encode::EncodeError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Wavelet(other),
        }
    }
}

impl From<brdfc_table::encode::EncodeError> for PackError {
    fn from(error: brdfc_table::encode::EncodeError) -> Self {
        match error {
            brdfc_table::encode::EncodeError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Table(other),
        }
    }
}
