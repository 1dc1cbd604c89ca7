//! Why there is no page.

use brdfc_core::progress::Cancelled;
use brdfc_source::InputError;

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum GatherError {
    /// A file.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A folder that is not what its report says, or no report.
    #[error("{path}: found {found}; allowed {allowed}")]
    Folder {
        /// Which file.
        path: String,
        /// What is there.
        found: String,
        /// What may be there.
        allowed: &'static str,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
