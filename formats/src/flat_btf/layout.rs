//! Checks that all parts of a flat BTF share: sizes, formats and ranges.

use crate::FormatError;
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture};
use crate::cursor::Cursor;

pub(super) fn check_format(texture: &Texture, part: &'static str, format: TexelFormat) -> Result<(), FormatError> {
    texture.check_one_level()?;
    if texture.format == format {
        return Ok(());
    }
    let field = format!("texels of the part {part}");
    Err(FormatError::whole(field, format!("{:?}", texture.format), format!("{format:?}")))
}

pub(super) fn wrong_extent(part: &'static str, found: Extent, allowed: impl Into<String>) -> FormatError {
    FormatError::whole(format!("size of the part {part}"), found.to_string(), allowed)
}

/// Checks a side and the number of texels.
pub(super) fn check_square(
    part: &'static str,
    size: u32,
    layers: u32,
    most_layers: u32,
    found: usize,
) -> Result<(), FormatError> {
    if !(1..=MAX_EXTENT_2D).contains(&size) {
        let field = format!("size of the part {part}");
        return Err(FormatError::whole(field, size.to_string(), format!("1 to {MAX_EXTENT_2D} texels")));
    }
    FormatError::check_range(format!("layers of the part {part}"), layers, 1..=most_layers)?;
    let expected = u64::from(size) * u64::from(size) * u64::from(layers);
    if found as u64 != expected {
        let field = format!("texels of the part {part}");
        return Err(FormatError::whole(field, found.to_string(), format!("{expected}, as its size says")));
    }
    Ok(())
}

/// Reads and validates a word of a header.
pub(super) fn word(
    cursor: &mut Cursor<'_>,
    key: &'static str,
    field: &'static str,
    range: std::ops::RangeInclusive<u32>,
) -> Result<u32, FormatError> {
    let value = cursor.u32(field)?;
    if range.contains(&value) {
        return Ok(value);
    }
    let (first, last) = (range.start(), range.end());
    let allowed = if first == last { first.to_string() } else { format!("{first} to {last}") };
    Err(FormatError::whole(format!("{key} {field}"), value.to_string(), allowed))
}

/// Texels of `N` 32-bit floats.
pub(super) fn floats<const N: usize>(bytes: &[u8]) -> Vec<[f32; N]> {
    bytes.as_chunks::<4>().0.as_chunks::<N>().0.iter().map(|texel| texel.map(f32::from_le_bytes)).collect()
}

/// Texels of one word.
pub(super) fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect()
}
