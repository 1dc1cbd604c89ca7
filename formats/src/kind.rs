//! Which pack a KTX2 file is: decided here alone, once, before any texel is unpacked.

use crate::FormatError;
use crate::bandwidth::BandwidthMap;
use crate::bindings::PackFile;
use crate::container::{MAX_TEXEL_BYTES, PackedTexture};
use crate::flat_btf::factored::{BasisMap, FACTORED_ENTRY, SHADOW_ENTRY, ShadowMap, WEIGHTS_ENTRY, WeightMap};
use crate::flat_btf::{
    DISPLACEMENT_ENTRY, DiffuseMap, DisplacementMap, FLAT_BTF_ENTRY, FlatPart, FlatView, INDIRECTION_ENTRY,
    IndirectionMap, NormalMap, PositionMap, ReferenceMap, SampledDirections, VisibilityMask, split_part_name,
};
use crate::importance::ImportancePack;
use crate::pwt::PwtPack;
use crate::table::TablePack;
use crate::wavelet::WaveletPack;

/// What a pack is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PackKind {
    /// A wavelet BRDF pack.
    Wavelet,
    /// A table pack.
    Table,
    /// A part of a flat BTF.
    FlatBtf(FlatPart),
    /// A bandwidth map.
    Bandwidth,
    /// Importance samples.
    Importance,
    /// A polynomial wavelet tree.
    Pwt,
}

impl PackKind {
    /// The kind of a texture: its `brdfc.*` entries decide. Parts of flat BTFs that have none are told by the name of
    /// their file, `NAME.PART.ktx2`. Nothing where neither is known.
    pub fn of(texture: &PackedTexture<'_>, file_name: Option<&str>) -> Option<Self> {
        if let Some(decoder) = PackFile::decoder_of(texture) {
            return match decoder {
                "wavelet" => Some(Self::Wavelet),
                "table" => Some(Self::Table),
                "bandwidth" => Some(Self::Bandwidth),
                "importance" => Some(Self::Importance),
                "pwt" => Some(Self::Pwt),
                _ => None,
            };
        }
        [
            (FLAT_BTF_ENTRY, Self::FlatBtf(FlatPart::View)),
            (INDIRECTION_ENTRY, Self::FlatBtf(FlatPart::Indirection)),
            (DISPLACEMENT_ENTRY, Self::FlatBtf(FlatPart::Displacement)),
            (FACTORED_ENTRY, Self::FlatBtf(FlatPart::Basis)),
            (WEIGHTS_ENTRY, Self::FlatBtf(FlatPart::Weights)),
            (SHADOW_ENTRY, Self::FlatBtf(FlatPart::Shadow)),
        ]
        .into_iter()
        .find(|(entry, _)| texture.entries.contains_key(*entry))
        .map(|(_, kind)| kind)
        .or_else(|| file_name.and_then(split_part_name).map(|(_, part, _)| Self::FlatBtf(part)))
    }

    /// What it is called in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wavelet => "a wavelet pack",
            Self::Table => "a table pack",
            Self::FlatBtf(_) => "a part of a flat BTF",
            Self::Bandwidth => "a bandwidth map",
            Self::Importance => "an importance-sample pack",
            Self::Pwt => "a polynomial wavelet tree",
        }
    }

    /// Whether its textures may have several levels.
    fn has_mipmaps(self) -> bool {
        matches!(self, Self::Pwt | Self::FlatBtf(FlatPart::Weights | FlatPart::Shadow))
    }
}

/// A pack of any kind, checked by the rules of its layout.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)]
pub enum Pack {
    /// A wavelet BRDF pack.
    Wavelet(WaveletPack),
    /// A table pack.
    Table(TablePack),
    /// A bandwidth map.
    Bandwidth(BandwidthMap),
    /// Importance samples.
    Importance(ImportancePack),
    /// A polynomial wavelet tree.
    Pwt(PwtPack),
    /// The part `position` of a flat BTF.
    Position(PositionMap),
    /// The part `normal`.
    Normal(NormalMap),
    /// The part `reference`.
    Reference(ReferenceMap),
    /// The part `diffuse`.
    Diffuse(DiffuseMap),
    /// The part `mask`.
    Mask(VisibilityMask),
    /// The part `indirection`.
    Indirection(IndirectionMap),
    /// The part `displacement`.
    Displacement(DisplacementMap),
    /// The part `directions`.
    Directions(SampledDirections),
    /// A view.
    View(FlatView),
    /// The part `basis` of a factored flat BTF.
    Basis(BasisMap),
    /// The part `weights`.
    Weights(WeightMap),
    /// The part `shadow`.
    Shadow(ShadowMap),
}

