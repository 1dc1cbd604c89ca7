//! TIFF: the first page that is no reduced copy, by the fields that say what its samples are.

use super::ask::{Ask, ImageReader, Purpose};
use super::colour::{Colour, Curve};
use super::exif::{COLOUR_SPACE, Exif, INTEROPERABILITY_DIRECTORY, INTEROPERABILITY_INDEX};
use super::header::Header;
use super::jpeg::check as check_jpeg;
use super::orientation::Orientation;
use super::raster::{Depth, Raster, Samples, collected};
use brdfc_formats::FormatError;
use std::fmt::Display;
use std::io::Read;
use tiff::ColorType;
use tiff::decoder::ifd::Value;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, DecodingSampleType, Limits};
use tiff::tags::{IfdPointer, Tag};

/// Maximum memory of a decoded page, of a part of it and of a field, bytes.
const MAX_PAGE_BYTES: usize = 2 << 30;
const MAX_FIELD_BYTES: usize = 64 << 20;
/// Maximum number of pages of a file that are examined.
const MAX_PAGES: usize = 4096;
/// Bits of `NewSubfileType` of reduced images and of masks, and the value of `SubfileType` of full images.
const REDUCED_OR_MASK: u32 = 0b101;
const FULL: u32 = 1;
/// Values of `Compression`.
const UNCOMPRESSED: u16 = 1;
const JPEG: u16 = 7;
/// Value of `PlanarConfiguration` of separate channels.
const PLANAR: u64 = 2;
/// Value of `FillOrder`.
const LOWEST_BIT_FIRST: u64 = 2;
/// Value of `ExtraSamples` of alpha that colours are multiplied by.
const ASSOCIATED_ALPHA: u16 = 1;
const TRANSFER_FUNCTION: Tag = Tag::Unknown(301);
const WHITE_POINT: Tag = Tag::Unknown(318);
const PRIMARY_CHROMATICITIES: Tag = Tag::Unknown(319);
const ALLOWED: &str = "grey or RGB of unsigned integers of 8 or 16 bits, or of floats";

/// The page to read, and its number from 1.
struct Page<R: std::io::Read + std::io::Seek> {
    decoder: Decoder<R>,
    number: usize,
    channels: usize,
    sample: DecodingSampleType,
}

pub(super) fn header(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Header, FormatError> {
    let Page { mut decoder, number, channels, sample } = open(reader, ask)?;
    let (width, height) = decoder.dimensions().map_err(|error| broken(ask, error))?;
    let orientation = decoder.find_tag_unsigned(Tag::Orientation).map_err(|error| broken(ask, error))?;
    let orientation = Orientation::of(orientation.unwrap_or(1));
    let depth = match sample {
        DecodingSampleType::U8 => Depth::U8,
        DecodingSampleType::U16 => Depth::U16,
        _ => Depth::F32,
    };
    let colour = ask.colour(|| colour(&mut decoder, channels, depth, ask))?;
    let notes = (number > 1).then(|| format!("page {number}: those before are reduced images or masks"));
    let size = orientation.size([width as usize, height as usize]);
    Ok(Header { size, channels, depth, colour, orientation, notes: notes.into_iter().collect() })
}

pub(super) fn samples(mut reader: impl ImageReader, ask: &Ask<'_>) -> Result<Raster, FormatError> {
    let Page { mut decoder, channels, .. } = open(&mut reader, ask)?;
    let (width, height) = decoder.dimensions().map_err(|error| broken(ask, error))?;
    check_lengths(&mut decoder, ask)?;
    let mut samples = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut samples).map_err(|error| broken(ask, error))?;
    if samples.as_buffer(0).byte_len() < layout.complete_len {
        return Err(ask.broken("too many pixels for the decoder"));
    }
    let size = [width as usize, height as usize];
    let planes = layout.planes.min(channels);
    let expected = size[0] * size[1] * channels;
    let samples = match samples {
        DecodingResult::U8(samples) => Samples::U8(interleaved(samples, planes, expected, ask)?),
        DecodingResult::U16(samples) => Samples::U16(interleaved(samples, planes, expected, ask)?),
        DecodingResult::F16(samples) => {
            let floats = collected(samples.into_iter().map(f32::from))?;
            Samples::F32(interleaved(floats, planes, expected, ask)?)
        }
        DecodingResult::F32(samples) => Samples::F32(interleaved(samples, planes, expected, ask)?),
        DecodingResult::F64(samples) => {
            let floats = collected(samples.into_iter().map(|sample| sample as f32))?;
            Samples::F32(interleaved(floats, planes, expected, ask)?)
        }
        _ => return Err(ask.found("a TIFF of signed integers, or of more than 16 bits")),
    };
    let raster = Raster { size, channels, samples };
    match ask.purpose {
        Purpose::Colours(_) if is_associated(&mut decoder, ask)? => opaque(raster, ask),
        _ => Ok(raster),
    }
}

