//! Requests of callers, and the errors that name what they read.

use super::colour::{CodeValues, Colour};
use brdfc_core::words::one_line;
use brdfc_formats::FormatError;
use image::ImageFormat;
use std::fmt::Display;
use std::io::{BufRead, Seek, SeekFrom};

/// A file of an image, open for reading.
pub(crate) trait ImageReader: BufRead + Seek {}

impl<R: BufRead + Seek> ImageReader for R {}

/// Use of the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Reflectance or radiance, as colours.
    Colours(Option<CodeValues>),
    /// Numbers such as shares, without conversion of colours.
    Data,
    /// Numbers of one channel, without conversion of colours.
    Heights,
}

/// Request of a caller: the use of the pixels, and valid files.
pub(crate) struct Ask<'a> {
    pub purpose: Purpose,
    /// Field and valid values of errors.
    pub field: &'static str,
    pub allowed: &'static str,
    pub formats: &'a [ImageFormat],
    /// Checks width and height before memory is allocated.
    pub check: &'a dyn Fn([usize; 2]) -> Result<(), FormatError>,
}

impl Ask<'_> {
    /// Error of a broken file.
    pub(super) fn broken(&self, error: impl Display) -> FormatError {
        FormatError::whole(self.field, one_line(&error), self.allowed).problem()
    }

    /// Error of contents that are not supported.
    pub(super) fn found(&self, found: impl Into<String>) -> FormatError {
        FormatError::whole(self.field, found, self.allowed)
    }

    /// Colour of the pixels: what the file states, which is read only if nothing else decides.
    pub(super) fn colour(&self, stated: impl FnOnce() -> Result<Colour, FormatError>) -> Result<Colour, FormatError> {
        match self.purpose {
            Purpose::Colours(None) => stated(),
            Purpose::Colours(Some(codes)) => Ok(Colour::given(codes)),
            Purpose::Data | Purpose::Heights => Ok(Colour::linear("stored values")),
        }
    }

    pub(super) fn check_size(&self, size: [usize; 2]) -> Result<(), FormatError> {
        if size.contains(&0) {
            Err(self.found(format!("{} x {} pixels", size[0], size[1])))
        } else {
            (self.check)(size)
        }
    }
}

/// Returns to the first byte.
pub(super) fn rewind(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<(), FormatError> {
    reader.seek(SeekFrom::Start(0)).map(drop).map_err(|error| ask.broken(error))
}
