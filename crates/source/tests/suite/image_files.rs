//! Statements of image files about their pixels: formats by depth, colour, orientation, window, page and exposure, against
//! independent formulas in f64; and files that lack pixels.

use super::public_reports::stored_zlib;
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

#[test]
fn colours_are_converted_as_the_file_states_them() {
    let profile_tag = |stated: Stated| stated.profile().map(|icc| (Tag::IccProfile, TagValue::Bytes(icc)));
    for stated in ALL {
        let icc = stated.profile();
        let chunks: Vec<_> = icc.iter().map(|icc| iccp(icc)).collect();
        let segments = icc.as_ref().map_or(Vec::new(), |icc| jpeg_icc(icc, 100));
        let tags: Vec<_> = profile_tag(stated).into_iter().collect();
        let floats: Vec<f32> = codes(|v| v as f32);
        // Code values of a JPEG are off by rounding in YCbCr.
        let files = [
            ("png", 8, png8(&chunks), 1e-3),
            ("png", 16, png16(&chunks), 1e-3),
            ("jpg", 8, jpeg(&segments), 0.03),
            ("tif", 8, tiff::<colortype::RGB8>(&eight(), &tags), 1e-3),
            ("tif", 16, tiff::<colortype::RGB16>(&sixteen(), &tags), 1e-3),
            ("tif", 32, tiff::<colortype::RGB32Float>(&floats, &tags), 1e-3),
        ];
        for (extension, depth, bytes, tolerance) in files {
            let name = format!("{stated:?} {extension} {depth}");
            let (image, found) = photograph(&bytes, extension, None).unwrap_or_else(|error| panic!("{name}: {error}"));
            // Floats without a profile are linear.
            let meaning = if depth == 32 && stated == Stated::Nothing { Stated::Linear } else { stated };
            let off = difference(&image, |v| meaning.linear(v), depth == 32);
            assert!(off < tolerance, "{name}: {off}, {found}");
            let unstated = difference(&image, |v| v.map(if depth == 32 { |v| v } else { srgb }), depth == 32);
            let is_same = stated == Stated::Nothing || (depth == 32 && stated == Stated::Linear);
            assert_eq!(unstated < 0.03, is_same, "{name}: {unstated}");
            if stated == Stated::P3 {
                assert_overridden(&bytes, extension, tolerance);
            }
        }
    }
}

/// Reads code values as linear and as sRGB in spite of what the file states.
fn assert_overridden(bytes: &[u8], extension: &str, tolerance: f64) {
    for (codes, meaning) in [(CodeValues::Linear, Stated::Linear), (CodeValues::Srgb, Stated::Nothing)] {
        let (image, found) = photograph(bytes, extension, Some(codes)).unwrap_or_else(|e| panic!("{codes:?}: {e}"));
        let off = difference(&image, |v| meaning.linear(v), false);
        assert!(off < tolerance && found.contains("read as"), "{extension} as {codes:?}: {off}, {found}");
    }
}

#[test]
fn chunks_of_png_have_an_order() {
    let (linear, srgb_chunk) = (gama(1.0), (b"sRGB", vec![0]));
    let cicp = |primaries, transfer| (b"cICP", vec![primaries, transfer, 0, 1]);
    let adobe = iccp(&Stated::Adobe.profile().unwrap());
    let bt709 = |v: f64| if v < 0.081 { v / 4.5 } else { ((v + 0.099) / 1.099).powf(1.0 / 0.45) };
    let p3 = |v: [f64; 3]| Stated::P3.linear(v);
    let rec2020 = |v: [f64; 3]| to_rec709(v, [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046]], D65);
    type Case<'a> = (&'a str, Vec<(&'a [u8; 4], Vec<u8>)>, &'a dyn Fn([f64; 3]) -> [f64; 3]);
    let cases: [Case<'_>; 10] = [
        ("gAMA", vec![linear.clone()], &|v| v),
        ("gAMA 1/2.2", vec![gama(0.45455)], &|v| v.map(|v| v.powf(1.0 / 0.45455))),
        // Near linear, and more than rounding.
        ("gAMA 0.99602", vec![gama(0.99602)], &|v| v.map(|v| v.powf(1.0 / 0.99602))),
        ("gAMA, cHRM", vec![gama(0.45455), chrm(P3, D65)], &|v| to_rec709(v.map(|v| v.powf(1.0 / 0.45455)), P3, D65)),
        ("cHRM", vec![chrm(P3, D65)], &p3),
        ("sRGB over gAMA", vec![srgb_chunk.clone(), linear.clone(), chrm(P3, D65)], &|v| v.map(srgb)),
        ("iCCP over gAMA", vec![adobe.clone(), linear.clone()], &|v| Stated::Adobe.linear(v)),
        ("cICP over all", vec![cicp(12, 13), adobe, linear], &p3),
        ("cICP linear", vec![cicp(9, 8)], &rec2020),
        ("cICP BT.709", vec![cicp(1, 1)], &|v| v.map(bt709)),
    ];
    for (name, chunks, linear) in cases {
        for bytes in [png8(&chunks), png16(&chunks)] {
            let (image, found) = photograph(&bytes, "png", None).unwrap_or_else(|error| panic!("{name}: {error}"));
            let off = difference(&image, linear, false);
            assert!(off < 1e-3, "{name}: {off}, {found}");
        }
    }
    for (primaries, transfer) in [(9, 16), (9, 18), (1, 2), (200, 13)] {
        let png = png8(&[cicp(primaries, transfer)]);
        let error = photograph(&png, "png", None).unwrap_err();
        assert!(error.contains("PNG chunk cICP: found cICP"), "{error}");
        assert_overridden(&png, "png", 1e-3);
    }
}

