//! Checks that all parts of a flat BTF share: sizes, formats and ranges.

use super::MAX_COORDINATE;
use crate::FormatError;
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture};
use crate::cursor::Cursor;

/// Version of the headers.
pub(super) const VERSION: u32 = 1;

/// Reads a square 2D texture. Returns its side.
pub(super) fn square(texture: &Texture, part: &'static str, format: TexelFormat) -> Result<u32, FormatError> {
    check_format(texture, part, format)?;
    match texture.extent {
        Extent::D2([width, height]) if width == height => Ok(width),
        other => Err(wrong_extent(part, other, "a square 2D texture")),
    }
}

/// Reads a 2D array of square layers. Returns its side and number of layers.
pub(super) fn square_layers(
    texture: &Texture,
    part: &'static str,
    format: TexelFormat,
) -> Result<[u32; 2], FormatError> {
    check_format(texture, part, format)?;
    match texture.extent {
        Extent::D2Array([width, height, layers]) if width == height => Ok([width, layers]),
        other => Err(wrong_extent(part, other, "a 2D array of square layers")),
    }
}

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

/// Checks all texels of a square.
pub(super) fn check_texels<T>(
    part: &'static str,
    size: u32,
    texels: &[T],
    allowed: &str,
    format: impl Fn(&T) -> String,
    good: impl Fn(&T) -> bool,
) -> Result<(), FormatError> {
    let Some(at) = texels.iter().position(|texel| !good(texel)) else { return Ok(()) };
    let (column, row) = (at % size as usize, at / size as usize);
    Err(FormatError::whole(format!("{part} texel ({column}, {row})"), format(&texels[at]), allowed))
}

/// Returns true if a coordinate is a number in range.
pub(super) fn is_coordinate(value: f32) -> bool {
    value.abs() <= MAX_COORDINATE
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

/// Texels of four halves, as bits.
pub(super) fn halves(bytes: &[u8]) -> Vec<[u16; 4]> {
    bytes.as_chunks::<2>().0.as_chunks::<4>().0.iter().map(|texel| texel.map(u16::from_le_bytes)).collect()
}

/// Bytes of texels of four halves.
pub(super) fn half_bytes(texels: &[[u16; 4]]) -> Vec<u8> {
    texels.iter().flatten().flat_map(|half| half.to_le_bytes()).collect()
}
