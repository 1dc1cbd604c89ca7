//! Errors of inputs.

use brdfc_core::address::AddressError;
use brdfc_core::words::system_error;
use brdfc_formats::FormatError;
use std::path::Path;

/// Error of an input that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The contents violate the layout of the file.
    #[error("{name}: {error}")]
    Format {
        /// Name of the input, as the user gave it.
        name: String,
        /// Violation of the layout.
        error: FormatError,
    },
    /// The contents violate the layout, and look like a kind of file that does not match the extension.
    #[error("{name}: {error}; it looks like {looks_like}")]
    Misnamed {
        /// Name of the input, as the user gave it.
        name: String,
        /// Violation of the layout.
        error: Box<FormatError>,
        /// Kind of the contents, with an article.
        looks_like: &'static str,
    },
    /// The file cannot be read.
    #[error("{name}: cannot read: {}", system_error(.error))]
    Io {
        /// Name of the input, as the user gave it.
        name: String,
        /// Error of the system.
        error: std::io::Error,
    },
    /// The `synth:` address is invalid.
    #[error("{name}: {error}")]
    Address {
        /// Name of the input, as the user gave it.
        name: String,
        /// Error in the address.
        error: AddressError,
    },
}

impl InputError {
    /// Creates an error for a file that violates its layout.
    pub fn format(path: &Path, error: FormatError) -> Self {
        Self::Format { name: path.display().to_string(), error }
    }

    /// Creates an error for a file that cannot be read.
    pub fn io(path: &Path, error: std::io::Error) -> Self {
        let name = if path.as_os_str().is_empty() { "an empty name".to_owned() } else { path.display().to_string() };
        Self::Io { name, error }
    }
}
