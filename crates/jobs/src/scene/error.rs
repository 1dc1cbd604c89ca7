//! Why a job fails.

use crate::encode::EncodeError;
use crate::error::Error;
use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_source::InputError;

/// Why a material, or the environment, failed.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The source.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The encoder.
    #[error(transparent)]
    Encode(EncodeError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A map that its own layout refuses: a fault of the program.
    #[error("{0}")]
    Map(FormatError),
    /// A file of the store that cannot be written.
    #[error(transparent)]
    Store(Error),
}

impl JobError {
    /// Whether it was not even begun, because another failed or somebody asked to stop.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled(_))
    }
}

impl From<EncodeError> for JobError {
    fn from(error: EncodeError) -> Self {
        match error {
            EncodeError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Encode(other),
        }
    }
}

impl From<JobError> for Error {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Input(error) => error.into(),
            JobError::Encode(error) => error.into(),
            JobError::Cancelled(cancelled) => cancelled.into(),
            JobError::Map(error) => Self::own_layout(error),
            JobError::Store(error) => error,
        }
    }
}
