//! Polynomial texture maps as inputs.

use crate::image_file::check_jpeg;
use crate::input::InputFile;
use crate::{Input, InputError};
use brdfc_core::words::one_line;
use brdfc_formats::memory::filled;
use brdfc_readers::ptm::{Ptm, TERMS};
use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};
use std::io::Cursor;

/// Extension of the files.
pub const EXTENSION: &str = "ptm";

/// Reads a polynomial texture map.
///
/// # Errors
/// Returns an error for files that cannot be read or that [`Ptm::from_bytes`] rejects.
pub fn open_ptm(input: &Input) -> Result<Ptm, InputError> {
    InputFile::of(input, &mut ())?.parse(|bytes| Ptm::from_bytes(bytes, &decoded))
}

/// Decodes a plane of a compressed map, which must have this width and height.
fn decoded(jpeg: &[u8], size: [u32; 2]) -> Result<Vec<u8>, String> {
    let decoder = JpegDecoder::new(Cursor::new(jpeg)).map_err(|error| one_line(&error))?;
    let (width, height) = decoder.dimensions();
    if [width, height] != size {
        return Err(format!("{width} x {height} pixels"));
    }
    if decoder.color_type() != ColorType::L8 {
        return Err("colours".to_owned());
    }
    check_jpeg(jpeg)?;
    let mut samples = filled("pixels", width as usize * height as usize, 0).map_err(|error| error.to_string())?;
    decoder.read_image(&mut samples).map_err(|error| one_line(&error))?;
    Ok(samples)
}

/// Facts about a polynomial texture map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct PtmFacts {
    /// Format in the file: `PTM_FORMAT_RGB` or `PTM_FORMAT_LRGB`, or compressed, such as `PTM_FORMAT_JPEG_LRGB`.
    pub format: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Scales of the coefficients of u², v², uv, u, v and 1, in 8-bit levels.
    pub scale: [f32; TERMS],
    /// Stored bytes that mean 0.
    pub bias: [i32; TERMS],
}

impl PtmFacts {
    /// Facts about a map.
    pub fn new(ptm: &Ptm) -> Self {
        Self { format: ptm.format().to_owned(), size: ptm.size(), scale: ptm.scale(), bias: ptm.bias() }
    }

    /// Lines for people: names and values.
    pub fn summary(&self) -> Vec<(&'static str, String)> {
        let Self { format, size: [width, height], scale, bias } = self;
        vec![
            ("kind", "polynomial texture map".to_owned()),
            ("format", format.clone()),
            ("pixels", format!("{width} x {height}")),
            ("scale of u², v², uv, u, v, 1", scale.map(|number| number.to_string()).join(" ")),
            ("bias", bias.map(|number| number.to_string()).join(" ")),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_truncated_plane_is_refused() {
        let mut jpeg = Cursor::new(Vec::new());
        image::GrayImage::from_pixel(9, 5, image::Luma([77])).write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
        let jpeg = jpeg.into_inner();
        let samples = decoded(&jpeg, [9, 5]).unwrap();
        assert!(samples.len() == 45 && samples.iter().all(|sample| sample.abs_diff(77) < 3), "{samples:?}");
        assert!(decoded(&jpeg[..jpeg.len() - 2], [9, 5]).unwrap_err().contains("the JPEG is truncated"));
    }
}
