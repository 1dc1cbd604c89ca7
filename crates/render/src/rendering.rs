//! Encoding of images: PNG for display, EXR for values.

use crate::adaptive::RateImage;
use brdfc_formats::FormatError;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_metrics::image::{LinearImage, delta_e_map};
use brdfc_readers::colour::encode_srgb_byte;
use brdfc_source::radiance_image;
use exr::prelude::{
    Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels, Vec2, WritableImage,
};
use std::io::Cursor;

/// Columns between the panels of a sheet.
const GAP: usize = 4;
/// Grey of the gap, sRGB-encoded.
const GAP_GREY: u8 = 128;

/// 8-bit RGB, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Panel {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes per pixel, sRGB-encoded.
    pub rgb: Vec<u8>,
}

/// Displayed image: `clamp(exposure * radiance, 0, 1)` over the background, sRGB-encoded. NaN is black.
pub fn to_panel(image: &LinearImage, exposure: f64) -> Panel {
    let behind = |k: usize, coverage: f32| f64::from(image.background[k] * (1.0 - coverage));
    let encode = |(pixel, coverage): (&[f32; 3], &f32)| {
        let shown = |k: usize| (f64::from(pixel[k]) * exposure).min(1.0) + behind(k, *coverage);
        [0, 1, 2].map(|k| encode_srgb_byte(shown(k)))
    };
    let rgb = image.pixels.iter().zip(&image.coverage).flat_map(encode).collect();
    Panel { width: image.width, height: image.height, rgb }
}

/// PNG of [`to_panel`], marked as sRGB and with the exposure in a text chunk.
pub fn to_png(image: &LinearImage, exposure: f64) -> Vec<u8> {
    let panel = to_panel(image, exposure);
    encode_png([panel.width, panel.height], png::ColorType::Rgb, &panel.rgb, Some(("Exposure", exposure.to_string())))
}

/// PNG of a panel.
pub fn rgb_png(panel: &Panel) -> Vec<u8> {
    encode_png([panel.width, panel.height], png::ColorType::Rgb, &panel.rgb, None)
}

/// Greyscale PNG of a rate image, one 8-bit pixel per tile. Its values are numbers, not colours; a text chunk explains them.
pub fn rates_png(rates: &RateImage) -> Vec<u8> {
    let size = [rates.width, rates.height];
    let text = format!("D3D12_SHADING_RATE of tiles of {0} x {0} pixels", rates.tile);
    encode_png(size, png::ColorType::Grayscale, &rates.texels, Some(("Comment", text)))
}

fn encode_png(size: [usize; 2], colour: png::ColorType, data: &[u8], text: Option<(&str, String)>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0] as u32, size[1] as u32);
    encoder.set_color(colour);
    encoder.set_depth(png::BitDepth::Eight);
    if colour == png::ColorType::Rgb {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    if let Some((keyword, text)) = text {
        encoder.add_text_chunk(keyword.to_owned(), text).expect("a plain keyword");
    }
    let mut writer = encoder.write_header().expect("memory takes all bytes");
    writer.write_image_data(data).expect("as many bytes as pixels need");
    writer.finish().expect("memory takes all bytes");
    bytes
}

/// EXR of linear RGB as 32-bit floats, losslessly compressed.
pub fn to_exr(image: &LinearImage) -> Vec<u8> {
    let pixel = |at: Vec2<usize>| {
        let [r, g, b] = image.pixels[at.y() * image.width + at.x()];
        (r, g, b)
    };
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer =
        Layer::new((image.width, image.height), LayerAttributes::default(), encoding, SpecificChannels::rgb(pixel));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("memory takes all bytes");
    bytes.into_inner()
}

/// Reads the RGB of an EXR: see [`radiance_image::from_exr`].
///
/// # Errors
/// Returns the errors of [`radiance_image::from_exr`], for example for files that are not EXR.
pub fn from_exr(bytes: &[u8]) -> Result<LinearImage, FormatError> {
    let image = radiance_image::from_exr(bytes)?;
    let coverage = vec![1.0; image.pixels.len()];
    Ok(LinearImage { pixels: image.pixels, coverage, ..LinearImage::black(image.width, image.height) })
}

/// Corners of the ramp of [`heat_map`], linear in sRGB-encoded values, 0 to 255: dark, purple, orange, pale yellow.
pub const RAMP: [[f64; 3]; 5] =
    [[6.0, 6.0, 14.0], [74.0, 18.0, 110.0], [186.0, 50.0, 84.0], [247.0, 140.0, 28.0], [252.0, 250.0, 180.0]];

/// ΔE at the light end of the colour scale of difference images.
pub const DELTA_E_FULL_SCALE: f64 = 10.0;

/// Values as colours from dark (0) to pale yellow (`full_scale` and more).
pub fn heat_map(values: &[f32], width: usize, height: usize, full_scale: f64) -> Panel {
    Panel { width, height, rgb: values.iter().flat_map(|value| ramp(f64::from(*value) / full_scale)).collect() }
}

/// ΔE per pixel of an image against its reference as a [`heat_map`] up to [`DELTA_E_FULL_SCALE`].
pub fn difference_panel(image: &LinearImage, reference: &LinearImage, exposure: f64) -> Panel {
    heat_map(&delta_e_map(image, reference, exposure), image.width, image.height, DELTA_E_FULL_SCALE)
}