/// Returns true if the colours of a page are products with alpha.
fn is_associated<R: ImageReader>(decoder: &mut Decoder<R>, ask: &Ask<'_>) -> Result<bool, FormatError> {
    let extra: Option<Vec<u16>> =
        decoder.find_tag_unsigned_vec(Tag::ExtraSamples).map_err(|error| broken(ask, error))?;
    Ok(extra.is_some_and(|extra| extra.first() == Some(&ASSOCIATED_ALPHA)))
}

/// Checks that alpha is 1 everywhere: it is ignored, and colours multiplied by it would be too dark.
fn opaque(raster: Raster, ask: &Ask<'_>) -> Result<Raster, FormatError> {
    let Raster { size, channels, samples } = &raster;
    let all = (channels - 1..size[0] * size[1] * channels).step_by(*channels);
    let is_less = |at: &usize| match samples {
        Samples::U8(samples) => samples[*at] < u8::MAX,
        Samples::U16(samples) => samples[*at] < u16::MAX,
        Samples::F32(samples) => samples[*at].is_nan() || samples[*at] < 1.0,
    };
    let Some(at) = all.into_iter().find(is_less) else { return Ok(raster) };
    let pixel = at / channels;
    let found =
        format!("colours multiplied by alpha, with alpha below 1 at ({}, {})", pixel % size[0], pixel / size[0]);
    Err(FormatError::whole(format!("{} of TIFF, ExtraSamples", ask.field), found, "unassociated alpha (2), or none"))
}

/// Checks that strips or tiles are complete: the decoder reads on beyond uncompressed ones, and fills JPEGs with grey.
fn check_lengths<R: ImageReader>(decoder: &mut Decoder<R>, ask: &Ask<'_>) -> Result<(), FormatError> {
    let compression: Option<u16> = decoder.find_tag_unsigned(Tag::Compression).map_err(|error| broken(ask, error))?;
    let mut all = |tags: [Tag; 2]| -> Result<Vec<u64>, FormatError> {
        let found = tags.map(|tag| decoder.find_tag_unsigned_vec(tag).map_err(|error| broken(ask, error)));
        let [strips, tiles] = found;
        Ok(strips?.or(tiles?).unwrap_or_default())
    };
    let lengths = all([Tag::StripByteCounts, Tag::TileByteCounts])?;
    if compression == Some(JPEG) {
        let offsets = all([Tag::StripOffsets, Tag::TileOffsets])?;
        let tables = decoder.find_tag(Tag::JPEGTables).map_err(|error| broken(ask, error))?;
        let tables = tables.map(Value::into_u8_vec).transpose().map_err(|error| broken(ask, error))?;
        // Tables are between markers of the start and the end of an image.
        let tables =
            tables.as_deref().and_then(|tables| tables.get(..tables.len().checked_sub(2)?)).unwrap_or_default();
        for (offset, length) in offsets.into_iter().zip(lengths) {
            let mut part = tables.to_vec();
            let skipped = if tables.is_empty() { 0 } else { 2 };
            decoder.goto_offset_u64(offset.saturating_add(skipped)).map_err(|error| broken(ask, error))?;
            let length = length.saturating_sub(skipped);
            decoder.inner().take(length).read_to_end(&mut part).map_err(|error| broken(ask, error))?;
            check_jpeg(&part).map_err(|problem| ask.broken(problem))?;
        }
        return Ok(());
    }
    if compression.is_some_and(|compression| compression != UNCOMPRESSED) {
        return Ok(());
    }
    let samples = samples_of_parts(decoder, ask)?;
    let bits = u64::from(decoder.colortype().map_err(|error| broken(ask, error))?.bit_depth());
    // Rows of tiles have their whole width.
    let (width, _) = decoder.chunk_dimensions();
    let row = (u64::from(width) * samples * bits).div_ceil(8);
    for (part, stated) in (0..).zip(lengths) {
        let expected = u64::from(decoder.chunk_data_dimensions(part).1) * row;
        if stated < expected {
            let found = format!("strip or tile {} of {stated} bytes instead of {expected}", part + 1);
            return Err(ask.broken(format!("{found}: the TIFF is truncated")));
        }
    }
    Ok(())
}

