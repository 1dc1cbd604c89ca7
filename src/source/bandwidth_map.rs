//! Maps of bandwidth as files.

use super::open::{InputError, MAX_FILE_BYTES, extension_of, read_file};
use brdfc_formats::pack::Texture;
use brdfc_formats::pack::bandwidth::{BandwidthMap, MAX_SIDE};
use std::path::Path;

/// The map in a file; nothing where it is of another kind, or no pack at all.
///
/// # Errors
/// Files that cannot be read; maps that break the rules of their layout.
pub fn open_bandwidth_map(path: &Path) -> Result<Option<BandwidthMap>, InputError> {
    if extension_of(path) != "ktx2" {
        return Ok(None);
    }
    let bytes = read_file(path, MAX_FILE_BYTES)?;
    // No map is larger; whoever opens the pack that it is says what is wrong with other files.
    let limit = 2 * u64::from(MAX_SIDE) * u64::from(MAX_SIDE);
    match Texture::from_bytes_within(&bytes, limit) {
        Ok(texture) if BandwidthMap::is_one(&texture) => BandwidthMap::from_texture(&texture)
            .map(Some)
            .map_err(|error| InputError::Format { name: path.display().to_string(), error }),
        _ => Ok(None),
    }
}
