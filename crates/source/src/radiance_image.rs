//! Radiance images: OpenEXR and Radiance HDR.

use crate::InputError;
use crate::exr_header::exr_headers;
use crate::input::{Input, InputFile};
use crate::tile_image::FileImage;
use brdfc_core::words::one_line;
use brdfc_formats::FormatError;
use exr::prelude::{ReadChannels, ReadLayers, read};
use image::{ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Maximum width and height, pixels.
pub const MAX_SIDES: [usize; 2] = [8192, 4096];

/// Linear RGB, finite and not negative.
pub type RadianceImage = FileImage<3>;

/// Reads an image: a Radiance HDR if its extension is .hdr, else an EXR.
///
/// # Errors
/// Returns an error for files that cannot be read, or that [`from_exr`] and [`from_hdr`] reject.
pub fn open_radiance_image(input: impl Into<Input>) -> Result<RadianceImage, InputError> {
    let input = input.into();
    InputFile::of(&input, &mut ())?.parse(if input.extension()? == "hdr" { from_hdr } else { from_exr })
}

/// Reads RGB of the first layer of an EXR that has these channels.
///
/// # Errors
/// Returns an error for files that are not EXR with channels R, G and B, for more than 8192 x 4096 pixels, and for
/// values that are negative or not finite.
pub fn from_exr(bytes: &[u8]) -> Result<RadianceImage, FormatError> {
    let broken =
        |error: exr::error::Error| FormatError::whole("EXR", one_line(&error), "channels R, G and B").problem();
    // Sizes are checked first; pixels are allocated only if the image is small enough.
    for header in exr_headers(Cursor::new(bytes), "channels R, G and B")? {
        check_size("EXR", header.layer_size.x(), header.layer_size.y())?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| RadianceImage { width: size.x(), height: size.y(), pixels: vec![[0.0; 3]; size.x() * size.y()] },
            |image: &mut RadianceImage, at, (r, g, b): (f32, f32, f32)| {
                image.pixels[at.y() * image.width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?
        .layer_data
        .channel_data
        .pixels;
    checked("EXR", image)
}

/// Reads a Radiance HDR (RGBE).
///
/// # Errors
/// Returns an error for other files, and for more than 8192 x 4096 pixels.
pub fn from_hdr(bytes: &[u8]) -> Result<RadianceImage, FormatError> {
    let broken = |error: image::ImageError| {
        let allowed = format!("a complete Radiance HDR of at most {} x {} pixels", MAX_SIDES[0], MAX_SIDES[1]);
        FormatError::whole("HDR", one_line(&error), allowed).problem()
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Hdr);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDES[0] as u32), Some(MAX_SIDES[1] as u32));
    reader.limits(limits);
    let image = reader.decode().map_err(broken)?.into_rgb32f();
    let (width, height) = (image.width() as usize, image.height() as usize);
    check_size("HDR", width, height)?;
    checked("HDR", RadianceImage { width, height, pixels: image.pixels().map(|pixel| pixel.0).collect() })
}

fn check_size(field: &'static str, width: usize, height: usize) -> Result<(), FormatError> {
    if (1..=MAX_SIDES[0]).contains(&width) && (1..=MAX_SIDES[1]).contains(&height) {
        return Ok(());
    }
    let found = format!("{width} x {height} pixels");
    Err(FormatError::whole(field, found, format!("at most {} x {}", MAX_SIDES[0], MAX_SIDES[1])))
}

fn checked(field: &'static str, image: RadianceImage) -> Result<RadianceImage, FormatError> {
    let wrong = image.pixels.iter().position(|pixel| pixel.iter().any(|c| !(c.is_finite() && *c >= 0.0)));
    let Some(pixel) = wrong else { return Ok(image) };
    let place = format!("pixel ({}, {})", pixel % image.width, pixel / image.width);
    let found = format!("{:?} at {place}", image.pixels[pixel]);
    Err(FormatError::whole(field, found, "finite values of 0 or more"))
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