impl Pack {
    /// Reads and checks a KTX2 file. The name of the file tells parts of flat BTFs that have no entry.
    ///
    /// # Errors
    /// What is no KTX2 file, no pack of a known kind, or breaks the rules of its kind.
    pub fn from_bytes(bytes: &[u8], file_name: Option<&str>) -> Result<Self, FormatError> {
        let packed = PackedTexture::from_bytes(bytes)?;
        let Some(kind) = PackKind::of(&packed, file_name) else {
            let entries: Vec<&str> = packed.entries.keys().map(String::as_str).collect();
            let found = if entries.is_empty() { "none".to_owned() } else { format!("only {}", entries.join(", ")) };
            let allowed = "those of a table or wavelet pack, a flat BTF, a polynomial wavelet tree, a bandwidth map or importance samples";
            return Err(FormatError::whole("brdfc entries", found, allowed));
        };
        Self::of_kind(kind, packed)
    }

    /// Unpacks and checks a texture of a known kind.
    ///
    /// # Errors
    /// What breaks the rules of the kind.
    pub fn of_kind(kind: PackKind, packed: PackedTexture<'_>) -> Result<Self, FormatError> {
        Ok(match kind {
            PackKind::Wavelet => Self::Wavelet(WaveletPack::from_file(PackFile::from_packed(packed)?)?),
            PackKind::Table => Self::Table(TablePack::from_file(PackFile::from_packed(packed)?)?),
            PackKind::Bandwidth => Self::Bandwidth(BandwidthMap::from_file(PackFile::from_packed(packed)?)?),
            PackKind::Importance => Self::Importance(ImportancePack::from_file(PackFile::from_packed(packed)?)?),
            PackKind::Pwt => Self::Pwt(PwtPack::from_file(PackFile::from_packed(packed)?)?),
            PackKind::FlatBtf(part) => {
                let limit = MAX_TEXEL_BYTES;
                let texture = if kind.has_mipmaps() { packed.unpack_levels(limit)? } else { packed.unpack(limit)? };
                match part {
                    FlatPart::Position => Self::Position(PositionMap::from_texture(&texture)?),
                    FlatPart::Normal => Self::Normal(NormalMap::from_texture(&texture)?),
                    FlatPart::Reference => Self::Reference(ReferenceMap::from_texture(&texture)?),
                    FlatPart::Diffuse => Self::Diffuse(DiffuseMap::from_texture(&texture)?),
                    FlatPart::Mask => Self::Mask(VisibilityMask::from_texture(&texture)?),
                    FlatPart::Indirection => Self::Indirection(IndirectionMap::from_texture(&texture)?),
                    FlatPart::Displacement => Self::Displacement(DisplacementMap::from_texture(&texture)?),
                    FlatPart::Directions => Self::Directions(SampledDirections::from_texture(&texture)?),
                    FlatPart::View => Self::View(FlatView::from_texture(&texture)?),
                    FlatPart::Basis => Self::Basis(BasisMap::from_texture(&texture)?),
                    FlatPart::Weights => Self::Weights(WeightMap::from_texture(texture)?),
                    FlatPart::Shadow => Self::Shadow(ShadowMap::from_texture(texture)?),
                }
            }
        })
    }

