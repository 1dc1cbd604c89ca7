//! Why flattening fails.

use brdfc_core::progress::Cancelled;
use brdfc_flat_btf::encode::EncodeError;
use brdfc_flat_btf::parameterise::ParameteriseError;
use brdfc_formats::FormatError;
use brdfc_source::InputError;
use std::path::Path;

/// Why a flat BTF cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FlattenError {
    /// The surface cannot be laid flat.
    #[error(transparent)]
    Parameterise(ParameteriseError),
    /// A pack cannot hold it.
    #[error("{0}")]
    Pack(#[from] FormatError),
    /// An image cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A file cannot be written.
    #[error("{path}: cannot write: {error}")]
    Write {
        /// Which.
        path: String,
        /// What the system says.
        error: std::io::Error,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl FlattenError {
    pub(super) fn write(path: &Path, error: std::io::Error) -> Self {
        Self::Write { path: path.display().to_string(), error }
    }
}

impl From<EncodeError<Self>> for FlattenError {
    fn from(error: EncodeError<Self>) -> Self {
        match error {
            EncodeError::Parameterise(error) => Self::Parameterise(error),
            EncodeError::Format(error) => error.into(),
            EncodeError::Outside(error) => error,
            EncodeError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}