#[test]
fn exif_and_fields_of_tiff_state_colours() {
    let adobe = |v| Stated::Adobe.linear(v);
    for (colour_space, is_r03, is_adobe) in
        [(1, false, false), (2, false, true), (0xffff, true, true), (0xffff, false, false)]
    {
        let bytes = jpeg(&[jpeg_exif(exif(1, colour_space, is_r03))]);
        let (image, found) = photograph(&bytes, "jpg", None).unwrap();
        let off = if is_adobe { difference(&image, adobe, false) } else { difference(&image, |v| v.map(srgb), false) };
        assert!(off < 0.03 && found.contains("Adobe RGB") == is_adobe, "{colour_space} {is_r03}: {off}, {found}");
        let is_uncalibrated = colour_space == 0xffff && !is_r03;
        assert_eq!(found.contains("sRGB (EXIF states an uncalibrated colour space)"), is_uncalibrated, "{found}");
        // A TIFF points to the same directory.
        let of = |at| tiff::<colortype::RGB16>(&sixteen(), &[(Tag::ExifDirectory, TagValue::Long(at))]);
        let at = of(0).len() as u32;
        let mut directories = exif(1, colour_space, is_r03)[38..].to_vec();
        directories[22..26].copy_from_slice(&(at + 30).to_le_bytes());
        let (image, in_tiff) = photograph(&[of(at), directories].concat(), "tif", None).unwrap();
        let off = if is_adobe { difference(&image, adobe, false) } else { difference(&image, |v| v.map(srgb), false) };
        assert!(off < 1e-3 && in_tiff == found, "{colour_space} {is_r03}: {off}, {in_tiff}");
    }
    let white = || (Tag::Unknown(318), TagValue::Rationals(D65.to_vec()));
    let primaries = || (Tag::Unknown(319), TagValue::Rationals(P3.concat()));
    let of = |tags: Tags<'_>| tiff::<colortype::RGB16>(&sixteen(), tags);
    let (image, found) = photograph(&of(&[white(), primaries()]), "tif", None).unwrap();
    assert!(difference(&image, |v| Stated::P3.linear(v), false) < 1e-3, "{found}");
    assert!(photograph(&of(&[white()]), "tif", None).unwrap().1.contains("sRGB (not stated)"));
    let curve = (Tag::Unknown(301), TagValue::Bytes(vec![0; 256]));
    for (tags, expected) in [
        (vec![primaries()], "PrimaryChromaticities: found 6 numbers, WhitePoint 0, expected"),
        (vec![curve], "TransferFunction: found a curve, expected an ICC profile"),
    ] {
        let error = photograph(&of(&tags), "tif", None).unwrap_err();
        assert!(error.contains(expected), "{error}");
        assert_overridden(&of(&tags), "tif", 1e-3);
    }
}

#[test]
fn clipped_pixels_are_counted() {
    for stated in [Stated::P3, Stated::Adobe, Stated::Nothing] {
        let icc = stated.profile();
        let chunks: Vec<_> = icc.iter().map(|icc| iccp(icc)).collect();
        let is_outside = |block: &usize| {
            let [x, y] = [block % BLOCKS[0] * BLOCK, block / BLOCKS[0] * BLOCK];
            let linear = stated.linear(std::array::from_fn(|c| code(x, y, c)));
            linear.iter().any(|v| !(-1e-3..=1.001).contains(v))
        };
        let blocks = BLOCKS[0] * BLOCKS[1];
        let count = (0..blocks).filter(is_outside).count();
        assert_eq!(count > 0, stated != Stated::Nothing);
        let share = 100.0 * count as f64 / blocks as f64;
        let expected = format!("{share:.3} % of the pixels lie outside the gamut of Rec. 709 and were clipped");
        for bytes in [png8(&chunks), png16(&chunks)] {
            let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
            std::fs::write(file.path(), bytes).unwrap();
            let conversions = open_colours(Input::from(file.path())).unwrap().conversions;
            assert_eq!(conversions.get(1), Some(&expected).filter(|_| count > 0), "{stated:?} {conversions:?}");
        }
    }
}

