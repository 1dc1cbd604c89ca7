//! Which pack a KTX2 file is: decided here alone, once, before any texel is unpacked.

use crate::FormatError;
use crate::bandwidth::BandwidthMap;
use crate::bindings::{Bindings, PackFile};
use crate::container::PackedTexture;
use crate::flat_btf::FlatBtfFile;
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
    /// A flat BTF.
    FlatBtf,
    /// A bandwidth map.
    Bandwidth,
    /// Importance samples.
    Importance,
    /// A polynomial wavelet tree.
    Pwt,
}

impl PackKind {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Table, Self::Wavelet, Self::FlatBtf, Self::Pwt, Self::Bandwidth, Self::Importance];

    /// The kind of a texture, by its decoder; nothing where it is no pack, or one of another program.
    pub fn of(texture: &PackedTexture<'_>) -> Option<Self> {
        Self::of_decoder(PackFile::decoder_of(texture)?)
    }

    /// The kind that a decoder of this name is for.
    pub fn of_decoder(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.decoder() == name)
    }

    /// The name of its decoder: in files, and on the command line.
    pub fn decoder(self) -> &'static str {
        match self {
            Self::Wavelet => "wavelet",
            Self::Table => "table",
            Self::FlatBtf => "flat-btf",
            Self::Bandwidth => "bandwidth",
            Self::Importance => "importance",
            Self::Pwt => "pwt",
        }
    }

    /// What it is called in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wavelet => "a wavelet pack",
            Self::Table => "a table pack",
            Self::FlatBtf => "a flat BTF",
            Self::Bandwidth => "a bandwidth map",
            Self::Importance => "an importance-sample pack",
            Self::Pwt => "a polynomial wavelet tree",
        }
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
    /// A flat BTF.
    FlatBtf(Box<FlatBtfFile>),
    /// A bandwidth map.
    Bandwidth(BandwidthMap),
    /// Importance samples.
    Importance(ImportancePack),
    /// A polynomial wavelet tree.
    Pwt(PwtPack),
}

impl Pack {
    /// Reads and checks a KTX2 file.
    ///
    /// # Errors
    /// What is no KTX2 file, no pack of a known kind, or breaks the rules of its kind.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_packed(PackedTexture::from_bytes(bytes)?)
    }

    /// [`Self::from_bytes`] of a file whose container has been read.
    ///
    /// # Errors
    /// As [`Self::from_bytes`].
    pub fn from_packed(packed: PackedTexture<'_>) -> Result<Self, FormatError> {
        let file = PackFile::from_packed(packed)?;
        let Some(kind) = PackKind::of_decoder(&file.bindings.decoder) else {
            let known: Vec<&str> = PackKind::ALL.into_iter().map(PackKind::decoder).collect();
            return Err(FormatError::whole("decoder of the pack", file.bindings.decoder, known.join(", ")));
        };
        Ok(match kind {
            PackKind::Wavelet => Self::Wavelet(WaveletPack::from_file(file)?),
            PackKind::Table => Self::Table(TablePack::from_file(file)?),
            PackKind::FlatBtf => Self::FlatBtf(Box::new(FlatBtfFile::from_file(file)?)),
            PackKind::Bandwidth => Self::Bandwidth(BandwidthMap::from_file(file)?),
            PackKind::Importance => Self::Importance(ImportancePack::from_file(file)?),
            PackKind::Pwt => Self::Pwt(PwtPack::from_file(file)?),
        })
    }

    /// What it is.
    pub fn kind(&self) -> PackKind {
        match self {
            Self::Wavelet(_) => PackKind::Wavelet,
            Self::Table(_) => PackKind::Table,
            Self::FlatBtf(_) => PackKind::FlatBtf,
            Self::Bandwidth(_) => PackKind::Bandwidth,
            Self::Importance(_) => PackKind::Importance,
            Self::Pwt(_) => PackKind::Pwt,
        }
    }

    /// What its shader has bound.
    pub fn bindings(&self) -> Bindings<'_> {
        match self {
            Self::Wavelet(pack) => pack.bindings(),
            Self::Table(pack) => pack.bindings(),
            Self::FlatBtf(file) => file.bindings(),
            Self::Bandwidth(map) => map.bindings(),
            Self::Importance(pack) => pack.bindings(),
            Self::Pwt(pack) => pack.bindings(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{Texture, seal};
    use crate::importance::ImportanceHeader;

    fn example() -> ImportancePack {
        let header = ImportanceHeader { polar: 2, azimuths: 1, samples: 2 };
        ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 4]).unwrap()
    }

    #[test]
    fn the_decoder_decides_and_broken_packs_are_errors() {
        let pack = example();
        let bytes = pack.to_bytes(false);
        assert_eq!(Pack::from_bytes(&bytes).unwrap(), Pack::Importance(pack));
        assert!(Pack::from_bytes(b"no pack").is_err());
        let at = bytes.len() - 4;
        let mut broken = [&bytes[..at], &(-1.0f32).to_le_bytes()].concat();
        assert_eq!(Pack::from_bytes(&broken).unwrap_err().field, "checksum of the file");
        seal(&mut broken);
        assert_eq!(Pack::from_bytes(&broken).unwrap_err().field, "importance texel (1, 1)");
        let mut other = bytes.clone();
        let name = other.windows(18).position(|bytes| bytes == b"decoder importance").unwrap();
        other[name + 17] = b'x';
        seal(&mut other);
        let error = Pack::from_bytes(&other).unwrap_err().to_string();
        assert!(error.starts_with("decoder of the pack: found importancx; allowed table, wavelet,"), "{error}");
    }

    #[test]
    fn packs_without_mipmaps_refuse_them() {
        let mut texture = Texture::from_bytes(&example().to_bytes(false)).unwrap();
        texture.levels = 2;
        texture.texels.extend_from_within(..16);
        assert_eq!(ImportancePack::from_texture(&texture).unwrap_err().field, "levelCount");
        let mut bytes = texture.to_bytes(false);
        seal(&mut bytes);
        let error = Pack::from_bytes(&bytes).unwrap_err().to_string();
        let expected = "texture: found 2 levels of 2 x 2 texels";
        assert!(error.starts_with(expected) && error.contains("allowed 1 levels"), "{error}");
    }
}
