//! What a reader of files that have reflectance says of itself, and of each file.

use super::error::InputError;
use super::input::InputFile;
use brdfc_core::Source;
use brdfc_readers::file_kind::FileKind;

/// An input, ready for evaluation. `F` holds the facts of any input.
pub struct Opened<F> {
    /// Evaluates it.
    pub source: Box<dyn Source>,
    /// What it is.
    pub facts: F,
}

/// A kind of file that has reflectance: one constructor of each reader, one line of `FORMATS`.
pub struct Format<F> {
    /// What people call it.
    pub name: &'static str,
    /// What its files are called, and how they begin.
    pub kind: &'static FileKind,
    /// Reads one.
    pub(crate) open: fn(InputFile<'_>) -> Result<Opened<F>, InputError>,
}

impl<F> Format<F> {
    /// What its files' names end with, in lower case.
    pub fn extension(&self) -> &'static str {
        self.kind.extensions[0]
    }
}