#[test]
fn profiles_that_do_not_fit_are_refused() {
    let grey = ColorProfile::new_gray_with_gamma(2.2).encode().unwrap();
    let mut without_primaries = ColorProfile::new_adobe_rgb();
    let black = moxcms::Xyzd::default();
    let colorants = [
        &mut without_primaries.red_colorant,
        &mut without_primaries.green_colorant,
        &mut without_primaries.blue_colorant,
    ];
    colorants.into_iter().for_each(|colorant| *colorant = black);
    let mut parts = jpeg_icc(&Stated::Adobe.profile().unwrap(), 100);
    parts.remove(1);
    let broken = png8(&[(b"iCCP", b"x\0\0no stream".to_vec())]);
    for (bytes, extension, expected) in [
        (png8(&[iccp(&grey)]), "png", "ICC profile: found a profile of Gray for 3 channels, expected"),
        (png8(&[iccp(b"no profile")]), "png", "ICC profile: "),
        (
            png8(&[iccp(&without_primaries.encode().unwrap())]),
            "png",
            "found a matrix whose white is [0.000, 0.000, 0.000]",
        ),
        (broken.clone(), "png", "ICC profile: a broken PNG chunk iCCP; expected"),
        (jpeg(&parts), "jpg", "expected all parts of the profile"),
    ] {
        let error = photograph(&bytes, extension, None).unwrap_err();
        assert!(error.contains(expected), "{error}");
        assert_overridden(&bytes, extension, if extension == "jpg" { 0.03 } else { 1e-3 });
    }
    // Numbers have no colour.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, broken).unwrap();
    assert!(open_colours(Input::File(path.clone())).is_err());
    assert_eq!(open_shares(Input::File(path)).unwrap().conversions, ["stored values"]);
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

#[test]
fn images_are_turned_upright() {
    for orientation in 1..=8 {
        let exif = exif(orientation, 1, false);
        let tags = [(Tag::Orientation, TagValue::Short(orientation))];
        let files = [
            ("png", png8(&[(b"eXIf", exif.clone())]), 1e-6),
            ("jpg", jpeg(&[jpeg_exif(exif)]), 0.03),
            ("tif", tiff::<colortype::RGB8>(&eight(), &tags), 1e-6),
        ];
        for (extension, bytes, tolerance) in files {
            let (image, found) = photograph(&bytes, extension, None).unwrap();
            let size = if orientation >= 5 { [SIZE[1], SIZE[0]] } else { SIZE };
            assert_eq!([image.width, image.height], size, "{extension} {orientation}");
            assert_eq!(found.contains(&format!("orientation {orientation} (")), orientation > 1, "{found}");
            for (at, pixel) in image.pixels.iter().enumerate() {
                let [x, y] = place(orientation, [at % size[0], at / size[0]]);
                let off = (0..3).map(|c| (f64::from(pixel[c]) - srgb(code(x, y, c))).abs()).fold(0.0, f64::max);
                assert!(off < tolerance, "{extension} {orientation}: {off} at {at}");
            }
        }
    }
    // Some writers store the orientation as LONG.
    let long = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x04\0\0\0\x01\0\0\0\x06\0\0\0\0";
    let (_, found) = photograph(&jpeg(&[jpeg_exif(long.to_vec())]), "jpg", None).unwrap();
    assert!(found.contains("orientation 6 ("), "{found}");
    // EXIF may follow the pixels.
    let (with, without) = (png8(&[(b"eXIf", exif(3, 1, false))]), png8(&[]));
    let (head, tail) = without.split_at(without.len() - 12);
    let late = [head, &with[33..33 + 12 + exif(3, 1, false).len()], tail].concat();
    assert_eq!(photograph(&late, "png", None).unwrap().0, photograph(&with, "png", None).unwrap().0);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.png"), png8(&[(b"eXIf", exif(1, 1, false))])).unwrap();
    std::fs::write(folder.path().join("b.png"), png8(&[(b"eXIf", exif(3, 1, false))])).unwrap();
    std::fs::write(folder.path().join("a.lp"), "2\na.png 0 0 1\nb.png 0 .6 .8\n").unwrap();
    let error = RtiCapture::open(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("b.png: orientation: found 3 (turned by 180°), expected 1 (upright), that of a.png"),
        "{error}"
    );
}

#[test]
fn mixed_colours_are_converted_each_by_its_own() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.png"), png8(&[])).unwrap();
    std::fs::write(folder.path().join("b.png"), png8(&[gama(1.0)])).unwrap();
    std::fs::write(folder.path().join("a.lp"), "2\na.png 0 0 1\nb.png 0 .6 .8\n").unwrap();
    let capture = RtiCapture::open(folder.path()).unwrap();
    assert!(difference(&capture.image(0).unwrap(), |v| v.map(srgb), false) < 1e-6);
    assert!(difference(&capture.image(1).unwrap(), |v| v, false) < 1e-4);
    let expected =
        "the images state different colours: gAMA 1, linear (1 of 2 images); sRGB (not stated) (1 of 2 images)";
    assert_eq!(capture.notes(), [expected]);
    // Three bytes per pixel of sRGB levels, and six of others.
    assert_eq!(capture.bytes(), (9 * SIZE[0] * SIZE[1]) as u64);
}

#[test]
fn pages_and_sample_formats_of_tiff_are_those_that_fields_name() {
    for (tag, value, is_full) in
        [(Tag::NewSubfileType, 1, false), (Tag::NewSubfileType, 4, false), (Tag::NewSubfileType, 2, true)]
    {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
        tiff_page::<colortype::RGB8>(&mut encoder, [2, 2], &[7; 12], &[(tag, TagValue::Long(value))]);
        tiff_page::<colortype::RGB8>(&mut encoder, SIZE, &eight(), &[]);
        let (image, found) = photograph(&bytes.into_inner(), "tif", None).unwrap();
        let size = if is_full { [2, 2] } else { SIZE };
        assert_eq!([image.width, image.height], size, "{value}: {found}");
        assert_eq!(found.contains("page 2"), !is_full, "{found}");
    }
    let only = tiff::<colortype::RGB8>(&eight(), &[(Tag::NewSubfileType, TagValue::Long(1))]);
    assert!(photograph(&only, "tif", None).unwrap_err().contains("found a TIFF of reduced images or masks only"));

    let words: Vec<u32> = codes(|v| (4_294_967_295.0 * v) as u32);
    let mut integers = tiff::<colortype::RGB32>(&words, &[]);
    let error = photograph(&integers, "tif", None).unwrap_err();
    assert!(error.contains("TIFF samples: found Uint of 32 bits (SampleFormat), expected grey or RGB of"), "{error}");
    // Without the field, samples are unsigned integers.
    let field = [339u16.to_le_bytes(), 3u16.to_le_bytes()].concat();
    let at = integers.windows(4).position(|window| window == field).unwrap();
    integers[at..at + 2].copy_from_slice(&65000u16.to_le_bytes());
    assert!(photograph(&integers, "tif", None).unwrap_err().contains("found Uint of 32 bits"));
    let signed: Vec<i16> = codes(|v| (32767.0 * v) as i16);
    let error = photograph(&tiff::<colortype::GrayI16>(&signed[..SIZE[0] * SIZE[1]], &[]), "tif", None).unwrap_err();
    assert!(error.contains("found Int of 16 bits (SampleFormat)"), "{error}");
    let doubles: Vec<f64> = codes(|v| v);
    let (grey, _) =
        photograph(&tiff::<colortype::Gray64Float>(&doubles[..SIZE[0] * SIZE[1]], &[]), "tif", None).unwrap();
    assert!(grey.pixels.iter().zip(&doubles).all(|(pixel, v)| *pixel == [*v as f32; 3]));
    let cmyk = tiff::<colortype::CMYK8>(&[0; 4 * SIZE[0] * SIZE[1]], &[]);
    assert!(photograph(&cmyk, "tif", None).unwrap_err().contains("TIFF samples: found CMYK(8)"));
}

