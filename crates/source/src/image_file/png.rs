//! PNG: its chunks about colour, and pixels of 8 or 16 bits.

use super::ask::{Ask, ImageReader, Purpose, rewind};
use super::colour::{Colour, Curve};
use super::exif::{EXIF, Exif};
use super::header::Header;
use super::orientation::Orientation;
use super::raster::{Depth, Raster, Samples, collected};
use brdfc_formats::FormatError;
use brdfc_formats::memory::filled;
use moxcms::{CicpProfile, ColorProfile, MatrixCoefficients, TransferCharacteristics};
use png::{BitDepth, ColorType, Decoder, Info, Limits, Reader, Transformations};
use std::io::{Read, SeekFrom};

/// Largest compression ratio of a deflate stream.
const MAX_DEFLATE_RATIO: u64 = 1032;
/// Length of the signature before the first chunk, and maximum length of EXIF metadata that is read.
const SIGNATURE_BYTES: u64 = 8;
const MAX_EXIF_BYTES: u64 = 1 << 20;
/// Maximum memory of chunks other than pixels, bytes.
const MAX_CHUNK_BYTES: usize = 256 << 20;

/// Chunks that the decoder skips: EXIF after the pixels, and a profile that it cannot decompress.
#[derive(Default)]
struct Skipped {
    exif: Exif,
    has_profile: bool,
}