    /// What it is.
    pub fn kind(&self) -> PackKind {
        match self {
            Self::Wavelet(_) => PackKind::Wavelet,
            Self::Table(_) => PackKind::Table,
            Self::Bandwidth(_) => PackKind::Bandwidth,
            Self::Importance(_) => PackKind::Importance,
            Self::Pwt(_) => PackKind::Pwt,
            Self::Position(_) => PackKind::FlatBtf(FlatPart::Position),
            Self::Normal(_) => PackKind::FlatBtf(FlatPart::Normal),
            Self::Reference(_) => PackKind::FlatBtf(FlatPart::Reference),
            Self::Diffuse(_) => PackKind::FlatBtf(FlatPart::Diffuse),
            Self::Mask(_) => PackKind::FlatBtf(FlatPart::Mask),
            Self::Indirection(_) => PackKind::FlatBtf(FlatPart::Indirection),
            Self::Displacement(_) => PackKind::FlatBtf(FlatPart::Displacement),
            Self::Directions(_) => PackKind::FlatBtf(FlatPart::Directions),
            Self::View(_) => PackKind::FlatBtf(FlatPart::View),
            Self::Basis(_) => PackKind::FlatBtf(FlatPart::Basis),
            Self::Weights(_) => PackKind::FlatBtf(FlatPart::Weights),
            Self::Shadow(_) => PackKind::FlatBtf(FlatPart::Shadow),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{Texture, seal};
    use crate::importance::ImportanceHeader;

    #[test]
    fn the_entry_decides_and_broken_packs_are_errors() {
        let header = ImportanceHeader { polar: 2, azimuths: 1, samples: 2 };
        let pack = ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 4]).unwrap();
        let bytes = pack.to_bytes(false);
        // Whatever its name says.
        for name in [None, Some("a.samples.ktx2"), Some("a.diffuse.ktx2")] {
            assert_eq!(Pack::from_bytes(&bytes, name).unwrap(), Pack::Importance(pack.clone()));
        }
        assert!(Pack::from_bytes(b"no pack", None).is_err());
        let at = bytes.len() - 4;
        let mut broken = [&bytes[..at], &(-1.0f32).to_le_bytes()].concat();
        assert_eq!(Pack::from_bytes(&broken, None).unwrap_err().field, "checksum of the file");
        seal(&mut broken);
        assert_eq!(Pack::from_bytes(&broken, None).unwrap_err().field, "importance texel (1, 1)");
        // Of another kind by its decoder, whatever its texels are.
        let mut other = bytes.clone();
        let name = other.windows(18).position(|bytes| bytes == b"decoder importance").unwrap();
        other[name + 17] = b'x';
        seal(&mut other);
        let error = Pack::from_bytes(&other, None).unwrap_err().to_string();
        assert!(error.starts_with("brdfc entries: found only brdfc.bindings, brdfc.checksum"), "{error}");
    }

    #[test]
    fn packs_without_mipmaps_refuse_them() {
        let map = ReferenceMap::new(2, vec![[0.25, 0.5]; 4]).unwrap();
        let mut texture = Texture::from_bytes(&map.to_bytes(false)).unwrap();
        assert_eq!(ReferenceMap::from_texture(&texture).unwrap(), map);
        texture.levels = 2;
        texture.texels.extend_from_within(..8);
        for supercompress in [false, true] {
            let bytes = texture.to_bytes(supercompress);
            let packed = PackedTexture::from_bytes(&bytes).unwrap();
            let unpacked = packed.unpack_levels(MAX_TEXEL_BYTES).unwrap();
            let refused = [
                Pack::from_bytes(&bytes, Some("knit.reference.ktx2")).map(|_| ()),
                ReferenceMap::from_texture(&unpacked).map(|_| ()),
            ];
            for result in refused {
                assert_eq!(result.unwrap_err().to_string(), "byte 40, levelCount: found 2; allowed 1");
            }
        }
        // Packs that an entry tells likewise.
        let header = ImportanceHeader { polar: 2, azimuths: 1, samples: 2 };
        let pack = ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 4]).unwrap();
        let mut texture = Texture::from_bytes(&pack.to_bytes(false)).unwrap();
        texture.levels = 2;
        texture.texels.extend_from_within(..16);
        assert_eq!(ImportancePack::from_texture(&texture).unwrap_err().field, "levelCount");
        let mut bytes = texture.to_bytes(false);
        seal(&mut bytes);
        let error = Pack::from_bytes(&bytes, None).unwrap_err().to_string();
        assert!(
            error.starts_with("texture: found 2 levels of 2 x 2 texels") && error.contains("allowed 1 levels"),
            "{error}"
        );
    }

    #[test]
    fn parts_without_entries_go_by_their_name() {
        let map = ReferenceMap::new(1, vec![[0.25, 0.5]]).unwrap();
        let bytes = map.to_bytes(true);
        assert_eq!(Pack::from_bytes(&bytes, Some("knit.reference.ktx2")).unwrap(), Pack::Reference(map));
        let error = Pack::from_bytes(&bytes, Some("knit.position.ktx2")).unwrap_err().to_string();
        assert!(error.contains("position"), "{error}");
        let error = Pack::from_bytes(&bytes, Some("knit.ktx2")).unwrap_err().to_string();
        assert!(error.starts_with("brdfc entries: found none; allowed"), "{error}");
    }
}
