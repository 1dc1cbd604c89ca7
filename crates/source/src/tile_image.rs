//! Images of surface colours and of material shares.

use crate::InputError;
use crate::input::{Input, InputFile};
use crate::jpeg_end::check_end;
use crate::read::ReadListener;
use brdfc_core::words::one_line;
use brdfc_formats::FormatError;
use brdfc_formats::memory::reserved;
use brdfc_readers::colour::decode_srgb;
use image::{DynamicImage, ImageBuffer, ImageError, ImageFormat, ImageReader, Limits, Pixel, Primitive};
use std::io::Cursor;
use std::path::Path;

/// Maximum width and height, pixels.
const MAX_SIZE: u32 = 8192;
/// Maximum size of a file, bytes.
const MAX_BYTES: u64 = 1 << 30;
/// Maximum memory of decoding, bytes: four channels of 16 bits for the largest image.
const MAX_DECODER_BYTES: u64 = 8 * (MAX_SIZE as u64).pow(2);

/// An image of `N` channels; row 0 is the top.
#[derive(Debug, Clone, PartialEq)]
pub struct FileImage<const N: usize> {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows of pixels.
    pub height: usize,
    /// Pixels, row by row from the top, left to right.
    pub pixels: Vec<[f32; N]>,
}

/// Reads a PNG or JPEG of 8 or 16 bits as linear RGB, decoded from sRGB.
///
/// # Errors
/// Returns an error for files that cannot be read, are of another format, or are larger than 8192 pixels along a side.
pub fn open_colours(input: impl Into<Input>) -> Result<FileImage<3>, InputError> {
    open(InputFile::of(&input.into(), &mut ())?, linear)
}

/// Same as [`open_colours`] for a file that `listener` observes.
///
/// # Errors
/// Returns the errors of [`open_colours`].
pub fn open_colours_observed(path: &Path, listener: &mut dyn ReadListener) -> Result<FileImage<3>, InputError> {
    open(InputFile::at(path, listener)?, linear)
}

fn linear([r, g, b, _]: [f32; 4], _: bool) -> [f32; 3] {
    [r, g, b].map(|c| decode_srgb(f64::from(c)) as f32)
}

/// Reads a PNG or JPEG of 8 or 16 bits: its stored channels, 0 to 1; the fourth is 0 if the file has none.
///
/// # Errors
/// Returns an error for files that cannot be read, are of another format, or are larger than 8192 pixels along a side.
pub fn open_shares(input: impl Into<Input>) -> Result<FileImage<4>, InputError> {
    open(InputFile::of(&input.into(), &mut ())?, |[r, g, b, a], has_alpha| [r, g, b, if has_alpha { a } else { 0.0 }])
}

/// Reads an image. `of` converts the RGBA of each pixel; its flag is true if the file has a fourth channel.
fn open<const N: usize>(
    file: InputFile<'_>,
    of: impl Fn([f32; 4], bool) -> [f32; N],
) -> Result<FileImage<N>, InputError> {
    let path = file.path;
    let decoded = file.parse_within(MAX_BYTES, decode)?;
    let of = |pixel| of(pixel, decoded.color().has_alpha());
    let pixels = match &decoded {
        DynamicImage::ImageLuma8(image) => convert(image, of),
        DynamicImage::ImageLumaA8(image) => convert(image, of),
        DynamicImage::ImageRgb8(image) => convert(image, of),
        DynamicImage::ImageRgba8(image) => convert(image, of),
        DynamicImage::ImageLuma16(image) => convert(image, of),
        DynamicImage::ImageLumaA16(image) => convert(image, of),
        DynamicImage::ImageRgb16(image) => convert(image, of),
        DynamicImage::ImageRgba16(image) => convert(image, of),
        other => Err(FormatError::whole("image", format!("{:?}", other.color()), "8 or 16 bits")),
    };
    let pixels = pixels.map_err(|error| InputError::format(path, error))?;
    Ok(FileImage { width: decoded.width() as usize, height: decoded.height() as usize, pixels })
}

/// Converts directly from the decoded pixels: a copy of four floats per pixel would be larger than all the rest.
fn convert<P: Pixel<Subpixel: Into<f32>>, const N: usize>(
    image: &ImageBuffer<P, Vec<P::Subpixel>>,
    of: impl Fn([f32; 4]) -> [f32; N],
) -> Result<Vec<[f32; N]>, FormatError> {
    let white: f32 = P::Subpixel::DEFAULT_MAX_VALUE.into();
    let mut pixels = reserved("pixels", image.width() as usize * image.height() as usize)?;
    pixels.extend(image.pixels().map(|pixel| of(pixel.to_rgba().0.map(|code| code.into() / white))));
    Ok(pixels)
}

fn decode(bytes: &[u8]) -> Result<DynamicImage, FormatError> {
    let allowed = "a complete PNG or JPEG of at most 8192 pixels along a side";
    let wrong = |found: String| FormatError::whole("image", found, allowed);
    let reader = || {
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        reader.map_err(|error| wrong(one_line(&error)).problem())
    };
    let format = reader()?.format();
    if !matches!(format, Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err(match format {
            Some(format) => wrong(format!("{format:?}")),
            None => wrong("unknown format".to_owned()).problem(),
        });
    }
    // Checks the size before the decoder does, whose errors name no sizes.
    let (width, height) = reader()?.into_dimensions().map_err(|error| wrong(limit_message(error)).problem())?;
    if width > MAX_SIZE || height > MAX_SIZE {
        return Err(wrong(format!("{width} x {height} pixels")));
    }
    if format == Some(ImageFormat::Jpeg) {
        check_end(bytes).map_err(|problem| wrong(problem.to_owned()).problem())?;
    }
    let mut reader = reader()?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIZE), Some(MAX_SIZE));
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    reader.decode().map_err(|error| wrong(limit_message(error)).problem())
}

fn limit_message(error: ImageError) -> String {
    match error {
        ImageError::Limits(_) => "too many pixels for the decoder".to_owned(),
        error => one_line(&error),
    }
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
        assert!(opened("a.png", b"text").unwrap_err().contains("image: unknown format; expected"));
        let wide = encoded(image::GrayImage::new(8193, 1).into(), ImageFormat::Png);
        assert!(opened("a.png", &wide).unwrap_err().contains("found 8193 x 1 pixels"));
    }
}
