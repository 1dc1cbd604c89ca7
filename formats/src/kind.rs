//! Which pack a KTX2 file is: decided here alone, once, before any texel is unpacked. The list of codecs is in `lib.rs`.

use crate::bindings::PackFile;
use crate::container::PackedTexture;
use crate::{FormatError, Pack, PackKind};

/// Makes [`PackKind`], [`Pack`] and [`BrdfPack`] of one line for each codec. Of BRDFs: its name in Rust, its pack, its folder; of
/// others: the name, the type that [`Pack`] holds, the type that reads a pack, the folder.
macro_rules! codecs {
    (
        brdfs: { $($(#[$brdf_doc:meta])* $brdf:ident($brdf_pack:ident): $brdf_folder:ident;)* }
        others: { $($others:tt)* }
    ) => {
        codecs! {
            $($(#[$brdf_doc])* $brdf($brdf_pack): $brdf_pack, $brdf_folder;)*
            $($others)*
        }

        /// A pack of a BRDF, of any codec. It dereferences to what all of them have.
        #[derive(Debug, Clone, PartialEq)]
        #[allow(clippy::large_enum_variant)]
        pub enum BrdfPack {
            $($(#[$brdf_doc])* $brdf($brdf_pack),)*
        }

        impl std::ops::Deref for BrdfPack {
            type Target = dyn $crate::Brdf;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$brdf(pack) => pack,)*
                }
            }
        }

        impl TryFrom<Pack> for BrdfPack {
            type Error = PackKind;

            /// The pack if it is one of a BRDF, otherwise its kind.
            fn try_from(pack: Pack) -> Result<Self, PackKind> {
                match pack {
                    $(Pack::$brdf(pack) => Ok(Self::$brdf(pack)),)*
                    other => Err(other.kind()),
                }
            }
        }

        impl BrdfPack {
            /// The kind of the pack.
            pub fn kind(&self) -> PackKind {
                match self {
                    $(Self::$brdf(_) => PackKind::$brdf,)*
                }
            }
        }
    };
    ($($(#[$doc:meta])* $kind:ident($held:ty): $pack:ident, $folder:ident;)*) => {
        /// What a pack is.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum PackKind {
            $($(#[$doc])* $kind,)*
        }

        impl PackKind {
            /// All of them.
            pub const ALL: [Self; [$(Self::$kind),*].len()] = [$(Self::$kind),*];

            /// What is known of the codec apart from its packs.
            pub fn descriptor(self) -> &'static $crate::Descriptor {
                match self {
                    $(Self::$kind => &$crate::$folder::descriptor::DESCRIPTOR,)*
                }
            }
        }

        /// A pack of any kind, checked by the rules of its layout.
        #[derive(Debug, Clone, PartialEq)]
        #[allow(clippy::large_enum_variant)]
        pub enum Pack {
            $($(#[$doc])* $kind($held),)*
        }

        impl Pack {
            fn of_kind(kind: PackKind, file: $crate::bindings::PackFile) -> Result<Self, $crate::FormatError> {
                Ok(match kind {
                    $(PackKind::$kind => Self::$kind($pack::from_file(file)?.into()),)*
                })
            }

            /// What it is.
            pub fn kind(&self) -> PackKind {
                match self {
                    $(Self::$kind(_) => PackKind::$kind,)*
                }
            }

            /// What its shader has bound.
            pub fn bindings(&self) -> $crate::bindings::Bindings<'_> {
                match self {
                    $(Self::$kind(pack) => pack.bindings(),)*
                }
            }
        }
    };
}

impl PackKind {
    /// The kind of a texture, by its decoder; nothing where it is no pack, or one of another program.
    pub fn of(texture: &PackedTexture<'_>) -> Option<Self> {
        Self::from_name(PackFile::decoder_of(texture)?)
    }

    /// The kind that a decoder of this name is for.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The name of its decoder: in files, and on the command line.
    pub fn name(self) -> &'static str {
        self.descriptor().name
    }

    /// What a pack of it is called in messages.
    pub fn in_words(self) -> &'static str {
        self.descriptor().in_words
    }
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
        let Some(kind) = PackKind::from_name(&file.bindings.decoder) else {
            let known = PackKind::ALL.map(PackKind::name).join(", ");
            return Err(FormatError::whole("decoder of the pack", file.bindings.decoder, known));
        };
        let (found, allowed) = (file.bindings.version, kind.descriptor().version);
        if found != allowed {
            let field = format!("version of the decoder {}", kind.name());
            return Err(FormatError::whole(field, found.to_string(), allowed.to_string()));
        }
        Self::of_kind(kind, file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{Texture, seal};
    use crate::importance::{ImportanceHeader, ImportancePack};

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
        assert!(error.starts_with("decoder of the pack: found importancx, expected table, wavelet,"), "{error}");
        let mut newer = bytes.clone();
        newer[name + 19] = b'2';
        seal(&mut newer);
        let error = Pack::from_bytes(&newer).unwrap_err().to_string();
        assert_eq!(error, "version of the decoder importance: found 2, expected 1");
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
        assert!(error.starts_with(expected) && error.contains("expected 1 levels"), "{error}");
    }
}