/// A TIFF of fields of 16 bits, by default of 8-bit RGB, whose strips or tiles are `parts`.
fn raw_tiff(is_big: bool, fields: &[(u16, &[u16])], parts: &[Vec<u8>]) -> Vec<u8> {
    let short = |v: u16| if is_big { v.to_be_bytes() } else { v.to_le_bytes() };
    let long = |v: usize| if is_big { (v as u32).to_be_bytes() } else { (v as u32).to_le_bytes() };
    let [width, height] = SIZE.map(|side| side as u16);
    let default: [(u16, &[u16]); 7] =
        [(256, &[width]), (257, &[height]), (258, &[8]), (259, &[1]), (262, &[2]), (277, &[3]), (278, &[height])];
    let is_tiled = fields.iter().any(|(tag, _)| *tag == 322);
    let all: BTreeMap<u16, &[u16]> = default.into_iter().chain(fields.iter().copied()).collect();
    let all = all.into_iter().filter(|(tag, _)| *tag != 278 || !is_tiled);
    let mut entries: Vec<(u16, u16, usize, Vec<u8>)> =
        all.map(|(tag, values)| (tag, 3, values.len(), values.iter().flat_map(|v| short(*v)).collect())).collect();
    let [offsets, lengths] = if is_tiled { [324, 325] } else { [273, 279] };
    let of_lengths = parts.iter().flat_map(|part| long(part.len())).collect();
    entries.push((lengths, 4, parts.len(), of_lengths));
    entries.push((offsets, 4, parts.len(), vec![0; 4 * parts.len()]));
    entries.sort_by_key(|entry| entry.0);
    // Values of more than four bytes follow the directory, and the parts follow them.
    let values_at = 8 + 2 + 12 * entries.len() + 4;
    let values: usize = entries.iter().map(|entry| entry.3.len()).filter(|length| *length > 4).sum();
    let mut at = values_at + values;
    let mut offsets_of_parts = Vec::new();
    for part in parts {
        offsets_of_parts.extend(long(at));
        at += part.len();
    }
    entries.iter_mut().filter(|entry| entry.0 == offsets).for_each(|entry| entry.3.clone_from(&offsets_of_parts));
    let mut bytes = [if is_big { &b"MM\0*"[..] } else { b"II*\0" }, &long(8), &short(entries.len() as u16)].concat();
    let mut after = Vec::new();
    for (tag, kind, count, mut value) in entries {
        bytes.extend([&short(tag)[..], &short(kind), &long(count)].concat());
        if value.len() > 4 {
            bytes.extend(long(values_at + after.len()));
            after.append(&mut value);
        } else {
            value.resize(4, 0);
            bytes.append(&mut value);
        }
    }
    [bytes, vec![0; 4], after, parts.concat()].concat()
}

/// Part of the image from a corner, with 0 outside, as bytes of some channels.
fn part([left, top]: [usize; 2], [width, height]: [usize; 2], of: impl Fn([u8; 3]) -> Vec<u8>) -> Vec<u8> {
    let places = (0..width * height).map(|at| [left + at % width, top + at / width]);
    let level =
        |x: usize, y: usize, c| if x < SIZE[0] && y < SIZE[1] { (255.0 * code(x, y, c)).round() as u8 } else { 0 };
    places.flat_map(|[x, y]| of([0, 1, 2].map(|c| level(x, y, c)))).collect()
}

/// Parts of a size, row by row.
fn parts(size: [usize; 2], of: impl Fn([u8; 3]) -> Vec<u8>) -> Vec<Vec<u8>> {
    let count = [0, 1].map(|k| SIZE[k].div_ceil(size[k]));
    (0..count[0] * count[1]).map(|k| part([k % count[0] * size[0], k / count[0] * size[1]], size, &of)).collect()
}

fn compressed<C: colortype::ColorType>(
    samples: &[C::Inner],
    compression: tiff::encoder::Compression,
    predictor: tiff::tags::Predictor,
) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression).with_predictor(predictor);
    tiff_page::<C>(&mut { encoder }, SIZE, samples, &[]);
    bytes.into_inner()
}

/// Rows of floats with the predictor of floating-point numbers: planes of bytes, then differences.
fn predicted_floats() -> Vec<u8> {
    let floats: Vec<f32> = codes(|v| v as f32);
    let row = |row: &[f32]| {
        let planes: Vec<u8> = (0..4).flat_map(|k| row.iter().map(move |v| v.to_be_bytes()[k])).collect();
        (0..planes.len()).map(|k| planes[k].wrapping_sub(if k < 3 { 0 } else { planes[k - 3] })).collect::<Vec<_>>()
    };
    floats.chunks(3 * SIZE[0]).flat_map(row).collect()
}

