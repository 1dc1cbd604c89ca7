//! What one part of a flat BTF is, without the others.

use brdfc_formats::container::{Extent, PackedTexture};
use brdfc_formats::flat_btf::{gpu_bytes, split_part_name};
use brdfc_formats::{FormatError, Pack, PackKind};

/// What one file of a flat BTF holds.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct PartFacts {
    /// Name of the asset.
    pub asset: String,
    /// Which part; see `formats/src/flat_btf/spec.md`.
    pub part: String,
    /// How a texel is stored.
    pub format: String,
    /// Texels per row, rows, and layers of an array.
    pub extent: Vec<u32>,
    /// Bytes of the file.
    pub bytes: u64,
    /// Bytes of texels on a GPU, as `formats/src/flat_btf/spec.md` counts them: with the unused tiles of a view's layer, and 0
    /// of a part that no shader reads.
    pub gpu_bytes: u64,
    /// Of a view: its number, how many views there are, and how many lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_views_lights: Option<[usize; 3]>,
    /// Of an indirection map, or displacements: polar angles and azimuths of its views.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polar_angles_azimuths: Option<[u32; 2]>,
}

impl PartFacts {
    /// Reads a file of this name; nothing where it is a pack of another kind, or its name is not `NAME.PART.ktx2`.
    ///
    /// # Errors
    /// What is no KTX2 file or does not follow the part's layout.
    pub fn from_bytes(bytes: &[u8], file_name: &str) -> Result<Option<Self>, FormatError> {
        let Some((asset, _, part)) = split_part_name(file_name) else { return Ok(None) };
        let packed = PackedTexture::from_bytes(bytes)?;
        let Some(kind @ PackKind::FlatBtf(_)) = PackKind::of(&packed, Some(file_name)) else { return Ok(None) };
        let mut facts = Self {
            asset: asset.to_owned(),
            part: part.to_owned(),
            format: format!("{:?}", packed.format),
            extent: match packed.extent {
                Extent::D2(sides) => sides.to_vec(),
                Extent::D2Array(sides) | Extent::D3(sides) => sides.to_vec(),
            },
            bytes: bytes.len() as u64,
            gpu_bytes: gpu_bytes(part, packed.extent, packed.levels),
            view_views_lights: None,
            polar_angles_azimuths: None,
        };
        match Pack::of_kind(kind, packed)? {
            Pack::Indirection(map) => {
                facts.polar_angles_azimuths = Some([map.header().zenith_samples, map.header().azimuth_samples]);
            }
            Pack::Displacement(map) => {
                let blocks = map.header().blocks;
                facts.gpu_bytes = map.gpu_bytes();
                facts.polar_angles_azimuths = Some([blocks.zenith_samples, blocks.azimuth_samples]);
            }
            Pack::View(view) => {
                let header = view.header();
                facts.view_views_lights = Some([header.view as usize, header.views.len(), header.lights.len()]);
            }
            _ => {}
        }
        Ok(Some(facts))
    }
}
