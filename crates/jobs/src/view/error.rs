//! Why there is no page.

use crate::encode::EncodeError;
use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_source::InputError;

/// Most bytes of textures of all materials: a page is to open in a browser.
const MOST_BYTES: u64 = 256 << 20;

/// Refuses more textures than a page should hold.
pub(super) fn check_bytes(name: &str, bytes: u64) -> Result<(), ViewError> {
    if bytes <= MOST_BYTES {
        return Ok(());
    }
    let allowed = "256 MiB in a page: fewer materials, or smaller ones";
    Err(ViewError::refused(name, format!("{} of textures", brdfc_core::words::bytes(bytes)), allowed))
}

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// What cannot be read, or cannot be drawn.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The folder of a build that is not whole.
    #[error(transparent)]
    Folder(#[from] crate::report::page::GatherError),
    /// A source of which no table could be made.
    #[error("{name}: {error}")]
    Table {
        /// The source.
        name: String,
        /// Why.
        error: EncodeError,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ViewError {
    /// An input of another kind.
    pub(super) fn refused(name: &str, found: impl Into<String>, allowed: &'static str) -> Self {
        Self::Input(InputError::Format { name: name.to_owned(), error: FormatError::whole("input", found, allowed) })
    }
}
