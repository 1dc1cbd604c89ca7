//! Errors of flattening.

use crate::factored::FactorError;
use crate::parameterise::ParameteriseError;
use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;

/// Encoding errors. `E` is the error type of the caller's scratch storage and images.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError<E> {
    /// The surface cannot be parameterised.
    #[error(transparent)]
    Parameterise(ParameteriseError),
    /// An invalid recipe, or values that the layout cannot hold.
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
