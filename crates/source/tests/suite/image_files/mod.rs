//! Statements of image files about their pixels: formats by depth, colour, orientation, window, page and exposure, against
//! independent formulas in f64; and files that lack pixels.

mod colours;
mod layouts;
mod radiance;

use crate::public_reports::stored_zlib;
use brdfc_source::Input;
use brdfc_source::meso::heights_from_exr;
use brdfc_source::photograph::{CodeValues, Image};
use brdfc_source::radiance_image::{from_exr, from_hdr};
use brdfc_source::rti_capture::RtiCapture;
use brdfc_source::tile_image::{open_colours, open_shares};
use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, ImageAttributes, IntegerBounds, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use moxcms::{ColorProfile, ToneReprCurve};
use std::collections::BTreeMap;
use std::io::Cursor;
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// Blocks of 16 x 16 pixels of one colour, which JPEG keeps up to rounding.
const BLOCK: usize = 16;
/// Columns and rows of blocks.
const BLOCKS: [usize; 2] = [3, 2];
const SIZE: [usize; 2] = [BLOCK * BLOCKS[0], BLOCK * BLOCKS[1]];

type Matrix = [[f64; 3]; 3];

/// Code value of a channel, 0 to 1, in the order of the file.
fn code(x: usize, y: usize, c: usize) -> f64 {
    let block = (y / BLOCK) * BLOCKS[0] + x / BLOCK;
    let levels = [[200, 40, 90], [30, 210, 60], [128, 128, 128], [20, 60, 220], [240, 235, 10], [90, 15, 160]];
    f64::from(levels[block][c]) / 255.0
}

fn codes<T>(of: impl Fn(f64) -> T) -> Vec<T> {
    (0..SIZE[0] * SIZE[1] * 3).map(|k| of(code(k / 3 % SIZE[0], k / 3 / SIZE[0], k % 3))).collect()
}

fn eight() -> Vec<u8> {
    codes(|v| (255.0 * v).round() as u8)
}

fn sixteen() -> Vec<u16> {
    codes(|v| (65535.0 * v).round() as u16)
}

// Formulas of the standards, independent of the program.

fn srgb(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn solve(m: Matrix, v: [f64; 3]) -> [f64; 3] {
    let det = |m: Matrix| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    std::array::from_fn(|c| {
        let mut replaced = m;
        (0..3).for_each(|r| replaced[r][c] = v[r]);
        det(replaced) / det(m)
    })
}

fn times(m: Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn xyz([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// Columns are XYZ of the primaries.
fn to_xyz(primaries: [[f64; 2]; 3], white: [f64; 2]) -> Matrix {
    let columns = primaries.map(|[x, y]| [x, y, 1.0 - x - y]);
    let m: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| columns[c][r]));
    let scale = solve(m, xyz(white));
    std::array::from_fn(|r| std::array::from_fn(|c| m[r][c] * scale[c]))
}

const REC709: [[f64; 2]; 3] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]];
const D65: [f64; 2] = [0.3127, 0.329];
const ADOBE: [[f64; 2]; 3] = [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06]];
const P3: [[f64; 2]; 3] = [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06]];
const PRO_PHOTO: [[f64; 2]; 3] = [[0.734_699, 0.265_301], [0.159_597, 0.840_403], [0.036_598, 0.000_105]];
const D50: [f64; 2] = [0.345_704, 0.358_54];
const ACES_CG: [[f64; 2]; 3] = [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044]];
const ACES_WHITE: [f64; 2] = [0.32168, 0.33767];
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// Linear RGB of Rec. 709 of linear RGB of other primaries.
fn to_rec709(rgb: [f64; 3], primaries: [[f64; 2]; 3], white: [f64; 2]) -> [f64; 3] {
    let cones = times(BRADFORD, times(to_xyz(primaries, white), rgb));
    let [from, to] = [white, D65].map(|white| times(BRADFORD, xyz(white)));
    let adapted = std::array::from_fn(|c| cones[c] * to[c] / from[c]);
    solve(to_xyz(REC709, D65), solve(BRADFORD, adapted))
}

/// A statement about colour, and what its code values mean.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Stated {
    Nothing,
    Linear,
    Adobe,
    P3,
    ProPhoto,
}

const ALL: [Stated; 5] = [Stated::Nothing, Stated::Linear, Stated::Adobe, Stated::P3, Stated::ProPhoto];