pub(super) fn header(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Header, FormatError> {
    let Skipped { exif, has_profile } = skipped(reader).unwrap_or_default();
    rewind(reader, ask)?;
    let reader = open(reader, ask)?;
    let info = reader.info();
    let (colour, depth) = reader.output_color_type();
    let orientation = Orientation::of(exif.orientation.unwrap_or(1));
    let stated = || match has_profile && info.icc_profile.is_none() {
        true => Err(FormatError::whole("ICC profile", "a broken PNG chunk iCCP", "a complete profile").problem()),
        false => self::colour(info, colour.samples()),
    };
    Ok(Header {
        size: orientation.size([info.width as usize, info.height as usize]),
        channels: colour.samples(),
        depth: if depth == BitDepth::Sixteen { Depth::U16 } else { Depth::U8 },
        colour: ask.colour(stated)?,
        orientation,
        notes: Vec::new(),
    })
}

pub(super) fn samples(mut reader: impl ImageReader, ask: &Ask<'_>) -> Result<Raster, FormatError> {
    let length = reader.seek(SeekFrom::End(0)).unwrap_or(u64::MAX);
    rewind(&mut reader, ask)?;
    let mut reader = open(&mut reader, ask)?;
    let info = reader.info();
    let size = [info.width as usize, info.height as usize];
    let least = info.raw_bytes() as u64 / MAX_DEFLATE_RATIO;
    if length < least {
        let found = format!("{length} bytes for {} x {} pixels", size[0], size[1]);
        return Err(FormatError::whole(ask.field, found, format!("{least} or more")));
    }
    let (colour, depth) = reader.output_color_type();
    let bytes = reader.output_buffer_size().ok_or_else(|| ask.broken("too many pixels"))?;
    let mut bytes = filled("pixels", bytes, 0u8)?;
    reader.next_frame(&mut bytes).map_err(|error| ask.broken(error))?;
    let samples = match depth {
        BitDepth::Sixteen => {
            Samples::U16(collected(bytes.as_chunks().0.iter().map(|sample| u16::from_be_bytes(*sample)))?)
        }
        _ => Samples::U8(bytes),
    };
    Ok(Raster { size, channels: colour.samples(), samples })
}

/// Walks through all chunks. A file that ends early has those before.
fn skipped(reader: &mut impl ImageReader) -> std::io::Result<Skipped> {
    let mut found = Skipped::default();
    reader.seek(SeekFrom::Start(SIGNATURE_BYTES))?;
    let mut head = [0; 8];
    while reader.read_exact(&mut head).is_ok() {
        let [a, b, c, d, name @ ..] = head;
        let length = u64::from(u32::from_be_bytes([a, b, c, d]));
        match &name {
            b"IEND" => break,
            b"iCCP" => found.has_profile = true,
            b"eXIf" => {
                let mut exif = Vec::new();
                reader.by_ref().take(length.min(MAX_EXIF_BYTES)).read_to_end(&mut exif)?;
                found.exif = Exif::from_bytes(exif.strip_prefix(EXIF).unwrap_or(&exif));
                reader.seek_relative(-(exif.len() as i64))?;
            }
            _ => {}
        }
        // Its checksum follows.
        reader.seek_relative(length as i64 + 4)?;
    }
    Ok(found)
}

/// Reads the chunks before the pixels.
fn open<'a, R: ImageReader>(reader: &'a mut R, ask: &Ask<'_>) -> Result<Reader<&'a mut R>, FormatError> {
    let mut decoder = Decoder::new_with_limits(reader, Limits { bytes: MAX_CHUNK_BYTES });
    // Palettes become RGB, fewer bits become 8, and transparent colours become alpha.
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let info = decoder.read_header_info().map_err(|error| ask.broken(error))?;
    let (colour, depth) = (info.color_type, info.bit_depth);
    ask.check_size([info.width as usize, info.height as usize])?;
    let is_grey = colour == ColorType::Grayscale && matches!(depth, BitDepth::Eight | BitDepth::Sixteen);
    if ask.purpose == Purpose::Heights && !is_grey {
        let kind = match colour {
            ColorType::Grayscale => "grey",
            ColorType::GrayscaleAlpha => "grey with transparency",
            ColorType::Indexed => "a palette",
            ColorType::Rgb => "RGB",
            ColorType::Rgba => "RGB with transparency",
        };
        return Err(ask.found(format!("{kind}, {} bits", depth as u8)));
    }
    decoder.read_info().map_err(|error| ask.broken(error))
}

/// Colour by the first of cICP, iCCP, sRGB, and gAMA with cHRM, the order of the specification.
fn colour(info: &Info<'_>, channels: usize) -> Result<Colour, FormatError> {
    if let Some(cicp) = info.coding_independent_code_points {
        let stated = format!("cICP {} {}", cicp.color_primaries, cicp.transfer_function);
        let wrong = || {
            let allowed = "primaries and a transfer function of ITU-T H.273 relative to white, full range";
            FormatError::whole("PNG chunk cICP", stated.clone(), allowed)
        };
        let parse = |codes: [u8; 2]| Some((codes[0].try_into().ok()?, codes[1].try_into().ok()?));
        let codes = parse([cicp.color_primaries, cicp.transfer_function]);
        let Some((color_primaries, transfer_characteristics)) = codes.filter(|_| cicp.is_video_full_range_image) else {
            return Err(wrong());
        };
        if matches!(transfer_characteristics, TransferCharacteristics::Smpte2084 | TransferCharacteristics::Hlg) {
            return Err(wrong());
        }
        let mut profile = ColorProfile::default();
        let matrix_coefficients = MatrixCoefficients::Identity;
        let codes = CicpProfile { color_primaries, transfer_characteristics, matrix_coefficients, full_range: true };
        profile.update_rgb_colorimetry_from_cicp(codes);
        return Colour::of_rgb(&stated, &profile)?.ok_or_else(wrong);
    }
    if let Some(icc) = &info.icc_profile {
        return Colour::of_profile(icc, channels);
    }
    if info.srgb.is_some() {
        return Ok(Colour::srgb("sRGB (PNG chunk sRGB)"));
    }
    let primaries = info.chrm_chunk.map(|chunk| {
        let pair = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x, y].map(|v| f64::from(v.into_scaled()) / 1e5);
        [chunk.red, chunk.green, chunk.blue, chunk.white].map(pair)
    });
    match (info.gama_chunk, primaries) {
        (None, None) => Ok(Colour::srgb("sRGB (not stated)")),
        (None, Some(primaries)) => Colour::of_srgb_curve("primaries of PNG chunk cHRM", primaries),
        (Some(gamma), primaries) => {
            let gamma = f64::from(gamma.into_scaled()) / 1e5;
            let stated = format!("gAMA {gamma}{}", if primaries.is_some() { " and cHRM" } else { "" });
            Colour::of_curve(&stated, Curve::power(1.0 / gamma), primaries)
        }
    }
}
