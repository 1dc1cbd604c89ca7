//! Properties of packs' KTX2 files: key/value data for loaders that drop it, and required features of devices.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use brdfc_formats::FormatError;
use brdfc_formats::container::PackedTexture;
use brdfc_shaders::DeviceNeeds;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Prefix of keys whose values are KTX2 files.
const NESTED: &str = "brdfc.image.";

/// One texture of a file.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PackFile {
    /// Texel format, by its name in WebGPU.
    pub texel_format: &'static str,
    /// '2d', '2d-array', '3d' or 'cube'.
    pub dimension: &'static str,
    /// Columns, rows, and slices, layers or faces.
    pub size: [u32; 3],
    /// Number of mipmap levels.
    pub levels: u32,
    /// Required features of a device.
    pub device: DeviceNeeds,
    /// The file's key/value data in Base64, which loaders of ordinary KTX2 files drop.
    pub entries: BTreeMap<String, String>,
}

/// The textures of a file, by name. Textures in its key/value data are named `NAME#KEY`.
///
/// # Errors
/// Returns an error if the file is not a valid KTX2 file.
pub fn pack_files(name: &str, file: &[u8]) -> Result<BTreeMap<String, PackFile>, FormatError> {
    let packed = PackedTexture::from_bytes(file)?;
    let mut files = BTreeMap::new();
    for (key, value) in packed.entries.iter().filter(|(key, _)| key.starts_with(NESTED)) {
        let nested = PackedTexture::from_bytes(value)?;
        files.insert(format!("{name}#{key}"), of_texture(&nested));
    }
    files.insert(name.to_owned(), of_texture(&packed));
    Ok(files)
}

fn of_texture(packed: &PackedTexture<'_>) -> PackFile {
    PackFile {
        texel_format: packed.format.name(),
        dimension: packed.extent.dimension(),
        size: packed.extent.size(),
        levels: packed.levels,
        device: DeviceNeeds::of(packed.format, packed.extent),
        entries: encoded(&packed.entries),
    }
}

/// Key/value data of a pack's file in Base64; empty if the file is invalid.
pub fn entries(file: &[u8]) -> BTreeMap<String, String> {
    PackedTexture::from_bytes(file).map(|packed| encoded(&packed.entries)).unwrap_or_default()
}

fn encoded(entries: &BTreeMap<String, Vec<u8>>) -> BTreeMap<String, String> {
    entries.iter().map(|(key, value)| (key.clone(), STANDARD.encode(value))).collect()
}
