//! Images that colour a surface or say where its materials are.

use super::open::InputError;
use brdfc_formats::FormatError;
use brdfc_formats::colour::decode_srgb;
use image::{ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Most pixels along a side.
const MAX_SIZE: u32 = 8192;

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
pub fn open_tile_image(path: &Path) -> Result<FileImage, InputError> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|error| InputError::Io { name: name.clone(), error })?;
    let wrong = |found: String| InputError::Format {
        name: name.clone(),
        error: FormatError::whole("image", found, "a whole PNG or JPEG of at most 8192 pixels along a side"),
    };
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| InputError::Io { name: name.clone(), error })?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIZE), Some(MAX_SIZE));
    reader.limits(limits);
    let decoded = reader.decode().map_err(|error| wrong(error.to_string()))?;
    let has_alpha = decoded.color().has_alpha();
    let image = decoded.into_rgba32f();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let channels = image.pixels().map(|pixel| pixel.0).collect();
    Ok(FileImage { width, height, channels, has_alpha })
}
