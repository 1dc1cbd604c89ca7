//! Radiance images: OpenEXR and Radiance HDR.

use crate::InputError;
use crate::image_file::{self, Ask, GAMUT_ROUNDING, Purpose, Samples};
use crate::input::{Input, InputFile};
use crate::tile_image::FileImage;
use brdfc_formats::FormatError;
use image::ImageFormat;
use std::io::Cursor;

/// Maximum width and height, pixels.
pub const MAX_SIDES: [usize; 2] = [8192, 4096];

/// Linear RGB (Rec. 709 primaries), finite and not negative.
pub type RadianceImage = FileImage<3>;

/// Reads an image: a Radiance HDR if its extension is .hdr, else an EXR.
///
/// # Errors
/// Returns an error for files that cannot be read, or that [`from_exr`] and [`from_hdr`] reject.
pub fn open_radiance_image(input: impl Into<Input>) -> Result<RadianceImage, InputError> {
    let input = input.into();
    InputFile::of(&input, &mut ())?.parse(if input.extension()? == "hdr" { from_hdr } else { from_exr })
}

/// Reads a layer of an EXR with channels R, G and B, or Y: the only one, or else the one without a name or named as a beauty
/// pass. Pixels outside the data window are 0; alpha is ignored.
///
/// # Errors
/// Returns an error for files that are not EXR with such channels, for more than 8192 x 4096 pixels, and for
/// values that are negative or not finite.
pub fn from_exr(bytes: &[u8]) -> Result<RadianceImage, FormatError> {
    read(bytes, "EXR", "channels R, G and B, or Y", ImageFormat::OpenExr, &|size| check_size("EXR", size))
}

/// Reads a Radiance HDR (RGBE or XYZE), and undoes the exposure, colour correction and gamma that its header states.
///
/// # Errors
/// Returns an error for other files, and for more than 8192 x 4096 pixels.
pub fn from_hdr(bytes: &[u8]) -> Result<RadianceImage, FormatError> {
    let allowed = "a complete Radiance HDR of at most 8192 x 4096 pixels";
    read(bytes, "HDR", allowed, ImageFormat::Hdr, &|size| check_size("HDR", size))
}

fn read(
    bytes: &[u8],
    field: &'static str,
    allowed: &'static str,
    format: ImageFormat,
    check: &dyn Fn([usize; 2]) -> Result<(), FormatError>,
) -> Result<RadianceImage, FormatError> {
    let ask = Ask { purpose: Purpose::Colours(None), field, allowed, formats: &[format], check };
    let (mut header, raster) = image_file::read(Cursor::new(bytes), &ask)?;
    let [width, height] = raster.size;
    if let Samples::F32(samples) = &raster.samples
        && let Some(at) = samples.iter().position(|sample| !(sample.is_finite() && *sample >= 0.0))
    {
        let pixel = at / raster.channels;
        let channels = &samples[pixel * raster.channels..][..raster.channels];
        let found = format!("{channels:?} at pixel ({}, {})", pixel % width, pixel / width);
        return Err(FormatError::whole(field, found, "finite values of 0 or more"));
    }
    let mut pixels = header.linear_pixels(raster)?;
    let mut clipped = 0;
    for pixel in &mut pixels {
        let most = pixel.iter().copied().fold(0.0, f32::max);
        clipped += usize::from(pixel.iter().any(|value| *value < -GAMUT_ROUNDING as f32 * most));
        *pixel = pixel.map(|value| value.max(0.0));
    }
    header.note_clipped(clipped, pixels.len());
    Ok(RadianceImage { width, height, pixels, conversions: header.conversions() })
}

fn check_size(field: &'static str, [width, height]: [usize; 2]) -> Result<(), FormatError> {
    if width <= MAX_SIDES[0] && height <= MAX_SIDES[1] {
        return Ok(());
    }
    let found = format!("{width} x {height} pixels");
    Err(FormatError::whole(field, found, format!("at most {} x {}", MAX_SIDES[0], MAX_SIDES[1])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of uncompressed pixels of 4 bytes.
    fn hdr(width: u32, height: u32, rgbe: &[[u8; 4]]) -> Vec<u8> {
        let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
        [head.as_bytes(), rgbe.as_flattened()].concat()
    }

    #[test]
    fn radiance_files_are_read_and_cut_ones_refused() {
        // Mantissas of 1/256 below 2^(exponent - 128).
        let bytes = hdr(2, 1, &[[128, 64, 0, 129], [0, 0, 0, 0]]);
        let image = from_hdr(&bytes).unwrap();
        assert_eq!((image.width, image.height, image.pixels), (2, 1, vec![[1.0, 0.5, 0.0], [0.0; 3]]));
        for length in 0..bytes.len() {
            assert!(from_hdr(&bytes[..length]).is_err(), "{length}");
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0xff;
            drop(from_hdr(&changed));
        }
        let error = from_hdr(&hdr(9000, 5000, &[])).unwrap_err();
        assert_eq!(error.field, "HDR");
    }
}
