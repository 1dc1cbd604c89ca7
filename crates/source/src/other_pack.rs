//! Packs that have no reflectance of their own: which one a file is, and what it holds.

use super::open::{InputError, MAX_FILE_BYTES, extension_of, read_file};
use brdfc_formats::FormatError;
use brdfc_formats::bandwidth::{BANDWIDTH_ENTRY, BandwidthMap, MAX_SIDE};
use brdfc_formats::container::{MAX_TEXEL_BYTES, PackedTexture};
use brdfc_formats::importance::{IMPORTANCE_ENTRY, ImportancePack};
use std::path::Path;

/// A pack without reflectance.
#[derive(Debug, Clone, PartialEq)]
pub enum OtherPack {
    /// A bandwidth map.
    Bandwidth(BandwidthMap),
    /// Importance samples.
    Importance(ImportancePack),
}

/// The pack in a file; nothing where it is of another kind, or no pack at all: whoever opens what it is says what is wrong.
/// Its entry decides, and texels are unpacked once.
///
/// # Errors
/// Files that cannot be read; packs that break the rules of their layout.
pub fn open_other_pack(path: &Path) -> Result<Option<OtherPack>, InputError> {
    if extension_of(path) != "ktx2" {
        return Ok(None);
    }
    from_bytes(&read_file(path, MAX_FILE_BYTES)?)
        .map_err(|error| InputError::Format { name: path.display().to_string(), error })
}

fn from_bytes(bytes: &[u8]) -> Result<Option<OtherPack>, FormatError> {
    let Ok(packed) = PackedTexture::from_bytes(bytes) else { return Ok(None) };
    let has = |entry: &str| packed.entries.contains_key(entry);
    Ok(if has(BANDWIDTH_ENTRY) {
        // No map is larger.
        let limit = 2 * u64::from(MAX_SIDE) * u64::from(MAX_SIDE);
        Some(OtherPack::Bandwidth(BandwidthMap::from_texture(&packed.unpack(limit)?)?))
    } else if has(IMPORTANCE_ENTRY) {
        Some(OtherPack::Importance(ImportancePack::from_texture(&packed.unpack(MAX_TEXEL_BYTES)?)?))
    } else {
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::importance::ImportanceHeader;

    #[test]
    fn the_entry_decides_and_broken_packs_are_errors() {
        let header = ImportanceHeader { polar: 2, azimuths: 1, samples: 2 };
        let pack = ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 4]).unwrap();
        let bytes = pack.to_bytes(false);
        assert_eq!(from_bytes(&bytes).unwrap(), Some(OtherPack::Importance(pack)));
        assert_eq!(from_bytes(b"no pack").unwrap(), None);
        let at = bytes.len() - 4;
        let broken = [&bytes[..at], &(-1.0f32).to_le_bytes()].concat();
        assert_eq!(from_bytes(&broken).unwrap_err().field, "importance texel (1, 1)");
        // Of another kind by its entry, whatever its texels are.
        let mut other = bytes.clone();
        let entry = other.windows(16).position(|bytes| bytes == IMPORTANCE_ENTRY.as_bytes()).unwrap();
        other[entry + 15] = b'x';
        assert_eq!(from_bytes(&other).unwrap(), None);
    }
}
