//! KTX2 files of packs as their bytes say it: what a loader that drops entries, or a device that has to hold them, wants to know.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use brdfc_formats::FormatError;
use brdfc_formats::container::PackedTexture;
use brdfc_shaders::DeviceNeeds;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Entries that hold a KTX2 file each.
const NESTED: &str = "brdfc.image.";

/// One texture of a file.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PackFile {
    /// How a texel is stored, by its name in WebGPU.
    pub texel_format: &'static str,
    /// '2d', '2d-array' or '3d'.
    pub dimension: &'static str,
    /// Columns, rows, and slices or layers.
    pub size: [u32; 3],
    /// Mipmap levels.
    pub levels: u32,
    /// What it asks of a device.
    pub device: DeviceNeeds,
    /// The file's entries, in Base64: loaders of ordinary KTX2 files drop them.
    pub entries: BTreeMap<String, String>,
}

/// The textures of a file by this name, with those that its entries hold, as `NAME#ENTRY`.
///
/// # Errors
/// What is no KTX2 file.
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

/// Entries of a pack's file, in Base64.
pub fn entries(file: &[u8]) -> BTreeMap<String, String> {
    PackedTexture::from_bytes(file).map(|packed| encoded(&packed.entries)).unwrap_or_default()
}

fn encoded(entries: &BTreeMap<String, Vec<u8>>) -> BTreeMap<String, String> {
    entries.iter().map(|(key, value)| (key.clone(), STANDARD.encode(value))).collect()
}
