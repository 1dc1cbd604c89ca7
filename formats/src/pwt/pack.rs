//! A pack in memory, and its file: one KTX2 file whose further textures are KTX2 files in entries.

use super::header::{PWT_ENTRY, PwtErrors, PwtHeader, TextureHeader};
use crate::FormatError;
use crate::container::entries::entry;
use crate::container::{Extent, MAX_TEXEL_BYTES, PackedTexture, TexelFormat, Texture};
use std::collections::BTreeMap;

/// A light-dependent picture: every term of the light as mipmapped texels, from the level on that it needs.
#[derive(Debug, Clone, PartialEq)]
pub struct PwtPack {
    header: PwtHeader,
    /// Of each texture all mipmap levels from its finest, layer by layer, row by row from the top.
    texels: Vec<Vec<u8>>,
}

/// The entry of a texture behind the first.
fn texture_entry(texture: usize) -> String {
    format!("{PWT_ENTRY}.texture{texture}")
}

impl TextureHeader {
    /// How its texels are stored.
    pub fn texel_format(&self) -> TexelFormat {
        match self.channels {
            1 => TexelFormat::R8Unorm,
            2 => TexelFormat::Rg8Unorm,
            _ => TexelFormat::Rgba8Unorm,
        }
    }
}

impl PwtPack {
    /// A pack of these texels: of each texture all mipmap levels, from its finest to the coarsest.
    ///
    /// # Errors
    /// A header out of range; another number of texels.
    pub fn new(header: PwtHeader, texels: Vec<Vec<u8>>) -> Result<Self, FormatError> {
        header.check()?;
        if texels.len() != header.textures.len() {
            let allowed = format!("{}, as the header says", header.textures.len());
            return Err(FormatError::whole("textures", texels.len().to_string(), allowed));
        }
        let pack = Self { header, texels };
        for texture in 0..pack.texels.len() {
            let (found, wanted) = (pack.texels[texture].len() as u64, pack.texture_bytes(texture));
            if found != wanted {
                let field = format!("bytes of texture {texture}");
                return Err(FormatError::whole(field, found.to_string(), format!("{wanted}, as the header says")));
            }
        }
        Ok(pack)
    }

    /// The same with other errors.
    #[must_use]
    pub fn with_errors(mut self, errors: PwtErrors) -> Self {
        self.header.errors = errors;
        self
    }

    /// What it says of itself.
    pub fn header(&self) -> &PwtHeader {
        &self.header
    }

    /// Texels of a texture, all mipmap levels from its finest, layer by layer.
    pub fn texels(&self, texture: usize) -> &[u8] {
        &self.texels[texture]
    }

    /// Where a mipmap level of a texture, counted from its own finest, begins in [`Self::texels`], and its sides.
    pub fn level_of(&self, texture: usize, level: u32) -> (usize, [u32; 2]) {
        let extent = self.texture_shape(texture);
        let before = extent.texels_of_levels(level) as usize * self.header.textures[texture].channels as usize;
        (before, self.header.texture_extent(texture).map(|side| side >> level))
    }

    /// Mipmap levels of a texture.
    pub fn levels_of(&self, texture: usize) -> u32 {
        self.header.levels - self.header.textures[texture].level + 1
    }

    /// Bytes on a GPU, all levels included.
    pub fn gpu_bytes(&self) -> u64 {
        (0..self.texels.len()).map(|texture| self.texture_bytes(texture)).sum()
    }

    /// Sides and layers of a texture.
    pub fn texture_shape(&self, texture: usize) -> Extent {
        let [width, height] = self.header.texture_extent(texture);
        Extent::D2Array([width, height, self.header.textures[texture].layers()])
    }

    fn texture_bytes(&self, texture: usize) -> u64 {
        let texels = self.texture_shape(texture).texels_of_levels(self.levels_of(texture));
        texels * u64::from(self.header.textures[texture].channels)
    }

    /// The bytes of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let texture = |index: usize, entries| Texture {
            format: self.header.textures[index].texel_format(),
            extent: self.texture_shape(index),
            entries,
            levels: self.levels_of(index),
            texels: self.texels[index].clone(),
        };
        let others = (1..self.texels.len())
            .map(|index| (texture_entry(index), texture(index, BTreeMap::new()).to_bytes(supercompress)));
        let entries = others.chain([(PWT_ENTRY.to_owned(), self.header.to_bytes())]).collect();
        texture(0, entries).to_bytes(supercompress)
    }

    /// Reads and checks a KTX2 file.
    ///
    /// # Errors
    /// Whatever breaks the rules of `formats/src/pwt/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_texture(PackedTexture::from_bytes(bytes)?.unpack_levels(MAX_TEXEL_BYTES)?)
    }

    /// [`Self::from_bytes`] of a file whose container has been read.
    ///
    /// # Errors
    /// As [`Self::from_bytes`].
    pub fn from_texture(mut texture: Texture) -> Result<Self, FormatError> {
        const KIND: &str = "a polynomial wavelet tree";
        let header = PwtHeader::from_bytes(entry(&texture, PWT_ENTRY, KIND)?)?;
        let expected = Self { texels: vec![Vec::new(); header.textures.len()], header };
        let mut texels = Vec::new();
        for index in 0..expected.texels.len() {
            if index > 0 {
                let key = texture_entry(index);
                let Some(bytes) = texture.entries.remove(&key) else {
                    return Err(FormatError::whole(key, "no entry", format!("a KTX2 file, as {PWT_ENTRY} says")));
                };
                let inside =
                    |error: FormatError| FormatError { field: format!("{key}, {}", error.field).into(), ..error };
                let packed = PackedTexture::from_bytes(&bytes).map_err(inside)?;
                expected.check_texture(index, packed.format, packed.extent, packed.levels).map_err(inside)?;
                texels.push(packed.unpack_levels(MAX_TEXEL_BYTES).map_err(inside)?.texels);
            } else {
                expected.check_texture(0, texture.format, texture.extent, texture.levels)?;
                texels.push(std::mem::take(&mut texture.texels));
            }
        }
        Self::new(expected.header, texels)
    }

    fn check_texture(&self, index: usize, format: TexelFormat, extent: Extent, levels: u32) -> Result<(), FormatError> {
        let wanted = (self.header.textures[index].texel_format(), self.texture_shape(index), self.levels_of(index));
        if (format, extent, levels) == wanted {
            return Ok(());
        }
        let told = |(format, extent, levels): (TexelFormat, Extent, u32)| {
            format!("{levels} levels of {extent} texels of {format:?}")
        };
        let allowed = format!("{}, as {PWT_ENTRY} says", told(wanted));
        Err(FormatError::whole("texture", told((format, extent, levels)), allowed))
    }
}
