//! Images of surface colours and of material shares.

use crate::InputError;
use crate::image_file::{self, Ask, Purpose, Raster, Samples};
use crate::input::{Input, InputFile};
use crate::read::ReadListener;
use brdfc_formats::FormatError;
use brdfc_formats::memory::reserved;
use image::ImageFormat;
use std::io::Cursor;
use std::path::Path;

/// Maximum width and height, pixels.
const MAX_SIZE: usize = 8192;
/// Maximum size of a file, bytes.
const MAX_BYTES: u64 = 1 << 30;
const ALLOWED: &str = "a complete PNG or JPEG of at most 8192 pixels along a side";

/// An image of `N` channels; row 0 is the top.
#[derive(Debug, Clone, PartialEq)]
pub struct FileImage<const N: usize> {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows of pixels.
    pub height: usize,
    /// Pixels, row by row from the top, left to right.
    pub pixels: Vec<[f32; N]>,
    /// Colour and other statements of the file, and what was done; the first is the colour. Empty for computed images.
    pub conversions: Vec<String>,
}

impl<const N: usize> FileImage<N> {
    /// An image that no file describes.
    pub fn new([width, height]: [usize; 2], pixels: Vec<[f32; N]>) -> Self {
        Self { width, height, pixels, conversions: Vec::new() }
    }
}

/// Reads a PNG or JPEG of 8 or 16 bits as linear RGB (Rec. 709 primaries), by the colour that the file states, or else
/// as sRGB.
///
/// # Errors
/// Returns an error for files that cannot be read, are of another format, or are larger than 8192 pixels along a side.
pub fn open_colours(input: impl Into<Input>) -> Result<FileImage<3>, InputError> {
    colours(InputFile::of(&input.into(), &mut ())?)
}

/// Same as [`open_colours`] for a file that `listener` observes.
///
/// # Errors
/// Returns the errors of [`open_colours`].
pub fn open_colours_observed(path: &Path, listener: &mut dyn ReadListener) -> Result<FileImage<3>, InputError> {
    colours(InputFile::at(path, listener)?)
}

fn colours(file: InputFile<'_>) -> Result<FileImage<3>, InputError> {
    file.parse_within(MAX_BYTES, |bytes| {
        let (mut header, raster) = image_file::read(Cursor::new(bytes), &ask(Purpose::Colours(None)))?;
        let [width, height] = raster.size;
        let pixels = header.linear_pixels(raster)?;
        Ok(FileImage { width, height, pixels, conversions: header.conversions() })
    })
}

/// Reads a PNG or JPEG of 8 or 16 bits: its stored channels, 0 to 1; the fourth is 0 if the file has none.
///
/// # Errors
/// Returns an error for files that cannot be read, are of another format, or are larger than 8192 pixels along a side.
pub fn open_shares(input: impl Into<Input>) -> Result<FileImage<4>, InputError> {
    InputFile::of(&input.into(), &mut ())?.parse_within(MAX_BYTES, |bytes| {
        let (header, raster) = image_file::read(Cursor::new(bytes), &ask(Purpose::Data))?;
        let [width, height] = raster.size;
        Ok(FileImage { width, height, pixels: shares(&raster)?, conversions: header.conversions() })
    })
}

fn shares(raster: &Raster) -> Result<Vec<[f32; 4]>, FormatError> {
    let channels = raster.channels;
    let mut pixels = reserved("pixels", raster.size[0] * raster.size[1])?;
    let of = |at: usize| match channels {
        1 | 2 => [0, 0, 0, 1].map(|c| if c < channels { Some(at + c) } else { None }),
        _ => [0, 1, 2, 3].map(|c| if c < channels { Some(at + c) } else { None }),
    };
    let value = |at: usize| match &raster.samples {
        Samples::U8(samples) => f32::from(samples[at]) / 255.0,
        Samples::U16(samples) => f32::from(samples[at]) / 65535.0,
        Samples::F32(samples) => samples[at],
    };
    pixels.extend((0..raster.size[0] * raster.size[1]).map(|at| of(channels * at).map(|at| at.map_or(0.0, value))));
    Ok(pixels)
}

fn ask(purpose: Purpose) -> Ask<'static> {
    let formats = &[ImageFormat::Png, ImageFormat::Jpeg];
    Ask { purpose, field: "image", allowed: ALLOWED, formats, check: &check_size }
}

fn check_size([width, height]: [usize; 2]) -> Result<(), FormatError> {
    let found = || FormatError::whole("image", format!("{width} x {height} pixels"), ALLOWED);
    if width.max(height) > MAX_SIZE { Err(found()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(name: &str, bytes: &[u8]) -> Result<FileImage<3>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        open_colours(&path).map_err(|error| error.to_string())
    }

    fn encoded(image: image::DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn png_and_jpeg_and_nothing_else() {
        let grey = |value| image::DynamicImage::from(image::RgbImage::from_pixel(9, 5, image::Rgb([value; 3])));
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let image = opened("a", &encoded(grey(255), format)).unwrap();
            assert_eq!((image.width, image.height), (9, 5));
            assert!(image.pixels.iter().flatten().all(|c| (c - 1.0).abs() < 0.02), "{format:?}");
        }
        let jpeg = encoded(grey(255), ImageFormat::Jpeg);
        let error = opened("a", &jpeg[..jpeg.len() - 2]).unwrap_err();
        assert!(error.contains("image: no end-of-image marker (FF D9): the JPEG is truncated; expected"), "{error}");
        let exr = encoded(image::DynamicImage::from(grey(255).into_rgb32f()), ImageFormat::OpenExr);
        let error = opened("a.png", &exr).unwrap_err();
        assert!(error.contains("found OpenExr, expected a complete PNG or JPEG"), "{error}");
        assert!(opened("a.png", b"text").unwrap_err().contains("image: found text, expected"));
        let wide = encoded(image::GrayImage::new(8193, 1).into(), ImageFormat::Png);
        assert!(opened("a.png", &wide).unwrap_err().contains("found 8193 x 1 pixels"));
    }
}
