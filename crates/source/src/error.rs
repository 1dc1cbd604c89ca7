//! Inputs that cannot be used.

use brdfc_core::address::AddressError;
use brdfc_formats::FormatError;
use std::path::Path;

/// An input that cannot be used, and whose fault that is.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// What stands in the file breaks its layout.
    #[error("{name}: {error}")]
    Format {
        /// The input as it was named.
        name: String,
        /// What is wrong.
        error: FormatError,
    },
    /// The same, and the file is by its bytes another kind than its name says.
    #[error("{name}: {error}; it looks like {looks_like}")]
    Misnamed {
        /// The input as it was named.
        name: String,
        /// What is wrong.
        error: Box<FormatError>,
        /// What it looks like, with an article.
        looks_like: &'static str,
    },
    /// The file cannot be read.
    #[error("{name}: cannot read: {error}")]
    Io {
        /// The input as it was named.
        name: String,
        /// What the system says.
        error: std::io::Error,
    },
    /// The `synth:` address is wrong.
    #[error("{name}: {error}")]
    Address {
        /// The input as it was named.
        name: String,
        /// What is wrong.
        error: AddressError,
    },
}

impl InputError {
    /// A file that breaks its layout.
    pub fn format(path: &Path, error: FormatError) -> Self {
        Self::Format { name: path.display().to_string(), error }
    }

    /// A file that cannot be read.
    pub fn io(path: &Path, error: std::io::Error) -> Self {
        let name = if path.as_os_str().is_empty() { "an empty name".to_owned() } else { path.display().to_string() };
        Self::Io { name, error }
    }
}
