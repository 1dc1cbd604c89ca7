//! JPEG: its segments about colour and orientation, and pixels of complete files.

use super::ask::{Ask, ImageReader};
use super::colour::Colour;
use super::exif::{EXIF, Exif};
use super::header::Header;
use super::jpeg_scan::Scans;
use super::orientation::Orientation;
use super::raster::{Depth, Raster, Samples};
use brdfc_formats::FormatError;
use brdfc_formats::memory::filled;
use image::ImageDecoder;
use image::codecs::jpeg::JpegDecoder;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::iter::successors;

const APP0: u8 = 0xe0;
const APP1: u8 = 0xe1;
const APP2: u8 = 0xe2;
const APP14: u8 = 0xee;
const START_OF_SCAN: u8 = 0xda;
const END_OF_IMAGE: u8 = 0xd9;
const JFIF: &[u8] = b"JFIF\0";
/// The start of Adobe's segment. Its version, two words of flags and the transform of colours follow.
const ADOBE: &[u8] = b"Adobe";
/// Place of the transform in it.
const TRANSFORM: usize = 11;
const ICC: &[u8] = b"ICC_PROFILE\0";
/// Number of bytes that are read first for a header.
const FIRST_BYTES: u64 = 1 << 16;

/// A segment: its marker and contents, and where it ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment<'a> {
    pub marker: u8,
    pub contents: &'a [u8],
    pub end: usize,
}

/// Finds the next segment from `at`; stray bytes before it are skipped. The end of the image has no contents.
pub(super) fn next_segment(jpeg: &[u8], at: usize) -> Option<Segment<'_>> {
    // Fill bytes repeat 0xff; 0 and restarts belong to pixels.
    let is_marker = |pair: &[u8]| pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd8 | 0xff);
    let at = at + jpeg.get(at..)?.windows(2).position(is_marker)?;
    let marker = jpeg[at + 1];
    if marker == END_OF_IMAGE {
        return Some(Segment { marker, contents: &[], end: at + 2 });
    }
    // The length counts itself.
    let length = jpeg[at + 2..].first_chunk().map(|length| usize::from(u16::from_be_bytes(*length)))?;
    let contents = jpeg.get(at + 4..at + 2 + length)?;
    Some(Segment { marker, contents, end: at + 2 + length })
}

/// Segments up to the first scan.
fn segments(jpeg: &[u8]) -> impl Iterator<Item = Segment<'_>> {
    let next = |segment: &Segment<'_>| next_segment(jpeg, segment.end);
    successors(next_segment(jpeg, 2), next)
        .take_while(|segment| !matches!(segment.marker, START_OF_SCAN | END_OF_IMAGE))
}

/// Checks that the pixels of the first image of a file are complete.
///
/// # Errors
/// Returns what is wrong with the file.
pub(crate) fn check(jpeg: &[u8]) -> Result<(), String> {
    let mut scans = Scans::default();
    let mut at = 2;
    while let Some(segment) = next_segment(jpeg, at) {
        at = match segment.marker {
            END_OF_IMAGE => return scans.check_complete(),
            START_OF_SCAN => scans.walk(segment.contents, jpeg, segment.end)?,
            marker => {
                scans.define(marker, segment.contents)?;
                segment.end
            }
        };
    }
    Err("no end-of-image marker (FF D9): the JPEG is truncated".to_owned())
}