#[test]
fn layouts_of_samples_are_read() {
    use png::{BitDepth, ColorType};
    use tiff::encoder::{Compression, DeflateLevel};
    use tiff::tags::Predictor;
    let rgb = |v: [f64; 3]| v.map(srgb);
    let grey = |v: [f64; 3]| [srgb(v[0]); 3];
    let linear = |v: [f64; 3]| v;
    let gamma = |v: [f64; 3]| [v[0].powf(2.2); 3];
    // Big-endian numbers near 257 times the level, of two different bytes.
    let wide_level = |v: u8| [v, v ^ 1];
    let wide = |v: [u8; 3]| v.into_iter().flat_map(wide_level).collect();
    let plane = |c: usize| move |v: [u8; 3]| vec![v[c]];
    let wide_plane = |c: usize| move |v: [u8; 3]| wide_level(v[c]).to_vec();
    let with = |alpha: u8| move |v: [u8; 3]| [&v[..], &[alpha]].concat();
    let planes = |size| [0, 1, 2].map(|c| parts(size, plane(c))).concat();
    let wide_planes = [0, 1, 2].map(|c| parts([SIZE[0], 10], wide_plane(c)));
    // The last strip has two rows.
    let wide_planes = wide_planes.map(|mut plane| {
        plane[3].truncate(2 * 2 * SIZE[0]);
        plane
    });
    let mut jpeg = Cursor::new(Vec::new());
    let levels = part([0, 0], SIZE, plane(0));
    image::GrayImage::from_raw(SIZE[0] as u32, SIZE[1] as u32, levels.clone())
        .unwrap()
        .write_to(&mut jpeg, image::ImageFormat::Jpeg)
        .unwrap();
    let tile: [(u16, &[u16]); 2] = [(322, &[32]), (323, &[16])];
    let grey_profile = ColorProfile::new_gray_with_gamma(2.2).encode().unwrap();
    let palette: Vec<u8> = parts([BLOCK; 2], |v| v.to_vec()).iter().flat_map(|block| block[..3].to_vec()).collect();
    let index: Vec<u8> =
        (0..SIZE[0] * SIZE[1]).map(|at| (at / SIZE[0] / BLOCK * BLOCKS[0] + at % SIZE[0] / BLOCK) as u8).collect();
    let grey_alpha = part([0, 0], SIZE, |v| vec![v[0], 70]);
    type Case<'a> = (&'a str, &'a str, Vec<u8>, &'a dyn Fn([f64; 3]) -> [f64; 3]);
    let cases: Vec<Case<'_>> = vec![
        ("LZW", "tif", compressed::<colortype::RGB16>(&sixteen(), Compression::Lzw, Predictor::Horizontal), &rgb),
        (
            "Deflate",
            "tif",
            compressed::<colortype::RGB8>(&eight(), Compression::Deflate(DeflateLevel::Fast), Predictor::Horizontal),
            &rgb,
        ),
        ("PackBits", "tif", compressed::<colortype::RGB8>(&eight(), Compression::Packbits, Predictor::None), &rgb),
        (
            "predictor 3",
            "tif",
            raw_tiff(
                false,
                &[(258, &[32]), (259, &[8]), (317, &[3]), (339, &[3])],
                &[stored_zlib(&predicted_floats())],
            ),
            &linear,
        ),
        ("tiles", "tif", raw_tiff(false, &tile, &parts([32, 16], |v| v.to_vec())), &rgb),
        ("tiles of 16 bits", "tif", raw_tiff(true, &[tile[0], tile[1], (258, &[16])], &parts([32, 16], wide)), &rgb),
        ("planes", "tif", raw_tiff(true, &[(258, &[16]), (278, &[10]), (284, &[2])], &wide_planes.concat()), &rgb),
        (
            "a plane of tiles",
            "tif",
            raw_tiff(
                false,
                &[(322, &[32]), (323, &[48]), (262, &[1]), (277, &[1]), (284, &[2])],
                &parts([32, 48], plane(0)),
            ),
            &grey,
        ),
        ("planes of tiles", "tif", raw_tiff(false, &[tile[0], tile[1], (284, &[2])], &planes([32, 16])), &rgb),
        ("alpha", "tif", raw_tiff(true, &[(277, &[4]), (338, &[2])], &[part([0, 0], SIZE, with(70))]), &rgb),
        ("opaque", "tif", raw_tiff(false, &[(277, &[4]), (338, &[1])], &[part([0, 0], SIZE, with(255))]), &rgb),
        ("another sample", "tif", raw_tiff(false, &[(277, &[4]), (338, &[0])], &[part([0, 0], SIZE, with(70))]), &rgb),
        (
            "grey, alpha",
            "tif",
            raw_tiff(false, &[(262, &[1]), (277, &[2]), (338, &[2])], std::slice::from_ref(&grey_alpha)),
            &grey,
        ),
        ("JPEG", "tif", raw_tiff(false, &[(259, &[7]), (262, &[1]), (277, &[1])], &[jpeg.into_inner()]), &grey),
        ("palette", "png", png_of(ColorType::Indexed, &index, BitDepth::Eight, &[(b"PLTE", palette.clone())]), &rgb),
        (
            "palette, tRNS",
            "png",
            png_of(ColorType::Indexed, &index, BitDepth::Eight, &[(b"PLTE", palette), (b"tRNS", vec![9; 6])]),
            &rgb,
        ),
        ("tRNS", "png", png8(&[(b"tRNS", vec![0, 200, 0, 40, 0, 90])]), &rgb),
        ("RGBA", "png", png_of(ColorType::Rgba, &part([0, 0], SIZE, with(70)), BitDepth::Eight, &[]), &rgb),
        ("grey, alpha", "png", png_of(ColorType::GrayscaleAlpha, &grey_alpha, BitDepth::Eight, &[]), &grey),
        ("grey profile", "png", png_of(ColorType::Grayscale, &levels, BitDepth::Eight, &[iccp(&grey_profile)]), &gamma),
    ];
    for (name, extension, bytes, expected) in &cases {
        let (image, found) = photograph(bytes, extension, None).unwrap_or_else(|error| panic!("{name}: {error}"));
        let off = difference(&image, expected, false);
        assert!(off < if *name == "JPEG" { 0.03 } else { 1e-3 }, "{extension} {name}: {off}, {found}");
    }

    let four = |fields: &[(u16, &[u16])], parts: &[Vec<u8>]| {
        raw_tiff(false, &[&[(277, &[4][..]), (338, &[0])], fields].concat(), parts)
    };
    let mut swapped = parts([SIZE[0], 16], |v| v.to_vec());
    let moved = swapped[0].pop().unwrap();
    swapped[1].push(moved);
    let whole = |alpha| vec![part([0, 0], SIZE, with(alpha))];
    for (bytes, expected) in [
        (
            four(&[(259, &[8]), (317, &[2])], &[stored_zlib(&whole(70)[0])]),
            "SamplesPerPixel: found 4 in rows with a predictor, expected 3, or plain strips",
        ),
        (four(&tile, &parts([32, 16], with(70))), "SamplesPerPixel: found 4 in tiles, expected 3, or plain strips"),
        (
            raw_tiff(false, &[(322, &[32]), (323, &[48]), (284, &[2])], &planes([32, 48])),
            "PlanarConfiguration: found separate planes (2) in tiles of 48 rows, expected a divisor of 32 rows",
        ),
        (four(&[(338, &[1])], &whole(70)), "found colours multiplied by alpha, with alpha below 1 at (0, 0), expected"),
        (four(&[(317, &[2])], &whole(70)), "Predictor: found a predictor of uncompressed data, expected 1 (none)"),
        (four(&[(266, &[2])], &whole(70)), "FillOrder: found 2 (lowest bit first), expected 1"),
        (raw_tiff(false, &[(278, &[16])], &swapped), "strip or tile 1 of 2303 bytes instead of 2304"),
        (raw_tiff(false, &[(259, &[7]), (262, &[6])], &[self::jpeg(&[])]), "TIFF samples: found YCbCr(8)"),
    ] {
        let error = photograph(&bytes, "tif", None).map(drop).expect_err(expected);
        assert!(error.contains(expected), "{error}");
    }
}

