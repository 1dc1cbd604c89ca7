//! One part of a flat BTF alone: what it is, without the others.

use super::flat_btf::asset_of_part;
use super::open::{InputError, MAX_FILE_BYTES, read_file};
use brdfc_formats::FormatError;
use brdfc_formats::pack::flat_btf::{
    DiffuseMap, FlatView, IndirectionMap, NormalMap, PositionMap, ReferenceMap, VisibilityMask, gpu_bytes,
};
use brdfc_formats::pack::{Extent, PackedTexture};
use std::path::Path;

/// The entry that every wavelet pack has, and no part of a flat BTF.
const WAVELET_ENTRY: &str = "brdfc.wavelet";

/// What one file of a flat BTF holds.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct PartFacts {
    /// Name of the asset.
    pub asset: String,
    /// Which part; see `formats/spec/flat-btf.md`.
    pub part: String,
    /// How a texel is stored.
    pub format: String,
    /// Texels per row, rows, and layers of an array.
    pub extent: Vec<u32>,
    /// Bytes of the file.
    pub bytes: u64,
    /// Bytes of texels on a GPU, as `formats/spec/flat-btf.md` counts them: with the unused tiles of a view's layer, and 0
    /// of a part that no shader reads.
    pub gpu_bytes: u64,
    /// Of a view: its number, how many views there are, and how many lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_views_lights: Option<[usize; 3]>,
    /// Of an indirection map: polar angles and azimuths of its views.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polar_angles_azimuths: Option<[u32; 2]>,
}

/// Reads a file named `NAME.PART.ktx2`; nothing where the name is another, or the file is a wavelet pack of this name.
///
/// # Errors
/// Files that cannot be read or do not follow the part's layout.
pub fn open_part(path: &Path) -> Result<Option<PartFacts>, InputError> {
    let Some((asset, part)) = name_and_part(path) else { return Ok(None) };
    let bytes = read_file(path, MAX_FILE_BYTES)?;
    let format = |error| InputError::Format { name: path.display().to_string(), error };
    let texture = PackedTexture::from_bytes(&bytes).map_err(format)?;
    if texture.entries.contains_key(WAVELET_ENTRY) {
        return Ok(None);
    }
    let mut facts = PartFacts {
        asset,
        format: format!("{:?}", texture.format),
        extent: match texture.extent {
            Extent::D2(sides) => sides.to_vec(),
            Extent::D2Array(sides) | Extent::D3(sides) => sides.to_vec(),
        },
        bytes: bytes.len() as u64,
        gpu_bytes: gpu_bytes(&part, texture.extent),
        view_views_lights: None,
        polar_angles_azimuths: None,
        part,
    };
    drop(texture);
    describe(&mut facts, &bytes).map_err(format)?;
    Ok(Some(facts))
}

/// Reads the part by its own rules.
fn describe(facts: &mut PartFacts, bytes: &[u8]) -> Result<(), FormatError> {
    match facts.part.as_str() {
        "position" => PositionMap::from_bytes(bytes).map(drop),
        "normal" => NormalMap::from_bytes(bytes).map(drop),
        "reference" => ReferenceMap::from_bytes(bytes).map(drop),
        "diffuse" => DiffuseMap::from_bytes(bytes).map(drop),
        "mask" => VisibilityMask::from_bytes(bytes).map(drop),
        "indirection" => {
            let map = IndirectionMap::from_bytes(bytes)?;
            facts.polar_angles_azimuths = Some([map.header().zenith_samples, map.header().azimuth_samples]);
            Ok(())
        }
        _ => {
            let view = FlatView::from_bytes(bytes)?;
            let header = view.header();
            facts.view_views_lights = Some([header.view as usize, header.views.len(), header.lights.len()]);
            Ok(())
        }
    }
}

/// NAME and PART of a path `NAME.PART.ktx2`.
fn name_and_part(path: &Path) -> Option<(String, String)> {
    let file = path.file_name()?.to_str()?;
    let asset = asset_of_part(file)?;
    let part = file.get(asset.len() + 1..)?.rsplit_once('.')?.0.to_owned();
    Some((asset, part))
}

/// Whether what is no wavelet pack is a part of a flat BTF, by its entries or its name.
pub(super) fn is_part(path: &Path, bytes: &[u8]) -> bool {
    let Ok(texture) = PackedTexture::from_bytes(bytes) else { return false };
    let has = |entry: &str| texture.entries.contains_key(entry);
    !has(WAVELET_ENTRY) && (has("brdfc.flat-btf") || has("brdfc.indirection") || name_and_part(path).is_some())
}
