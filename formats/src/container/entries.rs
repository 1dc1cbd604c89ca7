//! Access to the `brdfc.*` key/value data of a texture.

use crate::FormatError;
use crate::container::{Extent, TexelFormat, Texture};
use std::collections::BTreeMap;

/// Value of `key`. `kind`, such as "a wavelet pack", names the pack in errors.
pub(crate) fn entry<'a>(texture: &'a Texture, key: &'static str, kind: &str) -> Result<&'a [u8], FormatError> {
    value_of(&texture.entries, key, kind)
}

/// Same as [`entry`] for the key/value data alone.
pub(crate) fn value_of<'a>(
    entries: &'a BTreeMap<String, Vec<u8>>,
    key: &'static str,
    kind: &str,
) -> Result<&'a [u8], FormatError> {
    entries.get(key).map(Vec::as_slice).ok_or_else(|| {
        let keys: Vec<_> = entries.keys().map(String::as_str).collect();
        missing(key, &keys, kind)
    })
}

/// Error of a missing key. `keys` are the keys of the file, and `kind` names the expected contents.
pub(crate) fn missing(key: &'static str, keys: &[&str], kind: &str) -> FormatError {
    let found = match keys {
        [] => "no brdfc keys".to_owned(),
        keys => format!("not among the keys {}", keys.join(", ")),
    };
    FormatError::whole(key, found, format!("the keys of {kind}")).problem()
}

/// Checks that the texels of `what` have the format and extent that the value of `key` declares.
pub(crate) fn check_texels(
    texture: &Texture,
    what: &'static str,
    extent: Extent,
    format: TexelFormat,
    key: &str,
) -> Result<(), FormatError> {
    if (texture.extent, texture.format) == (extent, format) {
        return Ok(());
    }
    let found = format!("{} texels of {:?}", texture.extent, texture.format);
    Err(FormatError::whole(what, found, format!("{extent} texels of {format:?}, as {key} says")))
}

/// Returns the value if it has the expected length.
pub(crate) fn sized<'a>(bytes: &'a [u8], key: &'static str, length: usize) -> Result<&'a [u8], FormatError> {
    if bytes.len() == length {
        return Ok(bytes);
    }
    Err(FormatError::whole(key, format!("{} bytes", bytes.len()), format!("{length} bytes")))
}