/// Samples per pixel of a strip or tile.
fn samples_of_parts<R: ImageReader>(decoder: &mut Decoder<R>, ask: &Ask<'_>) -> Result<u64, FormatError> {
    let mut number = |tag| decoder.find_tag_unsigned::<u64>(tag).map_err(|error| broken(ask, error));
    Ok(if number(Tag::PlanarConfiguration)? == Some(PLANAR) { 1 } else { number(Tag::SamplesPerPixel)?.unwrap_or(1) })
}

fn interleaved<T: Copy>(samples: Vec<T>, planes: usize, expected: usize, ask: &Ask<'_>) -> Result<Vec<T>, FormatError> {
    if samples.len() < expected {
        return Err(ask.broken(format!("{} of {expected} samples", samples.len())));
    }
    if planes <= 1 {
        return Ok(samples);
    }
    let pixels = expected / planes;
    collected((0..expected).map(|at| samples[at % planes * pixels + at / planes]))
}

/// Finds the first page that is no reduced image and no mask.
fn open<R: ImageReader>(reader: R, ask: &Ask<'_>) -> Result<Page<R>, FormatError> {
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (MAX_PAGE_BYTES, MAX_PAGE_BYTES);
    limits.ifd_value_size = MAX_FIELD_BYTES;
    let mut decoder = Decoder::new(reader).map_err(|error| broken(ask, error))?.with_limits(limits);
    let mut number = 1;
    while !is_full(&mut decoder).map_err(|error| broken(ask, error))? {
        if !decoder.more_images() || number == MAX_PAGES {
            return Err(ask.found("a TIFF of reduced images or masks only"));
        }
        decoder.next_image().map_err(|error| broken(ask, error))?;
        number += 1;
    }
    let (width, height) = decoder.dimensions().map_err(|error| broken(ask, error))?;
    let orientation = decoder.find_tag_unsigned(Tag::Orientation).map_err(|error| broken(ask, error))?;
    ask.check_size(Orientation::of(orientation.unwrap_or(1)).size([width as usize, height as usize]))?;
    let wrong = |found: String| FormatError::whole("TIFF samples", found, ALLOWED);
    let colour = decoder.colortype().map_err(|error| broken(ask, error))?;
    let channels = match colour {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) | ColorType::Multiband { num_samples: 2, .. } => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        other => return Err(wrong(format!("{other:?}"))),
    };
    check_layout(&mut decoder, channels, ask)?;
    let layout = decoder.image_buffer_layout().map_err(|error| broken(ask, error))?;
    match layout.sample_type {
        Some(sample @ (DecodingSampleType::U8 | DecodingSampleType::U16)) if [8, 16].contains(&colour.bit_depth()) => {
            Ok(Page { decoder, number, channels, sample })
        }
        Some(sample @ (DecodingSampleType::F16 | DecodingSampleType::F32 | DecodingSampleType::F64)) => {
            Ok(Page { decoder, number, channels, sample })
        }
        _ => Err(wrong(format!("{:?} of {} bits (SampleFormat)", layout.sample_format, colour.bit_depth()))),
    }
}

/// Rejects layouts that the decoder gets wrong.
fn check_layout<R: ImageReader>(decoder: &mut Decoder<R>, channels: usize, ask: &Ask<'_>) -> Result<(), FormatError> {
    let samples = samples_of_parts(decoder, ask)?;
    let mut number = |tag| decoder.find_tag_unsigned::<u64>(tag).map_err(|error| broken(ask, error));
    let [planar, predictor] = [number(Tag::PlanarConfiguration)? == Some(PLANAR), number(Tag::Predictor)? > Some(1)];
    // It ignores the order of bits, and undoes predictors of uncompressed data, which other programs ignore.
    if number(Tag::FillOrder)? == Some(LOWEST_BIT_FIRST) {
        return Err(FormatError::whole("TIFF field FillOrder", "2 (lowest bit first)", "1"));
    }
    if predictor && number(Tag::Compression)?.is_none_or(|compression| compression == u64::from(UNCOMPRESSED)) {
        return Err(FormatError::whole("TIFF field Predictor", "a predictor of uncompressed data", "1 (none)"));
    }
    let is_tiled = decoder.get_chunk_type() == ChunkType::Tile;
    // It drops the other samples before it undoes the predictor, and writes whole rows of tiles.
    if !planar && samples != channels as u64 && (is_tiled || predictor) {
        let found = format!("{samples} in {}", if predictor { "rows with a predictor" } else { "tiles" });
        return Err(FormatError::whole("TIFF field SamplesPerPixel", found, format!("{channels}, or plain strips")));
    }
    // It finds the last row of tiles of the first plane only.
    let (height, tile) = (decoder.dimensions().map_err(|error| broken(ask, error))?.1, decoder.chunk_dimensions().1);
    if planar && channels > 1 && is_tiled && height % tile != 0 {
        let found = format!("separate planes (2) in tiles of {tile} rows");
        let allowed = format!("a divisor of {height} rows, or samples next to each other (1)");
        return Err(FormatError::whole("TIFF field PlanarConfiguration", found, allowed));
    }
    Ok(())
}

