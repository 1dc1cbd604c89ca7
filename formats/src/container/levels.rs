//! Mipmap levels of a file: where they are, what is checked before they are unpacked, and unpacking.

use crate::{FormatError, memory};
use std::io::Cursor;

/// Refuses level index entries of which two share bytes of the file.
///
/// # Errors
/// The coarser of the two, with its `byteOffset`.
pub(super) fn check_places(bytes: &[u8], levels: u32) -> Result<(), FormatError> {
    let entries = bytes.get(ktx2::Header::LENGTH..).unwrap_or(&[]).as_chunks::<{ ktx2::LevelIndex::LENGTH }>().0;
    let entries = entries.iter().take(levels as usize).map(ktx2::LevelIndex::from_bytes);
    let mut places: Vec<(u64, u64, usize)> =
        entries.enumerate().map(|(number, level)| (level.byte_offset, level.byte_length, number)).collect();
    places.sort_unstable();
    for (&(first, length, one), &(second, _, other)) in places.iter().zip(places.iter().skip(1)) {
        if first.saturating_add(length) > second {
            let (coarser, offset, finer) = if one > other { (one, first, other) } else { (other, second, one) };
            let allowed = format!("what is outside the bytes of level {finer}");
            return Err(FormatError::at_byte(entry_of(coarser), "byteOffset", offset.to_string(), allowed));
        }
    }
    Ok(())
}

/// Unpacks levels one behind the other, of `sizes` bytes of texels.
///
/// # Errors
/// What a level index or frame says that is not so, before memory is asked for; texels that cannot be unpacked.
pub(super) fn unpack(reader: &ktx2::Reader<&[u8]>, scheme: u32, sizes: &[u64]) -> Result<Vec<u8>, FormatError> {
    let levels = || reader.levels().zip(sizes).enumerate();
    for (number, (level, size)) in levels() {
        check(&level, number, scheme, *size)?;
    }
    let mut texels = memory::reserved("texels", sizes.iter().sum::<u64>() as usize)?;
    if scheme == 0 {
        levels().for_each(|(_, (level, _))| texels.extend_from_slice(level.data));
        return Ok(texels);
    }
    let mut texels = Cursor::new(texels);
    for (number, (level, size)) in levels() {
        let before = texels.get_ref().len();
        texels.set_position(before as u64);
        zstd::bulk::Decompressor::new()
            .and_then(|mut decompressor| decompressor.decompress_to_buffer(level.data, &mut texels))
            .map_err(|error| wrong_frame(number, error.to_string(), *size))?;
        // A frame that is too long finds room, that of the coarser levels.
        let found = (texels.get_ref().len() - before) as u64;
        if found != *size {
            return Err(wrong_frame(number, format!("{found} bytes"), *size));
        }
    }
    Ok(texels.into_inner())
}

/// Offset of a level index entry in the file.
fn entry_of(number: usize) -> u64 {
    (ktx2::Header::LENGTH + number * ktx2::LevelIndex::LENGTH) as u64
}

/// What a level with wrong Zstandard data is told as.
fn wrong_frame(number: usize, found: String, size: u64) -> FormatError {
    FormatError::whole(format!("level {number}"), found, format!("Zstandard data of {size} bytes"))
}

/// Whether a level of `size` bytes of texels may be in its data, before memory for them is asked for.
fn check(level: &ktx2::Level<'_>, number: usize, scheme: u32, size: u64) -> Result<(), FormatError> {
    let entry = entry_of(number);
    let wrong_size = |offset, field, found: u64| {
        FormatError::at_byte(offset, field, found.to_string(), format!("{size}, as format and extent say"))
    };
    if level.uncompressed_byte_length != size {
        return Err(wrong_size(entry + 16, "uncompressedByteLength", level.uncompressed_byte_length));
    }
    match scheme {
        0 if level.data.len() as u64 == size => Ok(()),
        0 => Err(wrong_size(entry + 8, "byteLength", level.data.len() as u64)),
        2 => {
            // A frame says how long its contents are.
            let declared = zstd::zstd_safe::get_frame_content_size(level.data).ok().flatten();
            if declared != Some(size) {
                let found = declared.map_or("no content size".to_owned(), |n| format!("a frame of {n} bytes"));
                return Err(wrong_frame(number, found, size));
            }
            // A block of 128 KiB takes 4 bytes at least.
            if size > (level.data.len() as u64 / 4 + 1) << 17 {
                return Err(wrong_frame(number, format!("{} bytes, too few for that", level.data.len()), size));
            }
            Ok(())
        }
        other => {
            Err(FormatError::at_byte(44, "supercompressionScheme", other.to_string(), "0 (none) or 2 (Zstandard)"))
        }
    }
}
