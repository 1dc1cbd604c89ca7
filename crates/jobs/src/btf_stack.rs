//! Writes images of BTF stacks. Layout: `crates/readers/src/btf_stack.md`.

use super::write::write_atomic;
use brdfc_readers::btf_stack::{ImageAngles, image_name};
use brdfc_readers::colour::encode_srgb_byte;
use brdfc_render::rendering::{Panel, rgb_png};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SpecificChannels, Vec2, WritableImage, f16,
};
use std::io::{Cursor, Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Image format of a stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StackFormat {
    /// 8-bit sRGB levels; values are clipped to [0, 1].
    Png,
    /// Linear 16-bit floats, losslessly compressed; values are clipped to the finite range.
    Exr,
}

impl StackFormat {
    /// File extension without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }
}

/// Writes one image into `folder` with a name by [`image_name`], and returns its path. Creates missing folders, and writes the
/// file atomically.
///
/// `number` is `light index * views + view index`. `pixels` are linear RGB (Rec. 709 primaries), 1 = a white diffuser
/// that faces the light, row by row from the top (y = 1), left to right. `size` is pixels per row, and rows.
///
/// # Errors
/// Returns an error if the file cannot be written, the number of pixels is 0 or does not match `size`, or a value is NaN or
/// infinite.
pub fn write_image(
    folder: &Path,
    number: usize,
    angles: ImageAngles,
    pixels: &[[f32; 3]],
    size: [usize; 2],
    format: StackFormat,
) -> std::io::Result<PathBuf> {
    let path = folder.join(image_name(number, angles, format.extension()));
    write_pixels(&path, pixels, size, format)?;
    Ok(path)
}

/// Writes an image of any stack atomically, and creates missing folders.
pub(crate) fn write_pixels(
    path: &Path,
    pixels: &[[f32; 3]],
    [width, height]: [usize; 2],
    format: StackFormat,
) -> std::io::Result<()> {
    let wrong = |text: String| Error::new(ErrorKind::InvalidInput, text);
    if [width, height].iter().any(|side| u32::try_from(*side).is_err()) {
        return Err(wrong(format!("an image of {width} x {height} pixels")));
    }
    if pixels.is_empty() || width.checked_mul(height) != Some(pixels.len()) {
        return Err(wrong(format!("{} pixels for an image of {width} x {height}", pixels.len())));
    }
    if let Some(at) = pixels.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite())) {
        return Err(wrong(format!("{:?} at pixel ({}, {})", pixels[at], at % width, at / width)));
    }
    let bytes = match format {
        StackFormat::Png => {
            let rgb = pixels.iter().flatten().map(|value| encode_srgb_byte(f64::from(*value))).collect();
            rgb_png(&Panel { width, height, rgb })
        }
        StackFormat::Exr => to_exr(pixels, width, height).map_err(Error::other)?,
    };
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent)?;
    }
    write_atomic(path, &bytes)
}

/// Losslessly compressed scan lines.
const ENCODING: Encoding =
    Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };

/// Writes an EXR file of 32-bit floats with named channels atomically, and creates missing folders. Pixels are row by row.
pub(crate) fn write_channels<const N: usize>(
    path: &Path,
    names: [&str; N],
    pixels: &[[f32; N]],
    size: [usize; 2],
) -> std::io::Result<()> {
    let channel = |(k, name): (usize, &str)| {
        AnyChannel::new(name, FlatSamples::F32(pixels.iter().map(|pixel| pixel[k]).collect()))
    };
    let channels = AnyChannels::sort(names.into_iter().enumerate().map(channel).collect());
    let layer = Layer::new((size[0], size[1]), LayerAttributes::default(), ENCODING, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(Error::other)?;
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent)?;
    }
    write_atomic(path, &bytes.into_inner())
}

fn to_exr(pixels: &[[f32; 3]], width: usize, height: usize) -> Result<Vec<u8>, exr::error::Error> {
    let limit = f16::MAX.to_f32();
    let pixel = |at: Vec2<usize>| {
        let [r, g, b] = pixels[at.y() * width + at.x()].map(|value| f16::from_f32(value.clamp(-limit, limit)));
        (r, g, b)
    };
    let layer = Layer::new((width, height), LayerAttributes::default(), ENCODING, SpecificChannels::rgb(pixel));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}
