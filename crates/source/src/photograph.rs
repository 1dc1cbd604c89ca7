//! Photographs: PNG, JPEG and EXR images of a stack as linear RGB.

use crate::InputError;
use crate::exr_header::exr_headers;
use crate::tile_image::FileImage;
use brdfc_formats::FormatError;
use brdfc_readers::colour::decode_srgb;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Most pixels per row and rows of an image.
pub const MAX_SIZE: u32 = 4096;
/// Most memory that decoding one image may take: four f32 per pixel of the largest, twice.
const MAX_DECODER_BYTES: u64 = 1 << 30;

/// Linear value of each 8-bit sRGB code.
static LINEAR_8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| decode_srgb(code as f64 / 255.0) as f32));
/// Linear value of each 16-bit sRGB code.
static LINEAR_16: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|code| decode_srgb(f64::from(code) / 65535.0) as f32).collect());

/// One image of a stack: linear RGB (Rec. 709 primaries), 1 is the full scale of codes.
///
/// Row 0 is the top, y = 1: pixel (column, row) has its centre at `((column + ½) / width, 1 - (row + ½) / height)`.
pub type Image = FileImage<3>;

impl Image {
    /// Reads an image of `size`, pixels per row and rows.
    ///
    /// PNG and JPEG hold sRGB codes whatever their colour profile says, EXR linear values; alpha is ignored.
    ///
    /// # Errors
    /// A file that cannot be read or decoded, or has another size; values that are no finite numbers.
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
            let error = FormatError::whole("image size", found, format!("{width} x {height}, as when it was opened"));
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
        // EXR alone has floats.
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

/// Pixels per row, and rows, of all images: 0 of none. Reads their headers.
///
/// # Errors
/// What cannot be read or is no PNG, JPEG or EXR; images of different sizes or of more than [`MAX_SIZE`] pixels along a
/// side, which name the first image `first`.
pub(crate) fn common_size(paths: &[PathBuf], first: &str) -> Result<[u32; 2], InputError> {
    let mut size = None;
    for path in paths {
        let found = image_size(path)?;
        let [width, height] = *size.get_or_insert(found);
        if found != [width, height] {
            let allowed = format!("{width} x {height}, as {first} has");
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
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::OpenExr) => Ok(reader),
        _ => Err(InputError::format(path, FormatError::whole("image", "some other layout", "PNG, JPEG or EXR"))),
    }
}

/// The decoder has no limit of what it asks for to decode a block.
fn check_exr(path: &Path) -> Result<(), InputError> {
    let file = std::fs::File::open(path).map_err(|error| InputError::io(path, error))?;
    let headers = exr_headers(std::io::BufReader::new(file), "a whole PNG, JPEG or EXR image");
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
        // These say that the file ends early or is broken, not that it cannot be read.
        ImageError::IoError(error)
            if ![ErrorKind::UnexpectedEof, ErrorKind::InvalidData, ErrorKind::Other].contains(&error.kind()) =>
        {
            InputError::io(path, error)
        }
        ImageError::Limits(_) => {
            let allowed = format!("1 to {MAX_SIZE} along each side");
            InputError::format(path, FormatError::whole("image size", "more pixels than a decoder takes", allowed))
        }
        error => {
            InputError::format(path, FormatError::whole("image", error.to_string(), "a whole PNG, JPEG or EXR image"))
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
