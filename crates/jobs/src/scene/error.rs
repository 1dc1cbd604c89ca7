//! Errors of jobs.

use crate::encode::{EncodeError, Message};
use crate::error::{Error, ErrorKind};
use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_lobes::LobesError;
use brdfc_source::InputError;

/// Error of the job of a material or of the environment.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The source cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The encoder cannot make a pack from the source.
    #[error(transparent)]
    Encode(EncodeError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A map breaks the rules of its own layout: a bug of the program.
    #[error("{0}")]
    Map(FormatError),
    /// An asset that is no material cannot be made.
    #[error(transparent)]
    Asset(Error),
    /// A file of the store cannot be written.
    #[error(transparent)]
    Store(Error),
}

impl JobError {
    /// Returns true if the job was cancelled, because another failed or the caller asked to stop.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled(_)) || matches!(self, Self::Asset(error) if error.kind() == ErrorKind::Cancelled)
    }

    /// The message with the positions of the keys of options.
    pub fn message(&self) -> Message {
        match self {
            Self::Encode(error) => error.message(),
            other => other.to_string().into(),
        }
    }
}

impl From<LobesError> for JobError {
    fn from(error: LobesError) -> Self {
        match error {
            LobesError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            LobesError::Invalid(error) => Self::Map(error),
        }
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
            JobError::Store(error) | JobError::Asset(error) => error,
        }
    }
}
