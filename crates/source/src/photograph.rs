//! Photographs: PNG, JPEG, TIFF and EXR images of a BTF stack or RTI capture as linear RGB.

use crate::InputError;
use crate::exr_header::exr_headers;
use crate::tile_image::FileImage;
use brdfc_formats::FormatError;
use brdfc_readers::colour::decode_srgb;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Maximum width and height of an image, pixels.
pub const MAX_SIZE: u32 = 8192;
/// Maximum memory of decoding an image, bytes: four f32 per pixel of the largest, twice.
const MAX_DECODER_BYTES: u64 = 2 << 30;

/// Linear value of each 8-bit sRGB level.
static LINEAR_8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| decode_srgb(code as f64 / 255.0) as f32));
/// Linear value of each 16-bit sRGB level.
static LINEAR_16: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|code| decode_srgb(f64::from(code) / 65535.0) as f32).collect());

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
    pub(crate) fn read(path: &Path, size: [usize; 2]) -> Result<Self, InputError> {
        let mut reader = reader(path)?;
        if reader.format() == Some(ImageFormat::OpenExr) {
            check_exr(path)?;
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
            let error =
                FormatError::whole("image size", found, format!("{width} x {height}, the size when it was opened"));
            return Err(InputError::format(path, error));
        }
        let pixels = linear(decoded);
        if let Some(at) = pixels.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite())) {
            let found = format!("{:?} at ({}, {})", pixels[at], at % width, at / width);
            return Err(InputError::format(path, FormatError::whole("pixel", found, "finite values")));
        }
        Ok(Self { width, height, pixels })
    }
}

fn linear(decoded: DynamicImage) -> Vec<[f32; 3]> {
    let eight = |code: u8| LINEAR_8[usize::from(code)];
    let sixteen = |code: u16| LINEAR_16[usize::from(code)];
    match decoded {
        DynamicImage::ImageLuma8(image) => texels(&image, eight),
        DynamicImage::ImageLumaA8(image) => texels(&image, eight),
        DynamicImage::ImageRgb8(image) => texels(&image, eight),
        DynamicImage::ImageRgba8(image) => texels(&image, eight),
        DynamicImage::ImageLuma16(image) => texels(&image, sixteen),
        DynamicImage::ImageLumaA16(image) => texels(&image, sixteen),
        DynamicImage::ImageRgb16(image) => texels(&image, sixteen),
        DynamicImage::ImageRgba16(image) => texels(&image, sixteen),
        // Only EXR and TIFF have floats.
        _ => decoded.into_rgb32f().pixels().map(|pixel| pixel.0).collect(),
    }
}

/// Grey or RGB, without alpha.
fn texels<P: image::Pixel>(
    image: &image::ImageBuffer<P, Vec<P::Subpixel>>,
    linear: impl Fn(P::Subpixel) -> f32,
) -> Vec<[f32; 3]> {
    let channels = usize::from(P::CHANNEL_COUNT);
    let texels = image.as_raw().chunks_exact(channels);
    if channels < 3 {
        texels.map(|texel| [linear(texel[0]); 3]).collect()
    } else {
        texels.map(|texel| [linear(texel[0]), linear(texel[1]), linear(texel[2])]).collect()
    }
}

/// Common width and height of all images, from their headers: 0 without images.
///
/// # Errors
/// Returns an error for files that cannot be read or are not PNG, JPEG, TIFF or EXR, and for images of different sizes or
/// with more than [`MAX_SIZE`] pixels along a side. `first` names the first image in errors.
pub(crate) fn common_size(paths: &[PathBuf], first: &str) -> Result<[u32; 2], InputError> {
    let mut size = None;
    for path in paths {
        let found = image_size(path)?;
        let [width, height] = *size.get_or_insert(found);
        if found != [width, height] {
            let allowed = format!("{width} x {height}, the size of {first}");
            let error = FormatError::whole("image size", format!("{} x {}", found[0], found[1]), allowed);
            return Err(InputError::format(path, error));
        }
    }
    Ok(size.unwrap_or_default())
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
    let headers = exr_headers(std::io::BufReader::new(file), "a complete PNG, JPEG, TIFF or EXR image");
    headers.map(drop).map_err(|error| InputError::format(path, error))
}

fn image_size(path: &Path) -> Result<[u32; 2], InputError> {
    let (width, height) = reader(path)?.into_dimensions().map_err(|error| image_error(path, error))?;
    if (1..=MAX_SIZE).contains(&width) && (1..=MAX_SIZE).contains(&height) {
        return Ok([width, height]);
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
            let error = FormatError::whole("image", error.to_string(), "a complete PNG, JPEG, TIFF or EXR image");
            InputError::format(path, error.problem())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_codes() {
        for (code, linear) in [(0.0, 0.0), (1.0, 1.0), (188.0 / 255.0, 0.502_886_5), (10.0 / 255.0, 0.003_035_27)] {
            assert!((decode_srgb(code) - linear).abs() < 1e-7, "{code}");
        }
    }
}
