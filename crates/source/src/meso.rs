//! Meso-geometry from files: meshes and height maps.

use super::input::{Input, InputFile};
use super::kind::Kind;
use crate::InputError;
use crate::image_file::{self, Ask, Purpose, Samples, collected};
use brdfc_formats::FormatError;
use brdfc_readers::meso::{TriangleMesh, obj, ply};
use image::ImageFormat;
use std::io::Cursor;
use std::ops::RangeInclusive;

/// Valid numbers of columns and rows of a height map.
pub const HEIGHT_MAP_SIDE: RangeInclusive<usize> = 4..=8192;
/// Maximum number of pixels of a height map: each is a vertex, and larger ones cannot be flattened in a reasonable
/// time.
pub const HEIGHT_MAP_PIXELS: usize = 1 << 20;

/// Geometry of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum MesoInput {
    /// A mesh before welding.
    Mesh(TriangleMesh),
    /// Heights over the whole tile.
    Heights(HeightMap),
}

/// A height for each pixel; the pixels cover the tile.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    /// Pixels per row, along x.
    pub width: usize,
    /// Rows, along y.
    pub height: usize,
    /// Row by row from the top of the image, which is `y = 1`; finite. 0 to 1 from PNG, as stored from EXR.
    pub heights: Vec<f32>,
    /// Statements of the file about its pixels, and what was done.
    pub conversions: Vec<String>,
}

/// Opens a mesh (`.obj`, `.ply`) or a height map (`.png`, `.exr`).
///
/// # Errors
/// Returns an error for files that cannot be read or violate their layout, and for other extensions.
pub fn open_meso(input: impl Into<Input>) -> Result<MesoInput, InputError> {
    let input = input.into();
    let extension = input.extension()?;
    let parse: fn(&[u8]) -> Result<MesoInput, FormatError> = match extension.as_str() {
        "obj" => |bytes| obj::from_bytes(bytes).map(MesoInput::Mesh),
        "ply" => |bytes| ply::from_bytes(bytes).map(MesoInput::Mesh),
        "png" => |bytes| heights_from_png(bytes).map(MesoInput::Heights),
        "exr" => |bytes| heights_from_exr(bytes).map(MesoInput::Heights),
        _ => {
            let allowed = ".obj or .ply (mesh), .png or .exr (height map), .btf or a folder (BTF), or synth:NAME \
                           (structure)";
            return Err(Kind::of(&input)?.refused(&input, allowed));
        }
    };
    let mut listener = ();
    let file = InputFile::of(&input, &mut listener)?;
    if extension == "obj" { file.parse_text(parse) } else { file.parse(parse) }
}

fn check_size(field: &'static str, width: usize, height: usize) -> Result<(), FormatError> {
    let sides = HEIGHT_MAP_SIDE.contains(&width) && HEIGHT_MAP_SIDE.contains(&height);
    if sides && width * height <= HEIGHT_MAP_PIXELS {
        return Ok(());
    }
    let (least, most) = (HEIGHT_MAP_SIDE.start(), HEIGHT_MAP_SIDE.end());
    let allowed = format!("{least} to {most} per side, and at most {HEIGHT_MAP_PIXELS} in all, such as 1024 x 1024");
    Err(FormatError::whole(field, format!("{width} x {height} pixels"), allowed))
}

/// Reads stored values of a grey PNG, divided by the largest, 255 or 65535, without a transfer function.
///
/// # Errors
/// Returns an error for files that are not PNG, sizes beyond [`HEIGHT_MAP_SIDE`] and [`HEIGHT_MAP_PIXELS`], colour,
/// palettes, transparency, and fewer than 8 bits.
pub fn heights_from_png(bytes: &[u8]) -> Result<HeightMap, FormatError> {
    read("PNG", "a grey PNG of 8 or 16 bits", ImageFormat::Png, bytes)
}

/// Reads a channel of an EXR: Y, else R, else its only one. Pixels outside the data window are 0.
///
/// # Errors
/// Returns an error for files that are not EXR, sizes beyond [`HEIGHT_MAP_SIDE`] and [`HEIGHT_MAP_PIXELS`], missing
/// channels, and values that are not finite.
pub fn heights_from_exr(bytes: &[u8]) -> Result<HeightMap, FormatError> {
    read("EXR", "a complete EXR without deep data", ImageFormat::OpenExr, bytes)
}

