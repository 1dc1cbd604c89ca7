//! Photographs: PNG, JPEG, TIFF and EXR images of a BTF stack or RTI capture.

use crate::InputError;
use crate::exr_header::exr_headers;
use crate::jpeg_end::check_end;
use crate::tile_image::FileImage;
use brdfc_core::words::one_line;
use brdfc_formats::FormatError;
use brdfc_readers::pixels::Pixels;
use image::error::ImageFormatHint;
use image::{DynamicImage, ImageDecoder as _, ImageError, ImageFormat, ImageReader};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Maximum width and height of an image, pixels.
pub const MAX_SIZE: u32 = 8192;
/// Files that [`read_pixels`] reads.
const ALLOWED: &str = "a complete PNG, JPEG, TIFF or EXR image";
/// Maximum memory of decoding an image, bytes: four f32 per pixel of the largest, twice.
const MAX_DECODER_BYTES: u64 = 2 << 30;

/// A photograph: linear RGB (Rec. 709 primaries), 1 is the full scale of integer formats.
///
/// Row 0 is the top, y = 1: the centre of pixel (column, row) is at `((column + ½) / width, 1 - (row + ½) / height)`.
pub type Image = FileImage<3>;

impl Image {
    /// Reads an image of `size`, width and height in pixels.
    ///
    /// PNG, JPEG and TIFF hold sRGB values, and their colour profiles are ignored; EXR and TIFF with floats hold linear
    /// values. Alpha is ignored.
    ///
    /// # Errors
    /// Returns an error for a file that cannot be read or decoded, or has another size, and for values that are not
    /// finite.
    pub(crate) fn read(path: &Path, [width, height]: [usize; 2]) -> Result<Self, InputError> {
        let pixels = read_pixels(path, [width, height])?.into_linear();
        Ok(Self { width, height, pixels })
    }
}

/// Reads the pixels of an image, as [`Image::read`] does.
///
/// # Errors
/// Returns the errors of [`Image::read`].
pub(crate) fn read_pixels(path: &Path, size: [usize; 2]) -> Result<Pixels, InputError> {
    let mut reader = reader(path)?;
    match reader.format() {
        Some(ImageFormat::OpenExr) => check_exr(path)?,
        Some(ImageFormat::Jpeg) => check_jpeg(path)?,
        _ => {}
    }
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIZE);
    limits.max_image_height = Some(MAX_SIZE);
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|error| image_error(path, error))?;
    let [width, height] = size;
    if [decoded.width() as usize, decoded.height() as usize] != size {
        let found = format!("{} x {}", decoded.width(), decoded.height());
        let error = FormatError::whole("image size", found, format!("{width} x {height}, the size when it was opened"));
        return Err(InputError::format(path, error));
    }
    let pixels = pixels_of(decoded);
    if let Pixels::Linear(pixels) = &pixels
        && let Some(at) = pixels.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite()))
    {
        let found = format!("{:?} at ({}, {})", pixels[at], at % width, at / width);
        return Err(InputError::format(path, FormatError::whole("pixel", found, "finite values")));
    }
    Ok(pixels)
}

fn pixels_of(decoded: DynamicImage) -> Pixels {
    match decoded {
        DynamicImage::ImageLuma8(image) => Pixels::Levels8(colours(image).into()),
        DynamicImage::ImageLumaA8(image) => Pixels::Levels8(colours(image).into()),
        DynamicImage::ImageRgb8(image) => Pixels::Levels8(colours(image).into()),
        DynamicImage::ImageRgba8(image) => Pixels::Levels8(colours(image).into()),
        DynamicImage::ImageLuma16(image) => Pixels::Levels16(colours(image).into()),
        DynamicImage::ImageLumaA16(image) => Pixels::Levels16(colours(image).into()),
        DynamicImage::ImageRgb16(image) => Pixels::Levels16(colours(image).into()),
        DynamicImage::ImageRgba16(image) => Pixels::Levels16(colours(image).into()),
        // Only EXR and TIFF have floats.
        _ => decoded.into_rgb32f().pixels().map(|pixel| pixel.0).collect::<Vec<_>>().into(),
    }
}

