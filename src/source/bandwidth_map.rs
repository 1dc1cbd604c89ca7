//! Maps of bandwidth as files.

use super::open::{InputError, MAX_FILE_BYTES, extension_of, read_file};
use brdfc_formats::pack::Texture;
use brdfc_formats::pack::bandwidth::{BandwidthKind, BandwidthMap, MAX_SIDE};
use std::path::Path;

/// What is worth knowing about a map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct BandwidthFacts {
    /// 'brdf', 'environment' or 'texture'.
    pub of: String,
    /// Unit of the bandwidths.
    pub unit: String,
    /// Texels per row and rows.
    pub size: [u32; 2],
    /// Width and height of the image that was transformed; of materials, of each lobe.
    pub transformed: [u32; 2],
    /// Share of the largest coefficient that does not count.
    pub epsilon: f32,
    /// Width and height of a texture in metres.
    pub metres: Option<[f32; 2]>,
    /// Whether a texture repeats.
    pub tiles: Option<bool>,
    /// Largest bandwidth.
    pub largest: f32,
    /// Mean of all texels.
    pub mean: f64,
    /// Share of texels without any variation, 0 to 1.
    pub constant: f64,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
}

impl BandwidthFacts {
    /// Of a map.
    pub fn new(map: &BandwidthMap) -> Self {
        let (header, values) = (map.header(), map.values());
        let (metres, tiles) = match header.kind {
            BandwidthKind::Texture { metres, tiles } => (Some(metres), Some(tiles)),
            _ => (None, None),
        };
        let count = values.len() as f64;
        Self {
            of: header.kind.name().to_owned(),
            unit: header.kind.unit().to_owned(),
            size: map.size(),
            transformed: header.transformed,
            epsilon: header.epsilon,
            metres,
            tiles,
            largest: values.iter().copied().fold(0.0, f32::max),
            mean: values.iter().map(|value| f64::from(*value)).sum::<f64>() / count,
            constant: values.iter().filter(|value| **value == 0.0).count() as f64 / count,
            gpu_bytes: map.texel_bytes().len() as u64,
        }
    }
}

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