fn read(
    field: &'static str,
    allowed: &'static str,
    format: ImageFormat,
    bytes: &[u8],
) -> Result<HeightMap, FormatError> {
    let check = |[width, height]: [usize; 2]| check_size(field, width, height);
    let ask = Ask { purpose: Purpose::Heights, field, allowed, formats: &[format], check: &check };
    let (header, raster) = image_file::read(Cursor::new(bytes), &ask)?;
    let [width, height] = raster.size;
    let heights: Vec<f32> = match raster.samples {
        Samples::U8(samples) => collected(samples.iter().step_by(raster.channels).map(|v| f32::from(*v) / 255.0))?,
        Samples::U16(samples) => collected(samples.iter().step_by(raster.channels).map(|v| f32::from(*v) / 65535.0))?,
        Samples::F32(samples) => samples,
    };
    if let Some(pixel) = heights.iter().position(|value| !value.is_finite()) {
        let found = format!("{} at pixel ({}, {})", heights[pixel], pixel % width, pixel / width);
        return Err(FormatError::whole(field, found, "finite values"));
    }
    Ok(HeightMap { width, height, heights, conversions: header.conversions() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};

    fn png_of(width: u32, height: u32, colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == png::ColorType::Indexed {
            encoder.set_palette(vec![0; 3 * 256]);
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        bytes
    }

    fn exr_of(width: usize, height: usize, channels: &[&str], value: impl Fn(usize, usize) -> f32) -> Vec<u8> {
        let list = channels
            .iter()
            .enumerate()
            .map(|(c, name)| {
                AnyChannel::new(*name, FlatSamples::F32((0..width * height).map(|i| value(c, i)).collect()))
            })
            .collect();
        let encoding = Encoding::SMALL_LOSSLESS;
        let layer = Layer::new((width, height), LayerAttributes::default(), encoding, AnyChannels::sort(list));
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn grey(data: &[u8]) -> Vec<u8> {
        png_of(5, 4, png::ColorType::Grayscale, png::BitDepth::Eight, data)
    }

    #[test]
    fn grey_pngs_are_heights_from_the_top() {
        let values: Vec<u8> = (0..20).map(|k| 13 * k).collect();
        let map = heights_from_png(&grey(&values)).unwrap();
        assert_eq!((map.width, map.height), (5, 4));
        assert!(map.heights.iter().zip(&values).all(|(h, v)| *h == f32::from(*v) / 255.0));
        let wide: Vec<u8> = (0..20u16).flat_map(|k| (3449 * k).to_be_bytes()).collect();
        let map = heights_from_png(&png_of(5, 4, png::ColorType::Grayscale, png::BitDepth::Sixteen, &wide)).unwrap();
        assert_eq!((map.heights[0], map.heights[1]), (0.0, 3449.0 / 65535.0));
        assert!((map.heights[19] - 0.999_939).abs() < 1e-6);
    }

    #[test]
    fn other_pngs_are_refused() {
        use png::{BitDepth, ColorType};
        let error = |width, height, colour, depth, length| {
            heights_from_png(&png_of(width, height, colour, depth, &vec![0; length])).unwrap_err().to_string()
        };
        let allowed = "expected a grey PNG of 8 or 16 bits";
        for (colour, depth, length, found) in [
            (ColorType::Rgb, BitDepth::Eight, 48, "RGB, 8 bits"),
            (ColorType::Rgba, BitDepth::Sixteen, 128, "RGB with transparency, 16 bits"),
            (ColorType::GrayscaleAlpha, BitDepth::Eight, 32, "grey with transparency, 8 bits"),
            (ColorType::Indexed, BitDepth::Eight, 16, "a palette, 8 bits"),
            (ColorType::Grayscale, BitDepth::Four, 8, "grey, 4 bits"),
        ] {
            assert_eq!(error(4, 4, colour, depth, length), format!("PNG: found {found}, {allowed}"));
        }
        let sizes = error(3, 4, ColorType::Grayscale, BitDepth::Eight, 12);
        let limits = "expected 4 to 8192 per side, and at most 1048576 in all, such as 1024 x 1024";
        assert_eq!(sizes, format!("PNG: found 3 x 4 pixels, {limits}"));
        let large = error(1024, 1025, ColorType::Grayscale, BitDepth::Eight, 1024 * 1025);
        assert_eq!(large, format!("PNG: found 1024 x 1025 pixels, {limits}"));
        assert_eq!(HEIGHT_MAP_PIXELS, 1024 * 1024);
        assert!(error(4, 8193, ColorType::Grayscale, BitDepth::Eight, 4 * 8193).contains("4 x 8193"));
        assert!(heights_from_png(b"GIF89a").unwrap_err().to_string().ends_with(allowed));
    }

    #[test]
    fn a_few_bytes_are_no_large_png() {
        let mut bytes = grey(&[0; 20]);
        // The header says 1024 x 1024; its checksum follows.
        bytes[16..24].copy_from_slice(&[0, 0, 4, 0, 0, 0, 4, 0]);
        let mut crc = u32::MAX;
        for byte in &bytes[12..29] {
            crc ^= u32::from(*byte);
            (0..8).for_each(|_| crc = (crc >> 1) ^ (0xedb8_8320 * (crc & 1)));
        }
        bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
        let error = heights_from_png(&bytes).unwrap_err().to_string();
        assert!(error.contains("bytes for 1024 x 1024 pixels, expected 1017 or more"), "{error}");
    }

    #[test]
    fn exrs_are_heights_as_they_are() {
        let value = |c: usize, i: usize| 100.0 * c as f32 + i as f32 - 7.5;
        for (channels, chosen) in [(&["B", "R", "Y"][..], 2), (&["B", "G", "R"], 2), (&["Z"], 0), (&["A", "Y"], 1)] {
            let map = heights_from_exr(&exr_of(5, 4, channels, value)).unwrap();
            assert_eq!((map.width, map.height), (5, 4));
            assert!((0..20).all(|i| map.heights[i] == value(chosen, i)), "{channels:?}");
        }
    }

    #[test]
    fn other_exrs_are_refused() {
        let error = |width, height, channels: &[&str], value: f32| {
            let at = |_: usize, i: usize| if i == 7 { value } else { 0.0 };
            heights_from_exr(&exr_of(width, height, channels, at)).unwrap_err().to_string()
        };
        assert_eq!(error(5, 4, &["Y"], f32::NAN), "EXR: found NaN at pixel (2, 1), expected finite values");
        assert!(error(5, 4, &["Y"], f32::NEG_INFINITY).contains("-inf at pixel (2, 1)"));
        let channels = error(5, 4, &["A", "B"], 0.0);
        assert_eq!(channels, "EXR: found channels A, B, expected an EXR with a channel Y or R, or with one channel");
        let whole = exr_of(5, 4, &["Y"], |_, _| 0.0);
        let cut = heights_from_exr(&whole[..whole.len() / 2]).unwrap_err().to_string();
        assert!(cut.ends_with("expected a complete EXR without deep data"), "{cut}");
        assert!(error(5, 3, &["Y"], 0.0).contains("5 x 3 pixels, expected 4 to 8192 per side"));
        assert!(error(2048, 513, &["Y"], 0.0).contains("2048 x 513 pixels, expected 4 to 8192 per side, and at most"));
        assert!(error(8193, 4, &["Y"], 0.0).contains("8193 x 4"));
    }

    #[test]
    fn no_change_of_bytes_panics() {
        let png = grey(&(0..20).map(|k| 11 * k).collect::<Vec<u8>>());
        let exr = exr_of(5, 4, &["R", "Y"], |c, i| (c + i) as f32);
        for (bytes, is_png) in [(png, true), (exr, false)] {
            let parse = if is_png { heights_from_png } else { heights_from_exr };
            let mut refused = 0;
            let mut check = |bytes: &[u8]| match parse(bytes) {
                Ok(map) => assert_eq!(map.heights.len(), map.width * map.height),
                Err(_) => refused += 1,
            };
            for at in 0..bytes.len() {
                check(&bytes[..at]);
                let mut changed = bytes.to_vec();
                for flip in [0x01, 0x10, 0x80, 0xff] {
                    changed[at] = bytes[at] ^ flip;
                    check(&changed);
                }
            }
            assert!(refused > bytes.len(), "{refused}");
        }
    }

    #[test]
    fn files_are_identified_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let open = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            open_meso(&path)
        };
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let Ok(MesoInput::Mesh(mesh)) = open("a.OBJ", obj) else { panic!("a mesh") };
        let mut ply = Vec::new();
        ply::write(&mut ply, &mesh).unwrap();
        assert_eq!(open("a.ply", &ply).unwrap(), MesoInput::Mesh(mesh));
        let exr = exr_of(4, 4, &["Y"], |_, _| 2.0);
        for (name, bytes, height) in [("a.png", grey(&[255; 20]), 1.0), ("a.exr", exr, 2.0)] {
            let Ok(MesoInput::Heights(map)) = open(name, &bytes) else { panic!("{name}") };
            assert!(map.heights.iter().all(|h| *h == height));
        }
        let error = |name: &str, bytes: &[u8]| open(name, bytes).unwrap_err().to_string();
        assert!(error("b.obj", b"f 1 2 3").contains("b.obj: line 1, face: found vertex 3"));
        assert!(error("b.stl", obj).contains("b.stl: file name: found extension .stl, expected .obj or .ply"));
        assert!(error("b", obj).contains("file name: no extension; expected .obj"));
        assert!(error("b.ply", obj).contains("b.ply: line 1, first line"));
        let missing = open_meso(folder.path().join("none.obj")).unwrap_err();
        assert!(matches!(missing, InputError::Io { .. }));
        let no_file = open_meso(folder.path()).unwrap_err().to_string();
        assert!(no_file.contains("input: found a BTF, expected .obj or .ply (mesh), "), "{no_file}");
    }
}
