//! Images in files: one reader for photographs, colours, data and radiance.
//!
//! It takes what a file states about its pixels: colour, orientation, windows, pages and exposure.

mod ask;
mod colour;
mod exif;
mod exr;
mod hdr;
mod header;
mod jpeg;
mod jpeg_scan;
mod orientation;
mod png;
mod raster;
mod tiff;

pub(crate) use ask::{Ask, Purpose};
pub use colour::CodeValues;
pub(crate) use colour::GAMUT_ROUNDING;
pub(crate) use header::Header;
pub(crate) use jpeg::check as check_jpeg;
pub(crate) use raster::{Raster, Samples, collected};

use ask::{ImageReader, rewind};
use brdfc_formats::FormatError;
use image::ImageFormat;
use std::io::Read;

/// Size of a file's first bytes that identify its format.
const SIGNATURE_BYTES: usize = 16;

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

/// Name of a format that [`format_of`] does not know.
fn name_of_other(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<&'static str, FormatError> {
    let mut start = Vec::new();
    reader.by_ref().take(SIGNATURE_BYTES as u64).read_to_end(&mut start).map_err(|error| ask.broken(error))?;
    let is_text = !start.is_empty() && start.iter().all(|byte| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~'));
    Ok(match start.get(4..12) {
        Some(b"ftypheic" | b"ftypheix" | b"ftypmif1" | b"ftypmsf1") => "HEIC",
        Some(b"ftypavif" | b"ftypavis") => "AVIF",
        Some(b"ftypcrx ") => "a raw photograph of Canon",
        Some(b"JXL \r\n\x87\n") => "JPEG XL",
        _ if start.starts_with(&[0xff, 0x0a]) => "JPEG XL",
        _ if is_text => "text",
        _ => "an unknown format",
    })
}

/// Reads what a file states, without its pixels.
///
/// # Errors
/// Returns an error for other formats, broken or unsupported headers, and sizes that `ask` rejects.
pub(crate) fn read_header(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Header, FormatError> {
    rewind(reader, ask)?;
    let format = format_of(reader);
    rewind(reader, ask)?;
    match format {
        Some(format) if !ask.formats.contains(&format) => Err(ask.found(format!("{format:?}"))),
        Some(ImageFormat::Png) => png::header(reader, ask),
        Some(ImageFormat::Jpeg) => jpeg::header(reader, ask),
        Some(ImageFormat::Tiff) => tiff::header(reader, ask),
        Some(ImageFormat::OpenExr) => exr::header(reader, ask),
        Some(ImageFormat::Hdr) => hdr::header(reader, ask),
        _ => Err(ask.found(name_of_other(reader, ask)?)),
    }
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
    let raster = header.orientation.upright(raster)?;
    Ok((header, raster))
}
