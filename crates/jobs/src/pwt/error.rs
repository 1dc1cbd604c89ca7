//! Why a tree was not made.

use brdfc_formats::FormatError;
use brdfc_source::InputError;

/// Why a tree was not made.
#[derive(Debug, thiserror::Error)]
pub enum PwtError {
    /// What cannot be read, or is not as it should be.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Photographs or options out of range.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Options that do not go together.
    #[error("{0}")]
    Usage(String),
    /// A flat BTF that is not whole.
    #[error(transparent)]
    Flatten(#[from] crate::flatten::FlattenError),
}