impl Stated {
    fn linear(self, v: [f64; 3]) -> [f64; 3] {
        let power = |g: f64| v.map(|v| v.powf(g));
        match self {
            Self::Nothing => v.map(srgb),
            Self::Linear => v,
            Self::Adobe => to_rec709(power(563.0 / 256.0), ADOBE, D65),
            Self::P3 => to_rec709(v.map(srgb), P3, D65),
            Self::ProPhoto => to_rec709(v.map(|v| if v < 1.0 / 32.0 { v / 16.0 } else { v.powf(1.8) }), PRO_PHOTO, D50),
        }
    }

    fn profile(self) -> Option<Vec<u8>> {
        let mut profile = match self {
            Self::Nothing => return None,
            Self::Linear => ColorProfile::new_srgb(),
            Self::Adobe => ColorProfile::new_adobe_rgb(),
            Self::P3 => ColorProfile::new_display_p3(),
            Self::ProPhoto => ColorProfile::new_pro_photo_rgb(),
        };
        if self == Self::Linear {
            profile.cicp = None;
            let linear = Some(ToneReprCurve::Lut(Vec::new()));
            (profile.red_trc, profile.green_trc, profile.blue_trc) = (linear.clone(), linear.clone(), linear);
        }
        Some(profile.encode().unwrap())
    }
}

type Chunks<'a> = &'a [(&'a [u8; 4], Vec<u8>)];

fn png_of(colour: png::ColorType, samples: &[u8], depth: png::BitDepth, chunks: Chunks<'_>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIZE[0] as u32, SIZE[1] as u32);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    let (palette, others): (Vec<_>, Vec<_>) = chunks.iter().partition(|(name, _)| *name == b"PLTE");
    palette.into_iter().for_each(|(_, data)| encoder.set_palette(data.clone()));
    let mut writer = encoder.write_header().unwrap();
    for (name, data) in others {
        writer.write_chunk(png::chunk::ChunkType(**name), data).unwrap();
    }
    writer.write_image_data(samples).unwrap();
    writer.finish().unwrap();
    bytes
}

fn png8(chunks: Chunks<'_>) -> Vec<u8> {
    png_of(png::ColorType::Rgb, &eight(), png::BitDepth::Eight, chunks)
}

fn png16(chunks: Chunks<'_>) -> Vec<u8> {
    let samples: Vec<u8> = sixteen().iter().flat_map(|v| v.to_be_bytes()).collect();
    png_of(png::ColorType::Rgb, &samples, png::BitDepth::Sixteen, chunks)
}

fn iccp(profile: &[u8]) -> (&'static [u8; 4], Vec<u8>) {
    // A stream of stored blocks.
    let mut stream = vec![b'x', 0, 0, 0x78, 0x01];
    let (mut a, mut b) = (1u32, 0u32);
    profile.iter().for_each(|byte| (a, b) = ((a + u32::from(*byte)) % 65521, (b + a + u32::from(*byte)) % 65521));
    let length = profile.len() as u16;
    stream.push(1);
    stream.extend([length.to_le_bytes(), (!length).to_le_bytes()].concat());
    stream.extend_from_slice(profile);
    stream.extend((b << 16 | a).to_be_bytes());
    (b"iCCP", stream)
}

fn gama(gamma: f64) -> (&'static [u8; 4], Vec<u8>) {
    (b"gAMA", ((1e5 * gamma).round() as u32).to_be_bytes().to_vec())
}

fn chrm(primaries: [[f64; 2]; 3], white: [f64; 2]) -> (&'static [u8; 4], Vec<u8>) {
    let [r, g, b] = primaries;
    let all = [white, r, g, b].concat();
    (b"cHRM", all.iter().flat_map(|v| ((1e5 * v).round() as u32).to_be_bytes()).collect())
}

/// EXIF metadata with an orientation, and with a colour space or index R03.
fn exif(orientation: u16, colour_space: u16, is_r03: bool) -> Vec<u8> {
    let entry = |tag: u16, kind: u16, count: u32, value: [u8; 4]| {
        [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value].concat()
    };
    let short = |v: u16| [v.to_le_bytes(), [0; 2]].concat().try_into().unwrap();
    let long = |v: u32| v.to_le_bytes();
    let mut bytes = [&b"II*\0"[..], &long(8), &2u16.to_le_bytes()].concat();
    bytes.extend(entry(0x112, 3, 1, short(orientation)));
    bytes.extend(entry(0x8769, 4, 1, long(38)));
    bytes.extend([&long(0)[..], &2u16.to_le_bytes()].concat());
    bytes.extend(entry(0xa001, 3, 1, short(colour_space)));
    bytes.extend(entry(0xa005, 4, 1, long(68)));
    bytes.extend([&long(0)[..], &1u16.to_le_bytes()].concat());
    bytes.extend(entry(1, 2, 4, if is_r03 { *b"R03\0" } else { *b"R98\0" }));
    bytes.extend(long(0));
    bytes
}

fn jpeg(segments: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100);
    let image = image::RgbImage::from_raw(SIZE[0] as u32, SIZE[1] as u32, eight()).unwrap();
    image.write_with_encoder(encoder).unwrap();
    let bytes = bytes.into_inner();
    let inserted = segments.iter().flat_map(|(marker, contents)| {
        [&[0xff, *marker][..], &(contents.len() as u16 + 2).to_be_bytes(), contents].concat()
    });
    bytes[..2].iter().copied().chain(inserted).chain(bytes[2..].iter().copied()).collect()
}

fn jpeg_exif(exif: Vec<u8>) -> (u8, Vec<u8>) {
    (0xe1, [b"Exif\0\0".to_vec(), exif].concat())
}

/// A profile in segments of up to `length` bytes.
fn jpeg_icc(profile: &[u8], length: usize) -> Vec<(u8, Vec<u8>)> {
    let parts = profile.chunks(length);
    let count = parts.len() as u8;
    parts.zip(1u8..).map(|(part, k)| (0xe2, [b"ICC_PROFILE\0", &[k, count][..], part].concat())).collect()
}

type Tags<'a> = &'a [(Tag, TagValue)];

enum TagValue {
    Bytes(Vec<u8>),
    Short(u16),
    Long(u32),
    Rationals(Vec<f64>),
}

fn tiff_page<C: colortype::ColorType>(
    encoder: &mut TiffEncoder<&mut Cursor<Vec<u8>>>,
    size: [usize; 2],
    samples: &[C::Inner],
    tags: Tags<'_>,
) where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut image = encoder.new_image::<C>(size[0] as u32, size[1] as u32).unwrap();
    for (tag, value) in tags {
        let tags = image.encoder();
        match value {
            TagValue::Bytes(bytes) => tags.write_tag(*tag, &bytes[..]).unwrap(),
            TagValue::Short(value) => tags.write_tag(*tag, *value).unwrap(),
            TagValue::Long(value) => tags.write_tag(*tag, *value).unwrap(),
            TagValue::Rationals(values) => {
                let of = |v: &f64| tiff::encoder::Rational { n: (1e6 * v).round() as u32, d: 1_000_000 };
                tags.write_tag(*tag, &values.iter().map(of).collect::<Vec<_>>()[..]).unwrap();
            }
        }
    }
    image.write_data(samples).unwrap();
}

