//! Images that colour a surface or say where its materials are.

use crate::InputError;
use crate::input::Input;
use crate::recognise::wrong_contents;
use brdfc_formats::FormatError;
use brdfc_formats::colour::decode_srgb;
use image::{ImageError, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Most pixels along a side.
const MAX_SIZE: u32 = 8192;
/// Largest file.
const MAX_BYTES: u64 = 1 << 30;
/// Most memory that decoding may take: four channels of 16 bits for the most pixels.
const MAX_DECODER_BYTES: u64 = 8 * (MAX_SIZE as u64).pow(2);

/// An image of four channels, 0 to 1 as they stand in the file; row 0 is the top.
#[derive(Debug, Clone, PartialEq)]
pub struct FileImage {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    channels: Vec<[f32; 4]>,
    /// Whether the file has a fourth channel.
    has_alpha: bool,
}

impl FileImage {
    /// Linear RGB of sRGB codes.
    pub fn colours(&self) -> Vec<[f32; 3]> {
        let linear = |c: f32| decode_srgb(f64::from(c)) as f32;
        self.channels.iter().map(|[r, g, b, _]| [*r, *g, *b].map(linear)).collect()
    }

    /// The channels as they are; the fourth is 0 where the file has none.
    pub fn shares(&self) -> Vec<[f32; 4]> {
        let fourth = if self.has_alpha { 1.0 } else { 0.0 };
        self.channels.iter().map(|[r, g, b, a]| [*r, *g, *b, fourth * a]).collect()
    }
}

/// Reads a PNG or JPEG of 8 or 16 bits.
///
/// # Errors
/// Files that cannot be read, are no such image, or are larger than 8192 pixels along a side.
pub fn open_tile_image(input: impl Into<Input>) -> Result<FileImage, InputError> {
    let input = input.into();
    let path = input.named_path();
    let bytes = input.read(MAX_BYTES)?;
    let wrong = |found: String| {
        let error = FormatError::whole("image", found, "a whole PNG or JPEG of at most 8192 pixels along a side");
        wrong_contents(path, &bytes, bytes.len() as u64, error)
    };
    let reader =
        || ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(|error| InputError::io(path, error));
    let format = reader()?.format();
    if !matches!(format, Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err(wrong(format.map_or("some other layout".to_owned(), |format| format!("{format:?}"))));
    }
    // Before the decoder's own limits, whose errors name no sizes.
    let (width, height) = reader()?.into_dimensions().map_err(|error| wrong(in_words(error)))?;
    if width > MAX_SIZE || height > MAX_SIZE {
        return Err(wrong(format!("{width} x {height} pixels")));
    }
    let mut reader = reader()?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIZE), Some(MAX_SIZE));
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|error| wrong(in_words(error)))?;
    let has_alpha = decoded.color().has_alpha();
    let image = decoded.into_rgba32f();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let channels = image.pixels().map(|pixel| pixel.0).collect();
    Ok(FileImage { width, height, channels, has_alpha })
}

fn in_words(error: ImageError) -> String {
    match error {
        ImageError::Limits(_) => "more pixels than a decoder takes".to_owned(),
        error => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(name: &str, bytes: &[u8]) -> Result<FileImage, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        open_tile_image(&path).map_err(|error| error.to_string())
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
            assert!(image.colours().iter().flatten().all(|c| (c - 1.0).abs() < 0.02), "{format:?}");
        }
        let exr = encoded(image::DynamicImage::from(grey(255).into_rgb32f()), ImageFormat::OpenExr);
        let error = opened("a.png", &exr).unwrap_err();
        assert!(error.contains("found OpenExr; allowed a whole PNG or JPEG"), "{error}");
        assert!(opened("a.png", b"text").unwrap_err().contains("some other layout"));
        let wide = encoded(image::GrayImage::new(8193, 1).into(), ImageFormat::Png);
        assert!(opened("a.png", &wide).unwrap_err().contains("found 8193 x 1 pixels"));
    }
}