/// An EXR of a data window in a display window, whose channels hold `value` of the channel and the place in the data window.
fn exr_of(
    display: ([i32; 2], [usize; 2]),
    data: ([i32; 2], [usize; 2]),
    channels: &[&str],
    chromaticities: Option<Chromaticities>,
    value: impl Fn(usize, [usize; 2]) -> f32,
) -> Vec<u8> {
    let [width, height] = data.1;
    let samples = |c: usize| (0..width * height).map(|at| value(c, [at % width, at / width])).collect();
    let list = channels.iter().enumerate().map(|(c, name)| AnyChannel::new(*name, FlatSamples::F32(samples(c))));
    let attributes = LayerAttributes { layer_position: Vec2(data.0[0], data.0[1]), ..LayerAttributes::default() };
    let layer = Layer::new((width, height), attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list.collect()));
    let window = IntegerBounds::new(Vec2(display.0[0], display.0[1]), Vec2(display.1[0], display.1[1]));
    let mut all = ImageAttributes::new(window);
    all.chromaticities = chromaticities;
    let image = exr::prelude::Image::empty(all).with_layer(layer);
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn data_windows_are_placed_in_display_windows() {
    let value = |c: usize, [x, y]: [usize; 2]| 1.0 + c as f32 + 10.0 * x as f32 + 100.0 * y as f32;
    // Inside the display window, beyond each side of it, and around it.
    for (corner, size) in [([3, 2], [5, 4]), ([-2, -1], [6, 5]), ([10, 5], [12, 9]), ([-3, -3], [30, 20])] {
        for origin in [[0, 0], [100, -50]] {
            let display = (origin, [16, 8]);
            let data = ([origin[0] + corner[0], origin[1] + corner[1]], size);
            let expected = |c: usize, at: usize| {
                let place = [at % 16, at / 16].map(|v| v as i32);
                let inside = [place[0] - corner[0], place[1] - corner[1]];
                let is_inside = (0..2).all(|k| (0..size[k] as i32).contains(&inside[k]));
                if is_inside { value(c, inside.map(|v| v as usize)) } else { 0.0 }
            };
            let exr = exr_of(display, data, &["R", "G", "B"], None, value);
            let image = from_exr(&exr).unwrap();
            let photograph = photograph(&exr, "exr", None).unwrap().0;
            assert_eq!(([image.width, image.height], &image.pixels), ([16, 8], &photograph.pixels));
            for (at, pixel) in image.pixels.iter().enumerate() {
                assert_eq!(*pixel, [0, 1, 2].map(|c| expected(c, at)), "{corner:?} {origin:?} {at}");
            }
            assert!(image.conversions[1].starts_with("data window of "), "{:?}", image.conversions);
            let heights = heights_from_exr(&exr_of(display, data, &["Y"], None, value)).unwrap();
            assert!(heights.heights.iter().enumerate().all(|(at, height)| *height == expected(0, at)));
        }
    }
    let whole = from_exr(&exr_of(([0, 0], [16, 8]), ([0, 0], [16, 8]), &["R", "G", "B"], None, value)).unwrap();
    assert_eq!(whole.conversions, ["linear (EXR)"]);
}

