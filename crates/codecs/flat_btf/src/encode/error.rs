//! Why flattening fails.

use crate::factored::FactorError;
use crate::parameterise::ParameteriseError;
use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;

/// Why there is no flat BTF. `E` is the error of what the caller gave: scratch storage, images.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError<E> {
    /// The surface cannot be laid flat.
    #[error(transparent)]
    Parameterise(ParameteriseError),
    /// A recipe that cannot be followed, or values that the layout cannot hold.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Scratch storage or images failed.
    #[error("{0}")]
    Outside(E),
    /// The work was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl<E> From<ParameteriseError> for EncodeError<E> {
    fn from(error: ParameteriseError) -> Self {
        match error {
            ParameteriseError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Parameterise(other),
        }
    }
}

impl<E> From<FactorError<Self>> for EncodeError<E> {
    fn from(error: FactorError<Self>) -> Self {
        match error {
            FactorError::View(error) => error,
            FactorError::Format(error) => error.into(),
            FactorError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}