fn is_full<R: ImageReader>(decoder: &mut Decoder<R>) -> Result<bool, tiff::TiffError> {
    let new: Option<u32> = decoder.find_tag_unsigned(Tag::NewSubfileType)?;
    let old: Option<u32> = decoder.find_tag_unsigned(Tag::SubfileType)?;
    Ok(match new {
        Some(new) => new & REDUCED_OR_MASK == 0,
        None => old.is_none_or(|old| old == FULL || old == 3),
    })
}

/// Colour by the ICC profile, or else by the fields of TIFF. Floats are linear.
fn colour<R: ImageReader>(
    decoder: &mut Decoder<R>,
    channels: usize,
    depth: Depth,
    ask: &Ask<'_>,
) -> Result<Colour, FormatError> {
    if let Some(icc) = decoder.find_tag(Tag::IccProfile).map_err(|error| broken(ask, error))? {
        let icc = icc.into_u8_vec().map_err(|error| broken(ask, error))?;
        return Colour::of_profile(&icc, channels);
    }
    let mut numbers = |tag| -> Result<Option<Vec<f64>>, FormatError> {
        Ok(match decoder.find_tag(tag).map_err(|error| broken(ask, error))? {
            Some(Value::List(values)) => Some(values.iter().filter_map(number).collect()),
            Some(_) => Some(Vec::new()),
            None => None,
        })
    };
    if numbers(TRANSFER_FUNCTION)?.is_some() {
        let allowed = "an ICC profile, or no such field";
        return Err(FormatError::whole("TIFF field TransferFunction", "a curve", allowed));
    }
    let (white, primaries) = (numbers(WHITE_POINT)?, numbers(PRIMARY_CHROMATICITIES)?);
    // A white says nothing about RGB without primaries.
    let primaries = match (white.as_deref(), primaries.as_deref()) {
        (_, None) => None,
        (Some([x, y]), Some([rx, ry, gx, gy, bx, by])) => Some([[*rx, *ry], [*gx, *gy], [*bx, *by], [*x, *y]]),
        (white, Some(primaries)) => {
            let found = format!("{} numbers, WhitePoint {}", primaries.len(), white.map_or(0, <[f64]>::len));
            let allowed = "6 numbers, and 2 of WhitePoint";
            return Err(FormatError::whole("TIFF field PrimaryChromaticities", found, allowed));
        }
    };
    let stated = "primaries of TIFF field PrimaryChromaticities";
    match (depth, primaries) {
        (Depth::F32, None) => Ok(Colour::linear("linear (TIFF of floats)")),
        (Depth::F32, primaries) => Colour::of_curve(stated, Curve::LINEAR, primaries),
        (_, None) => exif(decoder).colour(),
        (_, Some(primaries)) => Colour::of_srgb_curve(stated, primaries),
    }
}

/// EXIF metadata of a page; fields of broken metadata are missing.
fn exif<R: ImageReader>(decoder: &mut Decoder<R>) -> Exif {
    let mut exif = Exif::default();
    let first = decoder.find_tag_unsigned(Tag::ExifDirectory).ok().flatten();
    let Some(directory) = first.and_then(|at| decoder.read_directory(IfdPointer(at)).ok()) else { return exif };
    let mut tags = decoder.read_directory_tags(&directory);
    exif.colour_space = tags.find_tag_unsigned(Tag::Unknown(COLOUR_SPACE)).ok().flatten();
    let next = tags.find_tag_unsigned(Tag::Unknown(INTEROPERABILITY_DIRECTORY)).ok().flatten();
    if let Some(directory) = next.and_then(|at| decoder.read_directory(IfdPointer(at)).ok()) {
        let index = decoder.read_directory_tags(&directory).find_tag(Tag::Unknown(INTEROPERABILITY_INDEX));
        exif.is_r03 = matches!(index, Ok(Some(Value::Ascii(index))) if index == "R03");
    }
    exif
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Rational(n, d) => Some(f64::from(*n) / f64::from(*d)),
        Value::Float(value) => Some(f64::from(*value)),
        Value::Double(value) => Some(*value),
        _ => None,
    }
}

fn broken(ask: &Ask<'_>, error: impl Display) -> FormatError {
    ask.broken(error)
}