#[test]
fn the_only_colour_layer_of_an_exr_is_read() {
    let window = ([0, 0], [4, 4]);
    let read = |channels: &[&str]| {
        from_exr(&exr_of(window, window, channels, None, |c, _| c as f32 + 1.0)).map_err(|error| error.to_string())
    };
    for (channels, expected) in [
        (&["R", "G", "B", "Z"][..], [1.0, 2.0, 3.0]),
        (&["Z", "ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"], [2.0, 3.0, 4.0]),
        (&["a.R", "a.G", "a.B", "R", "G", "B"], [4.0, 5.0, 6.0]),
        (&["Y"], [1.0; 3]),
        (&["A", "left.Y"], [2.0; 3]),
        (&["a.Combined.R", "a.Combined.G", "a.Combined.B", "a.Diff.R", "a.Diff.G", "a.Diff.B"], [1.0, 2.0, 3.0]),
        // Components of a normal are no luminance.
        (&["a.R", "a.G", "a.B", "Normal.X", "Normal.Y", "Normal.Z"], [1.0, 2.0, 3.0]),
    ] {
        let image = read(channels).unwrap();
        assert!(image.pixels.iter().all(|pixel| *pixel == expected), "{channels:?} {:?}", image.pixels[0]);
    }
    let named = read(&["Z", "ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"]).unwrap();
    assert_eq!(named.conversions[1], "layer ViewLayer.Combined");
    let of_two = read(&["a.Diff.R", "a.Diff.G", "a.Diff.B", "a.beauty.R", "a.beauty.G", "a.beauty.B"]).unwrap();
    assert_eq!(of_two.conversions[1], "layer a.beauty, of 2 layers of colours");
    let unnamed = read(&["a.R", "a.G", "a.B", "R", "G", "B"]).unwrap();
    assert_eq!(unnamed.conversions[1], "layer without a name, of 2 layers of colours");
    let both = read(&["a.RGBA.R", "a.RGBA.G", "a.RGBA.B", "b.RGBA.R", "b.RGBA.G", "b.RGBA.B"]).unwrap_err();
    assert!(both.starts_with("EXR: found layers a.RGBA, b.RGBA, expected one layer of colours"), "{both}");
    let heights = heights_from_exr(&exr_of(window, window, &["a.Combined.R", "b.R"], None, |_, _| 0.0)).unwrap_err();
    assert_eq!(
        heights.to_string(),
        "EXR: found layers a.Combined, b, expected one layer of heights, or one without a name"
    );
    let next_to_normals = exr_of(window, window, &["N.X", "N.Y", "N.Z", "R"], None, |c, _| c as f32);
    assert_eq!(heights_from_exr(&next_to_normals).unwrap().heights, [3.0; 16]);
    let two = read(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"]).unwrap_err();
    assert_eq!(
        two,
        "EXR: found layers a, b, expected one layer of colours, or one without a name, or one named Combined, Beauty or RGBA"
    );
    let none = read(&["U", "V"]).unwrap_err();
    assert_eq!(none, "EXR: found channels U, V, expected channels R, G and B, or Y");
    assert!(read(&["Y", "RY", "BY"]).unwrap_err().contains("found channels BY, RY, Y"));
}

#[test]
fn chromaticities_of_an_exr_are_converted() {
    let [red, green, blue] = ACES_CG.map(|[x, y]| Vec2(x as f32, y as f32));
    let white = Vec2(ACES_WHITE[0] as f32, ACES_WHITE[1] as f32);
    let window = ([0, 0], [4, 2]);
    let aces = Chromaticities { red, green, blue, white };
    let exr = exr_of(window, window, &["R", "G", "B"], Some(aces), |c, [x, y]| [0.2, 1.5, 0.7][c] * (1 + x + y) as f32);
    let image = from_exr(&exr).unwrap();
    assert_eq!(
        image.conversions,
        [
            "chromaticities of EXR, converted to linear Rec. 709",
            "100.000 % of the pixels lie outside the gamut of Rec. 709 and were clipped"
        ]
    );
    for (at, pixel) in image.pixels.iter().enumerate() {
        let scale = (1 + at % 4 + at / 4) as f64;
        let expected = to_rec709([0.2, 1.5, 0.7].map(|v| v * scale), ACES_CG, ACES_WHITE);
        // Radiance is not negative; photographs of floats keep colours outside the gamut.
        assert!(
            (0..3).all(|c| (f64::from(pixel[c]) - expected[c].max(0.0)).abs() < 1e-5 * scale),
            "{pixel:?} {expected:?}"
        );
        assert!(expected[0] < -0.1);
        let kept = photograph(&exr, "exr", None).unwrap().0.pixels[at];
        assert!((f64::from(kept[0]) - expected[0]).abs() < 1e-5 * scale);
    }
}

fn hdr(head: &str, resolution: &str) -> Vec<u8> {
    // Pixels of 1, 2, ... in the order of the file; red, and half and a quarter of it.
    let pixels = (1..=6u8).flat_map(|k| [8 * k, 4 * k, 2 * k, 128 + 5]);
    format!("{head}\n\n{resolution}\n").into_bytes().into_iter().chain(pixels).collect()
}

#[test]
fn headers_of_radiance_files_are_applied() {
    let head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe";
    let read = |lines: &str| from_hdr(&hdr(&format!("{head}{lines}"), "-Y 2 +X 3"));
    let first = |lines: &str| read(lines).unwrap_or_else(|error| panic!("{lines}: {error}")).pixels[0].map(f64::from);
    let plain = [1.0, 0.5, 0.25];
    let close = |found: [f64; 3], expected: [f64; 3]| (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-6);
    assert_eq!(first(""), plain);
    assert!(close(first("\nEXPOSURE=4"), plain.map(|v| v / 4.0)));
    assert!(close(first("\nEXPOSURE=4\nEXPOSURE= 0.5"), plain.map(|v| v / 2.0)));
    assert_eq!(first("\n\tEXPOSURE=4\n# EXPOSURE=3"), plain);
    assert!(close(first("\nCOLORCORR=2 1 .5"), [0.5, 0.5, 0.5]));
    assert!(close(first("\nGAMMA=2.2"), plain.map(|v| v.powf(2.2))));
    assert!(close(first("\nGAMMA=2\nEXPOSURE=4"), plain.map(|v| v * v / 4.0)));
    let primaries = "\nPRIMARIES=0.68 0.32 0.265 0.69 0.15 0.06 0.3127 0.329";
    assert!(close(first(primaries), to_rec709(plain, P3, D65).map(|v| v.max(0.0))));
    assert_eq!(read("\nEXPOSURE=4").unwrap().conversions, ["linear (Radiance)", "EXPOSURE 4 divided out"]);
    // As ImageMagick and Photoshop write it.
    let zeros = read("\nPRIMARIES=0 0 0 0 0 0 0 0").unwrap();
    assert_eq!(
        (zeros.pixels[0].map(f64::from), &zeros.conversions[..]),
        (plain, &["linear (Radiance)".to_owned()][..])
    );
    let error = read("\nPRIMARIES=1 0 0 1 0 0 2 2").unwrap_err().to_string();
    assert!(error.starts_with("primaries of Radiance PRIMARIES: found [[1.0, 0.0], "), "{error}");
    for lines in ["\nPRIMARIES=0 0 0 0 0 0 0 1", "\nEXPOSURE=0", "\nEXPOSURE=x", "\nCOLORCORR=1 2", "\nGAMMA=-1"] {
        assert!(read(lines).is_err(), "{lines}");
    }
    let xyze = from_hdr(&hdr("#?RADIANCE\nFORMAT=32-bit_rle_xyze", "-Y 2 +X 3")).unwrap().pixels[0].map(f64::from);
    let white = [1.0 / 3.0; 2];
    let [from, to] = [white, D65].map(|white| times(BRADFORD, xyz(white)));
    let cones = times(BRADFORD, plain);
    let adapted: [f64; 3] = std::array::from_fn(|c| cones[c] * to[c] / from[c]);
    let expected = solve(to_xyz(REC709, D65), solve(BRADFORD, adapted));
    assert!(close(xyze, expected.map(|v| v.max(0.0))), "{xyze:?} {expected:?}");
    let rgbe = from_hdr(&hdr("#?RGBE\nFORMAT=32-bit_rle_rgbe", "-Y 2 +X 3")).unwrap();
    assert_eq!(rgbe.pixels[0].map(f64::from), plain);
    let orders: [(&str, [usize; 2], [u8; 6]); 8] = [
        ("-Y 2 +X 3", [3, 2], [1, 2, 3, 4, 5, 6]),
        ("-Y 2 -X 3", [3, 2], [3, 2, 1, 6, 5, 4]),
        ("+Y 2 -X 3", [3, 2], [6, 5, 4, 3, 2, 1]),
        ("+Y 2 +X 3", [3, 2], [4, 5, 6, 1, 2, 3]),
        // Lines are columns: the first has 1, 2 and 3.
        ("+X 2 -Y 3", [2, 3], [1, 4, 2, 5, 3, 6]),
        ("-X 2 -Y 3", [2, 3], [4, 1, 5, 2, 6, 3]),
        ("-X 2 +Y 3", [2, 3], [6, 3, 5, 2, 4, 1]),
        ("+X 2 +Y 3", [2, 3], [3, 6, 2, 5, 1, 4]),
    ];
    for (resolution, size, expected) in orders {
        let image = from_hdr(&hdr(head, resolution)).unwrap();
        let found: Vec<u8> = image.pixels.iter().map(|pixel| pixel[0].round() as u8).collect();
        assert_eq!(([image.width, image.height], &found[..]), (size, &expected[..]), "{resolution}");
    }
    for resolution in ["-Y 2 +Y 3", "-Y 2", "-Y x +X 3", "-Y 0 +X 3"] {
        assert!(from_hdr(&hdr(head, resolution)).is_err(), "{resolution}");
    }
}

#[test]
fn shares_are_not_converted_and_are_upright() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, png16(&[gama(1.0), (b"eXIf", exif(3, 1, false))])).unwrap();
    let shares = open_shares(Input::File(path.clone())).unwrap();
    let colours = open_colours(Input::File(path)).unwrap();
    for (at, (share, colour)) in shares.pixels.iter().zip(&colours.pixels).enumerate() {
        let [x, y] = place(3, [at % SIZE[0], at / SIZE[0]]);
        assert!((0..3).all(|c| (f64::from(share[c]) - code(x, y, c)).abs() < 1e-5) && share[3] == 0.0);
        assert!((0..3).all(|c| (f64::from(colour[c]) - code(x, y, c)).abs() < 1e-4));
    }
    assert_eq!(shares.conversions, ["stored values", "orientation 3 (turned by 180°)"]);
}