pub(super) fn header(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Header, FormatError> {
    let bytes = head(reader, ask)?;
    let decoder = decoder(&bytes, ask)?;
    let (width, height) = decoder.dimensions();
    let exif = segments(&bytes).find_map(|one| one.contents.strip_prefix(EXIF).filter(|_| one.marker == APP1));
    let exif = exif.map(Exif::from_bytes).unwrap_or_default();
    let orientation = Orientation::of(exif.orientation.unwrap_or(1));
    let size = orientation.size([width as usize, height as usize]);
    ask.check_size(size)?;
    let channels = usize::from(decoder.color_type().channel_count());
    let colour = ask.colour(|| colour(&bytes, channels, exif))?;
    Ok(Header { size, channels, depth: Depth::U8, colour, orientation, notes: Vec::new() })
}

/// Colour by the ICC profile, or else by EXIF.
fn colour(jpeg: &[u8], channels: usize, exif: Exif) -> Result<Colour, FormatError> {
    let parts: Vec<&[u8]> = segments(jpeg)
        .filter(|segment| segment.marker == APP2)
        .filter_map(|segment| segment.contents.strip_prefix(ICC))
        .collect();
    if !parts.is_empty() {
        return Colour::of_profile(&profile(&parts)?, channels);
    }
    exif.colour()
}

/// Joins the parts of a profile: each begins with its number, from 1, and the number of parts.
fn profile(parts: &[&[u8]]) -> Result<Vec<u8>, FormatError> {
    let numbered: BTreeMap<u8, &[u8]> =
        parts.iter().filter_map(|part| part.split_first_chunk()).map(|([number, _], rest)| (*number, rest)).collect();
    let stated = parts[0].get(1).copied().unwrap_or(0);
    if numbered.len() != usize::from(stated) || !numbered.keys().copied().eq(1..=stated) {
        let found = format!("{} parts of {stated}", numbered.len());
        return Err(FormatError::whole("ICC profile", found, "all parts of the profile"));
    }
    Ok(numbered.into_values().flatten().copied().collect())
}

pub(super) fn samples(mut reader: impl ImageReader, ask: &Ask<'_>) -> Result<Raster, FormatError> {
    let mut bytes = all(&mut reader, ask)?;
    state_transform(&mut bytes);
    check(&bytes).map_err(|problem| ask.broken(problem))?;
    let decoder = decoder(&bytes, ask)?;
    let (width, height) = decoder.dimensions();
    let channels = usize::from(decoder.color_type().channel_count());
    let size = [width as usize, height as usize];
    let mut samples = filled("pixels", size[0] * size[1] * channels, 0u8)?;
    decoder.read_image(&mut samples).map_err(|error| ask.broken(error))?;
    Ok(Raster { size, channels, samples: Samples::U8(samples) })
}

/// States the transform of colours that libjpeg takes (`default_decompress_parms` of version 6b and later), which the decoder reads from
/// names of components first, and then from Adobe's segments: YCbCr in JFIF files, that of the last segment of Adobe in others, and RGB
/// without both if components are named so.
fn state_transform(jpeg: &mut Vec<u8>) {
    let frame = segments(jpeg).find(|segment| matches!(segment.marker, 0xc0..=0xc2));
    let Some([_, _, _, _, _, 3, components @ ..]) = frame.map(|frame| frame.contents) else { return };
    let is_named = components.iter().copied().step_by(3).eq(*b"RGB");
    let is_jfif = segments(jpeg).any(|one| one.marker == APP0 && one.contents.starts_with(JFIF));
    let transforms: Vec<usize> = segments(jpeg)
        .filter(|one| one.marker == APP14 && one.contents.starts_with(ADOBE) && one.contents.len() > TRANSFORM)
        .map(|one| one.end - one.contents.len() + TRANSFORM)
        .collect();
    let is_rgb = !is_jfif && transforms.last().map_or(is_named, |at| jpeg[*at] == 0);
    if is_named && !is_rgb {
        // Places of names in the frame and in all scans, which only these rare files are searched for.
        let all = successors(next_segment(jpeg, 2), |segment| next_segment(jpeg, segment.end));
        let of_frame = frame.into_iter().map(|one| (one.end - one.contents.len() + 6, 3, 3));
        let of_scans = all.filter(|one| one.marker == START_OF_SCAN && !one.contents.is_empty());
        let of_scans = of_scans.map(|one| (one.end - one.contents.len() + 1, 2, usize::from(one.contents[0]).min(3)));
        let names: Vec<usize> =
            of_frame.chain(of_scans).flat_map(|(at, step, count)| (0..count).map(move |k| at + step * k)).collect();
        for at in names {
            jpeg[at..].iter_mut().take(1).for_each(u8::make_ascii_lowercase);
        }
    }
    for at in &transforms {
        jpeg[*at] = u8::from(!is_rgb);
    }
    if is_rgb && transforms.is_empty() {
        let contents = [ADOBE, &[0; TRANSFORM - ADOBE.len() + 1]].concat();
        let length = (contents.len() as u16 + 2).to_be_bytes();
        jpeg.splice(2..2, [&[0xff, APP14], &length[..], &contents].concat());
    }
}

fn all(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Vec<u8>, FormatError> {
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).map_err(|error| ask.broken(error))?;
    Ok(bytes)
}

/// Reads a file at least up to the header of its first scan, so that opening many photographs does not read them all.
fn head(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Vec<u8>, FormatError> {
    let mut bytes = Vec::new();
    let mut target = FIRST_BYTES;
    loop {
        let missing = target - bytes.len() as u64;
        reader.by_ref().take(missing).read_to_end(&mut bytes).map_err(|error| ask.broken(error))?;
        let next = |segment: &Segment<'_>| next_segment(&bytes, segment.end);
        let mut all = successors(next_segment(&bytes, 2), next);
        if (bytes.len() as u64) < target || all.any(|one| matches!(one.marker, START_OF_SCAN | END_OF_IMAGE)) {
            return Ok(bytes);
        }
        target *= 2;
    }
}

/// The decoder of a file of grey or of colours.
fn decoder<'a>(jpeg: &'a [u8], ask: &Ask<'_>) -> Result<JpegDecoder<Cursor<&'a [u8]>>, FormatError> {
    if segments(jpeg).any(|segment| matches!(segment.marker, 0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf | 0xf7)) {
        return Err(ask.found("JPEG of a lossless, hierarchical or arithmetic code"));
    }
    let decoder = JpegDecoder::new(Cursor::new(jpeg)).map_err(|error| ask.broken(error))?;
    // The first byte after precision and size is the number of components.
    let frame = segments(jpeg).find(|segment| matches!(segment.marker, 0xc0..=0xc2));
    if frame.and_then(|frame| frame.contents.get(5)).is_some_and(|components| *components > 3) {
        return Err(ask.found("JPEG of CMYK"));
    }
    Ok(decoder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jpeg() -> Vec<u8> {
        let mut jpeg = Cursor::new(Vec::new());
        let noise =
            image::RgbImage::from_fn(40, 24, |x, y| image::Rgb([(x * 61) as u8, (y * 99) as u8, (x * y) as u8]));
        noise.write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
        jpeg.into_inner()
    }

    /// jpeg-decoder 249: a JFIF file with a segment of Adobe that states RGB is YCbCr. Files of libjpeg without both segments, whose
    /// components are named R, G and B, are RGB.
    #[test]
    fn transforms_of_colours_are_those_of_libjpeg() {
        let red = image::RgbImage::from_pixel(8, 8, image::Rgb([200, 20, 30]));
        let mut plain = Cursor::new(Vec::new());
        red.write_to(&mut plain, image::ImageFormat::Jpeg).unwrap();
        let plain = plain.into_inner();
        let adobe = |transform: u8| [&[0xff, APP14, 0, 14][..], ADOBE, &[0, 100, 0, 0, 0, 0, transform]].concat();
        let ask = Ask {
            purpose: crate::image_file::Purpose::Data,
            field: "image",
            allowed: "a JPEG",
            formats: &[image::ImageFormat::Jpeg],
            check: &|_| Ok(()),
        };
        let first = |jpeg: &[u8]| {
            let Samples::U8(samples) = samples(Cursor::new(jpeg), &ask).unwrap().samples else { panic!("8 bits") };
            [samples[0], samples[1], samples[2]]
        };
        let expected = first(&plain);
        assert!(expected[0] > 190 && expected[1] < 40, "{expected:?}");
        for transform in [0, 1] {
            let both = [&plain[..2 + 18], &adobe(transform), &plain[2 + 18..]].concat();
            assert_eq!(first(&both), expected);
        }
        // Without JFIF, Adobe's segment decides, and then the names.
        let without = [&plain[..2], &plain[2 + 18..]].concat();
        let stored = first(&[&without[..2], &adobe(0), &without[2..]].concat());
        assert_ne!(stored, expected);
        assert_eq!(first(&without), expected);
        let mut named = without;
        let frame = named.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        let scan = named.windows(2).position(|pair| pair == [0xff, START_OF_SCAN]).unwrap();
        for (k, name) in [b'R', b'G', b'B'].into_iter().enumerate() {
            (named[frame + 10 + 3 * k], named[scan + 5 + 2 * k]) = (name, name);
        }
        assert_eq!(first(&named), stored);
        // Names count last.
        assert_eq!(first(&[&named[..2], &adobe(1), &named[2..]].concat()), expected);
        assert_eq!(first(&[&named[..2], &plain[2..2 + 18], &named[2..]].concat()), expected);
        assert_eq!(first(&[&named[..2], &adobe(1), &adobe(0), &named[2..]].concat()), stored);
        assert_eq!(first(&[&named[..2], &plain[2..2 + 18], &adobe(1), &adobe(0), &named[2..]].concat()), expected);
    }

    #[test]
    fn a_truncated_image_is_refused() {
        let jpeg = jpeg();
        assert_eq!(check(&jpeg), Ok(()));
        assert!((0..jpeg.len()).all(|length| check(&jpeg[..length]).is_err()));
        // The decoder accepts many of these, and more of those that are closed.
        let decoded = (0..jpeg.len()).filter(|length| image::load_from_memory(&jpeg[..*length]).is_ok()).count();
        assert!(decoded > 100, "{decoded}");
        let closed = |length: usize| [&jpeg[..length], &[0xff, END_OF_IMAGE]].concat();
        let accepted: Vec<usize> = (2..jpeg.len() - 2).filter(|length| check(&closed(*length)).is_ok()).collect();
        // A cut in the padding of the last byte loses nothing.
        assert!(accepted.len() <= 1, "{accepted:?}");
    }

    /// A header is read without the pixels, also behind long segments.
    #[test]
    fn headers_are_read_up_to_the_first_scan() {
        let jpeg = jpeg();
        let long = [&[0xff, 0xe4, 0xff, 0xff][..], &[7; 65533]].concat();
        for segments in [0, 3] {
            let whole = [&jpeg[..2], &long.repeat(segments), &jpeg[2..], &vec![0; 4 << 20]].concat();
            let ask = Ask {
                purpose: super::super::Purpose::Colours(None),
                field: "image",
                allowed: "",
                formats: &[],
                check: &|_| Ok(()),
            };
            let mut reader = Cursor::new(whole);
            assert_eq!(header(&mut reader, &ask).unwrap().size, [40, 24]);
            assert!(reader.position() <= 1 << 18, "{segments}: {}", reader.position());
        }
    }

    /// Bounds the memory of a frame, which a file of a few bytes could ask for.
    #[test]
    fn frames_are_of_grey_or_three_components() {
        let jpeg = jpeg();
        let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        for count in [0, 2, 4, 255] {
            let part = |id: u8| [id, 0x11, 0];
            let parts: Vec<u8> = (0..count).flat_map(part).collect();
            let length = (8 + parts.len() as u16).to_be_bytes();
            let of_frame = [&[0xff, 0xc2][..], &length, &jpeg[frame + 4..frame + 9], &[count], &parts].concat();
            let found = check(&[&jpeg[..2], &of_frame].concat());
            assert_eq!(found, Err(format!("JPEG of {count} components")));
        }
    }

    /// Decoders disagree about luma that is sampled more coarsely than chroma; the other way round is usual.
    #[test]
    fn luma_is_not_coarser_than_chroma() {
        let jpeg = jpeg();
        let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        let sampled = |luma: u8, chroma: u8| {
            let mut jpeg = jpeg.clone();
            [(11, luma), (14, chroma), (17, chroma)].into_iter().for_each(|(at, factors)| jpeg[frame + at] = factors);
            check(&jpeg)
        };
        let expected = Err("JPEG whose luma is sampled more coarsely than its chroma".to_owned());
        for (luma, chroma) in [(0x11, 0x22), (0x11, 0x21), (0x12, 0x21)] {
            assert_eq!(sampled(luma, chroma), expected, "{luma:x} {chroma:x}");
        }
        // Frames of other sampling lack data instead.
        assert_ne!(sampled(0x22, 0x11), expected);
    }

    /// The end of an embedded preview does not count; fill bytes, stray bytes and trailing bytes are ignored.
    #[test]
    fn previews_and_other_bytes_are_skipped() {
        let jpeg = jpeg();
        let segment = |marker: u8, contents: &[u8]| {
            [&[0xff, marker][..], &(contents.len() as u16 + 2).to_be_bytes(), contents].concat()
        };
        let [preview, comment] = [segment(0xe1, &jpeg), segment(0xfe, b"\xff\xd9")];
        for before in [preview.clone(), [&[0xff, 0xff], &comment[..]].concat(), [&preview[..], b"\0"].concat()] {
            let whole = [&jpeg[..2], &before, &jpeg[2..], b"more"].concat();
            assert!(image::load_from_memory(&whole).is_ok());
            assert_eq!(check(&whole), Ok(()));
            assert!(check(&whole[..whole.len() - 6]).is_err());
        }
    }
}
