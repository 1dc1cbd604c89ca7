//! Registration of readers for files with reflectance.

use super::error::InputError;
use super::input::InputFile;
use brdfc_core::Source;
use brdfc_readers::file_kind::FileKind;

/// An opened input, ready for evaluation. `F` is the type of its facts.
pub struct Opened<F> {
    /// Evaluates `f_r` of the input.
    pub source: Box<dyn Source>,
    /// Facts about the input.
    pub facts: F,
}

/// A kind of file with reflectance: a constructor of its reader, and an element of `FORMATS`.
pub struct Format<F> {
    /// Name of the kind in messages and lists of formats.
    pub name: &'static str,
    /// Extension and magic bytes of its files.
    pub kind: &'static FileKind,
    /// Opens a file of this kind.
    pub(crate) open: fn(InputFile<'_>) -> Result<Opened<F>, InputError>,
}

impl<F> Format<F> {
    /// Extension of its files, in lower case.
    pub fn extension(&self) -> &'static str {
        self.kind.extensions[0]
    }
}