/// A progressive JPEG of 35 x 27 pixels of libjpeg: 4:2:0, spectral selection and successive approximation.
const PROGRESSIVE: &[u8] = include_bytes!("progressive.jpg");

#[test]
fn images_that_lost_data_are_refused() {
    let noise = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([x * 61, y * 99, x * y].map(|v| v as u8)));
    let mut baseline = Cursor::new(Vec::new());
    noise.write_to(&mut baseline, image::ImageFormat::Jpeg).unwrap();
    for jpeg in [baseline.get_ref(), PROGRESSIVE] {
        assert!(photograph(jpeg, "jpg", None).is_ok());
        let scan = jpeg.windows(2).position(|pair| pair == [0xff, 0xda]).unwrap() + 14;
        let frame = jpeg.windows(2).position(|pair| matches!(pair, [0xff, 0xc0 | 0xc2])).unwrap();
        let end = jpeg.len() - 2;
        for tenth in 1..10 {
            let cut = scan + (end - scan) * tenth / 10;
            for lost in [&b""[..], &vec![0; end - cut]] {
                let broken = [&jpeg[..cut], lost, b"\xff\xd9"].concat();
                // The decoder itself accepts most of these.
                let error = photograph(&broken, "jpg", None).expect_err("a cut image");
                assert!(error.contains("truncated") || error.contains("invalid"), "{tenth}: {error}");
            }
        }
        let mut large = jpeg.to_vec();
        large[frame + 5..frame + 9].copy_from_slice(&[0x20, 0, 0x20, 0]);
        let error = photograph(&large, "jpg", None).unwrap_err();
        assert!(error.contains("the JPEG of 8192 x 8192 pixels is truncated or broken"), "{error}");
    }
    // Rows of a PNG whose checksums are right.
    let mut rows = Vec::new();
    let mut encoder = png::Encoder::new(&mut rows, SIZE[0] as u32, SIZE[1] as u32 / 2);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&eight()[..SIZE[0] * SIZE[1] * 3 / 2]).unwrap();
    writer.finish().unwrap();
    // The header of the whole image, and the pixels of half of it.
    let half = [&png8(&[])[..33], &rows[33..]].concat();
    let error = photograph(&half, "png", None).unwrap_err();
    assert!(error.contains("not have enough data for image"), "{error}");
    // The lengths of strips of a TIFF, and the strips.
    let whole = tiff::<colortype::RGB8>(&eight(), &[]);
    let field = [279u16.to_le_bytes(), 4u16.to_le_bytes()].concat();
    let at = whole.windows(4).position(|window| window == field).unwrap();
    let count = u32::from_le_bytes(whole[at + 4..at + 8].try_into().unwrap());
    let place = u32::from_le_bytes(whole[at + 8..at + 12].try_into().unwrap()) as usize;
    let lengths = if count == 1 { at + 8 } else { place };
    let mut short = whole.clone();
    short[lengths..lengths + 4].copy_from_slice(&100u32.to_le_bytes());
    let error = photograph(&short, "tif", None).unwrap_err();
    assert!(error.contains("the TIFF is truncated"), "{error}");
    for samples in [2, SIZE[0] * 3, SIZE[0] * SIZE[1] * 3 / 2] {
        let short = tiff::<colortype::RGB8>(&eight(), &[]);
        assert!(photograph(&short[..short.len().min(8 + samples)], "tif", None).is_err(), "{samples}");
    }
}

#[test]
fn photographs_of_61_megapixels_are_read_and_larger_ones_are_not() {
    let grey = |width, height| {
        let mut bytes = Cursor::new(Vec::new());
        image::GrayImage::new(width, height).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        photograph(&bytes.into_inner(), "png", None).map(|(image, _)| [image.width, image.height])
    };
    assert_eq!(grey(9504, 64), Ok([9504, 64]));
    let error = grey(16385, 1).unwrap_err();
    assert!(error.contains("image size: found 16385 x 1, expected 1 to 16384 along each side, and at most"), "{error}");
    assert!(grey(16384, 10_000).unwrap_err().contains("found 16384 x 10000"));
}
