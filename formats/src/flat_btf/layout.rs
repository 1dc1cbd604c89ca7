//! Checks that all parts of a flat BTF share: sizes, formats and ranges.

use crate::FormatError;
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture, half};
use crate::cursor::Cursor;

/// Maximum absolute difference of the parameters of a point from its position, in tiles.
pub const MAX_DISPLACEMENT: f32 = 1024.0;

pub(super) fn check_format(texture: &Texture, part: &'static str, format: TexelFormat) -> Result<(), FormatError> {
    texture.check_one_level()?;
    if texture.format == format {
        return Ok(());
    }
    let field = format!("texels of the part {part}");
    Err(FormatError::whole(field, format!("{:?}", texture.format), format!("{format:?}")))
}

/// Checks format, extent and number of mipmap levels of an image against the header with the key `header`.
pub(super) fn check_image(
    texture: &Texture,
    part: &'static str,
    expected: (TexelFormat, Extent, u32),
    header: &str,
) -> Result<(), FormatError> {
    let found = (texture.format, texture.extent, texture.levels);
    if found == expected {
        return Ok(());
    }
    let form =
        |(format, extent, levels): (TexelFormat, Extent, u32)| format!("{levels} levels of {extent}, {format:?}");
    Err(FormatError::whole(format!("part {part}"), form(found), format!("{}, as {header} says", form(expected))))
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

/// Pairs of halves of a texture, decoded.
pub(super) fn half_pairs(bytes: &[u8]) -> Vec<[f32; 2]> {
    let pairs = bytes.as_chunks::<2>().0.as_chunks::<2>().0;
    pairs.iter().map(|pair| pair.map(|bytes| half::decode(u16::from_le_bytes(bytes)))).collect()
}

/// Pairs of numbers as halves in GPU layout.
pub(super) fn half_pair_bytes(pairs: &[[f32; 2]]) -> Vec<u8> {
    pairs.iter().flatten().flat_map(|c| half::encode(*c).to_le_bytes()).collect()
}

/// Rounds pairs of -1024 to 1024 to halves. `field` names a pair in errors.
pub(super) fn rounded_pairs(
    mut pairs: Vec<[f32; 2]>,
    field: impl Fn(usize) -> String,
) -> Result<Vec<[f32; 2]>, FormatError> {
    if let Some(at) = pairs.iter().position(|pair| !pair.iter().all(|c| c.abs() <= MAX_DISPLACEMENT)) {
        let allowed = format!("two numbers of -{MAX_DISPLACEMENT} to {MAX_DISPLACEMENT}");
        return Err(FormatError::whole(field(at), format!("{:?}", pairs[at]), allowed));
    }
    pairs.iter_mut().for_each(|pair| *pair = pair.map(|c| half::decode(half::encode(c))));
    Ok(pairs)
}

/// Texels of `N` 32-bit floats.
pub(super) fn floats<const N: usize>(bytes: &[u8]) -> Vec<[f32; N]> {
    bytes.as_chunks::<4>().0.as_chunks::<N>().0.iter().map(|texel| texel.map(f32::from_le_bytes)).collect()
}

/// Texels of one word.
pub(super) fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect()
}
