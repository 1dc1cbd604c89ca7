//! Mipmap levels of a file: their location, checks before decompression, and decompression.

use crate::{FormatError, memory};
use std::io::Cursor;

/// Checks that no two levels share bytes of the file.
///
/// # Errors
/// Returns an error at the `byteOffset` of the coarser one.
pub(super) fn check_places(bytes: &[u8], levels: u32) -> Result<(), FormatError> {
    let entries = bytes.get(ktx2::Header::LENGTH..).unwrap_or(&[]).as_chunks::<{ ktx2::LevelIndex::LENGTH }>().0;
    let entries = entries.iter().take(levels as usize).map(ktx2::LevelIndex::from_bytes);
    let mut places: Vec<(u64, u64, usize)> =
        entries.enumerate().map(|(number, level)| (level.byte_offset, level.byte_length, number)).collect();
    places.sort_unstable();
    for (&(first, length, one), &(second, _, other)) in places.iter().zip(places.iter().skip(1)) {
        if first.saturating_add(length) > second {
            let (coarser, offset, finer) = if one > other { (one, first, other) } else { (other, second, one) };
            let allowed = format!("an offset outside the bytes of level {finer}");
            return Err(FormatError::at_byte(entry_of(coarser), "byteOffset", offset.to_string(), allowed));
        }
    }
    Ok(())
}

/// Decompresses the finest level of a KTX2 file of any writer: its bytes in the file, and their number after decompression as the
/// level index has it. `size` is the number that format and extent need.
///
/// # Errors
/// Same as for packs: an error if `size` contradicts the level index or a frame (before memory is allocated), for another
/// supercompression `scheme` than 0 (none) and 2 (Zstandard), or if decompression fails.
pub fn unpack_finest(
    data: &[u8],
    uncompressed_byte_length: u64,
    scheme: u32,
    size: u64,
) -> Result<Vec<u8>, FormatError> {
    unpack(&[ktx2::Level { data, uncompressed_byte_length }], scheme, &[size])
}

/// Decompresses levels into one buffer, one after the other. `sizes` are their decompressed lengths in bytes.
///
/// # Errors
/// Returns an error if the level index or a frame contradicts `sizes` (before memory is allocated), or if decompression
/// fails.
pub(super) fn unpack(stored: &[ktx2::Level<'_>], scheme: u32, sizes: &[u64]) -> Result<Vec<u8>, FormatError> {
    let levels = || stored.iter().zip(sizes).enumerate();
    for (number, (level, size)) in levels() {
        check(level, number, scheme, *size)?;
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
            .map_err(|error| wrong_frame(number, error.to_string(), *size).problem())?;
        // A frame that is too long would fit into the space of coarser levels.
        let found = (texels.get_ref().len() - before) as u64;
        if found != *size {
            return Err(wrong_frame(number, format!("{found} bytes"), *size));
        }
    }
    Ok(texels.into_inner())
}

/// Offset of a level index record in the file.
fn entry_of(number: usize) -> u64 {
    (ktx2::Header::LENGTH + number * ktx2::LevelIndex::LENGTH) as u64
}

/// Error for a level with invalid Zstandard data.
fn wrong_frame(number: usize, found: String, size: u64) -> FormatError {
    FormatError::whole(format!("level {number}"), found, format!("Zstandard data of {size} bytes"))
}

/// Checks that the data of a level can contain `size` bytes of texels, before memory is allocated.
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
            // Frames declare their content size.
            let declared = zstd::zstd_safe::get_frame_content_size(level.data).ok().flatten();
            if declared != Some(size) {
                return Err(match declared {
                    Some(declared) => wrong_frame(number, format!("a frame of {declared} bytes"), size),
                    None => wrong_frame(number, "no content size".to_owned(), size).problem(),
                });
            }
            // A block of up to 128 KiB takes at least 4 bytes.
            if size > (level.data.len() as u64 / 4 + 1) << 17 {
                let found = format!("too short: {} bytes", level.data.len());
                return Err(wrong_frame(number, found, size).problem());
            }
            Ok(())
        }
        other => {
            Err(FormatError::at_byte(44, "supercompressionScheme", other.to_string(), "0 (none) or 2 (Zstandard)"))
        }
    }
}
