//! What a reader of files that have reflectance says of itself, and of each file.

use super::error::InputError;
use super::input::InputFile;
use super::stray_rows::StrayRows;
use brdfc_core::Source;
use brdfc_formats::crop::DirectionRange;
use brdfc_readers::file_kind::FileKind;

/// What is worth knowing of an input, as its reader says it.
pub trait Describe {
    /// Lines for people: names and values. [`Self::in_words`] adds the directions.
    fn lines(&self) -> Vec<(&'static str, String)>;

    /// Measured samples that came in; 0 for models.
    fn samples(&self) -> u64;

    /// Directions that a pack is for.
    fn directions(&self) -> DirectionRange {
        DirectionRange::ALL
    }

    /// Levels of detail besides the finest, of packs alone.
    fn levels(&self) -> Option<u32> {
        None
    }

    /// Rows with a negative channel, which was raised to 0.
    fn rows_raised(&self) -> u64 {
        0
    }

    /// Rows of a scan that stray from the azimuth of incidence of the others.
    fn stray_rows(&self) -> Option<StrayRows> {
        None
    }

    /// Lines for people: names and values.
    fn in_words(&self) -> Vec<(&'static str, String)> {
        let mut lines = self.lines();
        let directions = self.directions();
        if !directions.is_all() {
            lines.push(("directions", format!("{directions}; errors are of these")));
        }
        lines
    }
}

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