/// Logarithms of values as colours from dark (`octaves` octaves below the maximum, and less) to pale yellow (the
/// maximum).
pub fn octave_map(values: &[f32], width: usize, height: usize, octaves: f32) -> Panel {
    let largest = values.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let shares: Vec<f32> = values.iter().map(|value| 1.0 + (value / largest).log2() / octaves).collect();
    heat_map(&shares, width, height, 1.0)
}

/// A bandwidth map, eight octaves below its largest value: for lobes one block per incoming direction, otherwise one
/// image.
pub fn bandwidth_panel(map: &BandwidthMap) -> Panel {
    let [width, height] = map.size().map(|side| side as usize);
    octave_map(&map.values(), width, height, 8.0)
}

fn ramp(share: f64) -> [u8; 3] {
    let position = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let lower = (position as usize).min(RAMP.len() - 2);
    let t = position - lower as f64;
    [0, 1, 2].map(|k| ((1.0 - t) * RAMP[lower][k] + t * RAMP[lower + 1][k]).round() as u8)
}

/// Panels of one height side by side, with a grey gap.
///
/// # Panics
/// If heights differ.
pub fn sheet(panels: &[Panel]) -> Panel {
    let height = panels.first().map_or(0, |panel| panel.height);
    assert!(panels.iter().all(|panel| panel.height == height), "panels of one height");
    let width = panels.iter().map(|panel| panel.width).sum::<usize>() + GAP * panels.len().saturating_sub(1);
    let mut rgb = Vec::with_capacity(3 * width * height);
    for row in 0..height {
        for (number, panel) in panels.iter().enumerate() {
            if number > 0 {
                rgb.extend([GAP_GREY; 3 * GAP]);
            }
            rgb.extend(&panel.rgb[3 * panel.width * row..3 * panel.width * (row + 1)]);
        }
    }
    Panel { width, height, rgb }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> LinearImage {
        let (width, height) = (23, 9);
        let value = |i: usize, k: usize| ((i * 37 + k * 101) % 256) as f32 / 200.0;
        let pixels: Vec<[f32; 3]> = (0..width * height).map(|i| [0, 1, 2].map(|k| value(i, k))).collect();
        LinearImage { width, height, pixels, coverage: vec![1.0; width * height], background: [0.0; 3] }
    }

    #[test]
    fn a_png_holds_srgb_values() {
        let image = image();
        let bytes = to_png(&image, 0.8);
        assert_eq!(bytes, to_png(&image, 0.8));
        let read = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).unwrap().into_rgb8();
        assert_eq!((read.width(), read.height()), (23, 9));
        for (pixel, linear) in read.pixels().zip(&image.pixels) {
            for k in 0..3 {
                // The inverse transfer function, within half a step.
                let encoded = f64::from(pixel.0[k]) / 255.0;
                let back = if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
                let expected = (f64::from(linear[k]) * 0.8).clamp(0.0, 1.0);
                assert!((back - expected).abs() < 0.0046, "{pixel:?} {linear:?}");
            }
        }
        assert!(bytes.windows(8).any(|w| w == b"Exposure") && bytes.windows(4).any(|w| w == b"sRGB"));
    }

    #[test]
    fn an_exr_holds_the_values_themselves() {
        let image = image();
        let bytes = to_exr(&image);
        assert_eq!(bytes, to_exr(&image));
        let read = from_exr(&bytes).unwrap();
        assert_eq!(read.pixels, image.pixels);
    }

    #[test]
    fn broken_exrs_are_errors() {
        let bytes = to_exr(&image());
        for length in 0..bytes.len() {
            assert!(from_exr(&bytes[..length]).is_err(), "{length}");
        }
        let mut refused = 0;
        for at in 0..bytes.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut changed = bytes.clone();
                changed[at] ^= flip;
                refused += usize::from(from_exr(&changed).is_err());
            }
        }
        assert!(refused > 100, "{refused}");
        let mut negative = image();
        negative.pixels[30][1] = -0.5;
        let error = from_exr(&to_exr(&negative)).unwrap_err().to_string();
        assert!(error.contains("(7, 1)"), "{error}");
        let wide = LinearImage::black(radiance_image::MAX_SIDES[0] + 1, 1);
        assert!(from_exr(&to_exr(&wide)).unwrap_err().to_string().contains("8193"));
    }

    #[test]
    fn the_lightness_of_the_ramp_increases() {
        use palette::{IntoColor, Lab, Srgb};
        let lightness = |i: i32| {
            let [r, g, b] = ramp(f64::from(i) / 100.0).map(|c| f64::from(c) / 255.0);
            let lab: Lab<palette::white_point::D65, f64> = Srgb::new(r, g, b).into_linear().into_color();
            lab.l
        };
        assert!((1..=100).all(|i| lightness(i) >= lightness(i - 1) - 1e-9));
        assert!(lightness(100) - lightness(0) > 85.0);
        assert_eq!(ramp(7.0), ramp(1.0));
    }

    #[test]
    fn panels_are_side_by_side() {
        let panel = |value: u8, width: usize| Panel { width, height: 2, rgb: vec![value; 6 * width] };
        let sheet = sheet(&[panel(1, 3), panel(2, 5)]);
        assert_eq!((sheet.width, sheet.height, sheet.rgb.len()), (12, 2, 72));
        let row: Vec<u8> = sheet.rgb[36..].iter().step_by(3).copied().collect();
        assert_eq!(row, [1, 1, 1, 128, 128, 128, 128, 2, 2, 2, 2, 2]);
    }
}
