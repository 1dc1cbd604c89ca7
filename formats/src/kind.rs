//! Kind of the pack in a KTX2 file. It is determined here only, once, before any texel is decompressed. `lib.rs` lists
//! the codecs.

use crate::bindings::PackFile;
use crate::container::PackedTexture;
use crate::words::one_of;
use crate::{FormatError, Pack, PackKind};

/// Generates [`PackKind`], [`Pack`] and [`BrdfPack`] from one line per codec. Lines of BRDFs have the variant, the pack
/// type and the module; other lines have the variant, the type that [`Pack`] holds, the type that reads a pack and the
/// module.
macro_rules! codecs {
    (
        brdfs: { $($(#[$brdf_doc:meta])* $brdf:ident($brdf_pack:ident): $brdf_folder:ident;)* }
        others: { $($others:tt)* }
    ) => {
        codecs! {
            $($(#[$brdf_doc])* $brdf($brdf_pack): $brdf_pack, $brdf_folder;)*
            $($others)*
        }

        /// A pack of a BRDF, of any codec. It dereferences to the trait that all of them implement,
        /// [`Brdf`](crate::Brdf).
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

            /// Returns the pack if it is a BRDF, otherwise its kind.
            fn try_from(pack: Pack) -> Result<Self, PackKind> {
                match pack {
                    $(Pack::$brdf(pack) => Ok(Self::$brdf(pack)),)*
                    other => Err(other.kind()),
                }
            }
        }

        impl BrdfPack {
            /// Kind of the pack.
            pub fn kind(&self) -> PackKind {
                match self {
                    $(Self::$brdf(_) => PackKind::$brdf,)*
                }
            }
        }
    };
    ($($(#[$doc:meta])* $kind:ident($held:ty): $pack:ident, $folder:ident;)*) => {
        /// Kind of a pack, one per codec.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum PackKind {
            $($(#[$doc])* $kind,)*
        }

        impl PackKind {
            /// All kinds of packs.
            pub const ALL: [Self; [$(Self::$kind),*].len()] = [$(Self::$kind),*];

            /// Static description of the codec.
            pub fn descriptor(self) -> &'static $crate::Descriptor {
                match self {
                    $(Self::$kind => &$crate::$folder::descriptor::DESCRIPTOR,)*
                }
            }
        }

        /// A pack of any kind, validated against the rules of its layout.
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

            /// Kind of the pack.
            pub fn kind(&self) -> PackKind {
                match self {
                    $(Self::$kind(_) => PackKind::$kind,)*
                }
            }

            /// Bindings of its shader.
            pub fn bindings(&self) -> $crate::bindings::Bindings<'_> {
                match self {
                    $(Self::$kind(pack) => pack.bindings(),)*
                }
            }
        }
    };
}

impl PackKind {
    /// Kind of a texture, from the decoder that it names. `None` if it is not a pack or names an unknown decoder.
    pub fn of(texture: &PackedTexture<'_>) -> Option<Self> {
        Self::from_name(PackFile::decoder_of(texture)?)
    }

    /// Kind whose decoder has this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Name of the decoder, in files and on the command line.
    pub fn name(self) -> &'static str {
        self.descriptor().name
    }

    /// Name of such a pack in messages, with article.
    pub fn summary(self) -> &'static str {
        self.descriptor().summary
    }
}

impl Pack {
    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the bytes are not a KTX2 file, not a pack of a known kind, or violate the rules of that
    /// kind.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_packed(PackedTexture::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose container has been read.
    ///
    /// # Errors
    /// Returns an error if the file is not a pack of a known kind, or violates the rules of that kind.
    pub fn from_packed(packed: PackedTexture<'_>) -> Result<Self, FormatError> {
        let file = PackFile::from_packed(packed)?;
        let Some(kind) = PackKind::from_name(&file.bindings.decoder) else {
            let known = one_of(&PackKind::ALL.map(PackKind::name));
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
    fn packs_without_mipmaps_reject_them() {
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