fn tiff<C: colortype::ColorType>(samples: &[C::Inner], tags: Tags<'_>) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    tiff_page::<C>(&mut TiffEncoder::new(&mut bytes).unwrap(), SIZE, samples, tags);
    bytes.into_inner()
}

/// Reads a photograph of an RTI capture, and its colour with notes.
fn photograph(bytes: &[u8], extension: &str, codes: Option<CodeValues>) -> Result<(Image, String), String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(format!("a.{extension}")), bytes).unwrap();
    std::fs::write(folder.path().join("a.lp"), format!("1\na.{extension} 0 0 1\n")).unwrap();
    let capture = RtiCapture::open_as(folder.path(), codes).map_err(|error| error.to_string())?;
    let image = capture.image(0).map_err(|error| error.to_string())?;
    Ok((image, [&[capture.colour().to_owned()][..], capture.notes()].concat().join("; ")))
}

/// Largest difference from `linear` of the code values, clipped to 0 to 1 unless `wide`.
fn difference(image: &Image, linear: impl Fn([f64; 3]) -> [f64; 3], wide: bool) -> f64 {
    assert_eq!([image.width, image.height], SIZE);
    let pixels = image.pixels.iter().enumerate().map(|(at, pixel)| {
        let (x, y) = (at % SIZE[0], at / SIZE[0]);
        let expected = linear(std::array::from_fn(|c| code(x, y, c)));
        let clip = |v: f64| if wide { v } else { v.clamp(0.0, 1.0) };
        (0..3).map(|c| (f64::from(pixel[c]) - clip(expected[c])).abs()).fold(0.0, f64::max)
    });
    pixels.fold(0.0, f64::max)
}

/// The pixel of the file that an orientation puts at a place of the upright image.
fn place(orientation: u16, [x, y]: [usize; 2]) -> [usize; 2] {
    let [right, bottom] = SIZE.map(|side| side - 1);
    match orientation {
        1 => [x, y],
        2 => [right - x, y],
        3 => [right - x, bottom - y],
        4 => [x, bottom - y],
        5 => [y, x],
        6 => [y, bottom - x],
        7 => [right - y, bottom - x],
        _ => [right - y, x],
    }
}
