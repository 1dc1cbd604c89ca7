//! Images in files: one reader for photographs, colours, data and radiance.
//!
//! It takes what a file states about its pixels: colour, orientation, windows, pages and exposure.

mod colour;
mod exif;
mod exr;
mod hdr;
mod jpeg;
mod jpeg_scan;
mod orientation;
mod png;
mod tiff;

pub use colour::{CodeValues, Colour};
pub(crate) use jpeg::check as check_jpeg;
pub(crate) use orientation::Orientation;

use brdfc_core::words::one_line;
use brdfc_formats::FormatError;
use image::ImageFormat;
use std::fmt::Display;
use std::io::{BufRead, Seek, SeekFrom};

/// A file of an image, open for reading.
pub(crate) trait ImageReader: BufRead + Seek {}

impl<R: BufRead + Seek> ImageReader for R {}

/// Size of a file's first bytes that identify its format.
const SIGNATURE_BYTES: usize = 16;

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

/// What a caller reads.
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
    fn broken(&self, error: impl Display) -> FormatError {
        FormatError::whole(self.field, one_line(&error), self.allowed).problem()
    }

    /// Error of contents that are not supported.
    fn found(&self, found: impl Into<String>) -> FormatError {
        FormatError::whole(self.field, found, self.allowed)
    }

    fn check_size(&self, size: [usize; 2]) -> Result<(), FormatError> {
        if size.contains(&0) {
            Err(self.found(format!("{} x {} pixels", size[0], size[1])))
        } else {
            (self.check)(size)
        }
    }
}

/// Type of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    U8,
    U16,
    F32,
}

/// Header of an image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    /// Width and height of the upright image, in its display window.
    pub size: [usize; 2],
    pub channels: usize,
    pub depth: Depth,
    pub colour: Colour,
    pub orientation: Orientation,
    /// Other statements of the file that were applied.
    pub notes: Vec<String>,
}

impl Header {
    /// Bytes of a pixel of [`Colour::pixels`].
    pub(crate) fn pixel_bytes(&self) -> u64 {
        3 * match self.depth {
            Depth::U8 if self.colour.is_srgb() => 1,
            Depth::U8 | Depth::U16 => 2,
            Depth::F32 => 4,
        }
    }

    /// What the file states, and what was done.
    pub(crate) fn conversions(&self) -> Vec<String> {
        let turned = (!self.orientation.is_upright()).then(|| format!("orientation {}", self.orientation));
        [self.colour.to_string()].into_iter().chain(turned).chain(self.notes.iter().cloned()).collect()
    }
}

/// Interleaved samples, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Raster {
    pub size: [usize; 2],
    /// 1 to 4; the second or fourth is alpha.
    pub channels: usize,
    pub samples: Samples,
}

/// Samples as stored; integers over their whole range.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Samples {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

/// Identifies a format by its first bytes; `None` for others.
fn format_of(reader: &mut impl ImageReader) -> Option<ImageFormat> {
    let mut start = [0; SIGNATURE_BYTES];
    let mut length = 0;
    while let Ok(count @ 1..) = reader.read(&mut start[length..]) {
        length += count;
    }
    let start = &start[..length];
    match start {
        [b'#', b'?', ..] => Some(ImageFormat::Hdr),
        [b'I', b'I', 43, 0, ..] | [b'M', b'M', 0, 43, ..] => Some(ImageFormat::Tiff),
        _ => image::guess_format(start).ok(),
    }
}

/// Reads what a file states, without its pixels.
///
/// # Errors
/// Returns an error for other formats, broken or unsupported headers, and sizes that `ask` rejects.
pub(crate) fn read_header(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Header, FormatError> {
    rewind(reader, ask)?;
    let format = format_of(reader);
    rewind(reader, ask)?;
    let mut header = match format {
        Some(format) if !ask.formats.contains(&format) => return Err(ask.found(format!("{format:?}"))),
        Some(ImageFormat::Png) => png::header(reader, ask)?,
        Some(ImageFormat::Jpeg) => jpeg::header(reader, ask)?,
        Some(ImageFormat::Tiff) => tiff::header(reader, ask)?,
        Some(ImageFormat::OpenExr) => exr::header(reader, ask)?,
        Some(ImageFormat::Hdr) => hdr::header(reader, ask)?,
        _ => return Err(ask.broken("unknown format")),
    };
    if let Purpose::Colours(codes) = ask.purpose {
        header.colour = header.colour.overridden(codes);
    }
    Ok(header)
}

/// Reads an image: what it states, and its upright samples before the conversion of colours.
///
/// # Errors
/// Returns the errors of [`read_header`], and an error for files that lack pixels.
pub(crate) fn read(mut reader: impl ImageReader, ask: &Ask<'_>) -> Result<(Header, Raster), FormatError> {
    let header = read_header(&mut reader, ask)?;
    rewind(&mut reader, ask)?;
    let format = format_of(&mut reader);
    rewind(&mut reader, ask)?;
    let raster = match format {
        Some(ImageFormat::Png) => png::samples(reader, ask)?,
        Some(ImageFormat::Jpeg) => jpeg::samples(reader, ask)?,
        Some(ImageFormat::Tiff) => tiff::samples(reader, ask)?,
        Some(ImageFormat::OpenExr) => exr::samples(reader, ask)?,
        _ => hdr::samples(reader, ask)?,
    };
    let raster = header.orientation.upright(raster);
    Ok((header, raster))
}

fn rewind(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<(), FormatError> {
    reader.seek(SeekFrom::Start(0)).map(drop).map_err(|error| ask.broken(error))
}