/// Grey or RGB, without alpha.
fn colours<P: image::Pixel>(image: image::ImageBuffer<P, Vec<P::Subpixel>>) -> Vec<[P::Subpixel; 3]> {
    let channels = usize::from(P::CHANNEL_COUNT);
    let texels = image.as_raw().chunks_exact(channels);
    if channels < 3 {
        texels.map(|texel| [texel[0]; 3]).collect()
    } else {
        texels.map(|texel| [texel[0], texel[1], texel[2]]).collect()
    }
}

/// Common width and height of all images, from their headers, 0 without images; and the bytes of all [`Pixels`].
///
/// # Errors
/// Returns an error for files that cannot be read or are not PNG, JPEG, TIFF or EXR, and for images of different sizes or
/// with more than [`MAX_SIZE`] pixels along a side. `first` names the first image in errors.
pub(crate) fn common_size(paths: &[PathBuf], first: &str) -> Result<([u32; 2], u64), InputError> {
    let (mut size, mut bytes) = (None, 0);
    for path in paths {
        let (found, of_channel) = header(path)?;
        bytes += 3 * of_channel * u64::from(found[0]) * u64::from(found[1]);
        let [width, height] = *size.get_or_insert(found);
        if found != [width, height] {
            let allowed = format!("{width} x {height}, the size of {first}");
            let error = FormatError::whole("image size", format!("{} x {}", found[0], found[1]), allowed);
            return Err(InputError::format(path, error));
        }
    }
    Ok((size.unwrap_or_default(), bytes))
}

fn reader(path: &Path) -> Result<ImageReader<std::io::BufReader<std::fs::File>>, InputError> {
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    let reader = reader.map_err(|error| InputError::io(path, error))?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Tiff | ImageFormat::OpenExr) => Ok(reader),
        _ => {
            let error = FormatError::whole("image", "unknown format", "PNG, JPEG, TIFF or EXR").problem();
            Err(InputError::format(path, error))
        }
    }
}

/// Checks block sizes, because the decoder does not limit the memory of a block.
fn check_exr(path: &Path) -> Result<(), InputError> {
    let file = std::fs::File::open(path).map_err(|error| InputError::io(path, error))?;
    let headers = exr_headers(std::io::BufReader::new(file), ALLOWED);
    headers.map(drop).map_err(|error| InputError::format(path, error))
}

/// Checks for the end marker, because the decoder fills missing pixels with grey.
fn check_jpeg(path: &Path) -> Result<(), InputError> {
    let jpeg = std::fs::read(path).map_err(|error| InputError::io(path, error))?;
    check_end(&jpeg)
        .map_err(|problem| InputError::format(path, FormatError::whole("image", problem, ALLOWED).problem()))
}

/// Width, height and bytes per channel.
fn header(path: &Path) -> Result<([u32; 2], u64), InputError> {
    let decoder = reader(path)?.into_decoder().map_err(|error| image_error(path, error))?;
    let (width, height) = decoder.dimensions();
    if (1..=MAX_SIZE).contains(&width) && (1..=MAX_SIZE).contains(&height) {
        let colour = decoder.color_type();
        return Ok(([width, height], u64::from(colour.bytes_per_pixel() / colour.channel_count())));
    }
    let allowed = format!("1 to {MAX_SIZE} along each side");
    Err(InputError::format(path, FormatError::whole("image size", format!("{width} x {height}"), allowed)))
}

fn image_error(path: &Path, error: ImageError) -> InputError {
    match error {
        // These errors mean a truncated or broken file, not a failed read.
        ImageError::IoError(error)
            if ![ErrorKind::UnexpectedEof, ErrorKind::InvalidData, ErrorKind::Other].contains(&error.kind()) =>
        {
            InputError::io(path, error)
        }
        ImageError::Limits(_) => {
            let allowed = format!("1 to {MAX_SIZE} along each side");
            let error = FormatError::whole("image size", "too many pixels for the decoder", allowed);
            InputError::format(path, error.problem())
        }
        error => {
            let allowed = match &error {
                ImageError::Unsupported(one) if one.format_hint() == ImageFormatHint::Exact(ImageFormat::Tiff) => {
                    "a TIFF of 8 or 16 bits per channel, or of floats in RGB"
                }
                _ => ALLOWED,
            };
            InputError::format(path, FormatError::whole("image", one_line(&error), allowed).problem())
        }
    }
}
