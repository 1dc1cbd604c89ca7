//! A pack in memory, and its file: one KTX2 file whose further textures are KTX2 files in entries.

use super::header::{MAX_TEXTURES, PWT_ENTRY, PwtErrors, PwtHeader, TextureHeader};
use crate::FormatError;
use crate::container::entries::value_of;
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
        pack.check_bytes()?;
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
        Self::from_packed(PackedTexture::from_bytes(bytes)?)
    }

    /// [`Self::from_bytes`] of a file whose texels have not been unpacked. Nothing is, before all textures have been held
    /// against the header.
    ///
    /// # Errors
    /// As [`Self::from_bytes`].
    pub fn from_packed(mut packed: PackedTexture<'_>) -> Result<Self, FormatError> {
        let header = PwtHeader::from_bytes(value_of(&packed.entries, PWT_ENTRY, "a polynomial wavelet tree")?)?;
        let expected = Self { texels: Vec::new(), header };
        let count = expected.header.textures.len();
        expected.check_bytes()?;
        if let Some(index) = (count..=MAX_TEXTURES).find(|k| packed.entries.contains_key(&texture_entry(*k))) {
            let allowed = format!("none of this name: {PWT_ENTRY} says {count} textures");
            return Err(FormatError::whole(texture_entry(index), "an entry", allowed));
        }
        let mut files = Vec::new();
        for index in 1..count {
            let key = texture_entry(index);
            let allowed = || format!("a KTX2 file, as {PWT_ENTRY} says");
            let file = packed.entries.remove(&key).ok_or_else(|| FormatError::whole(key, "no entry", allowed()))?;
            files.push(file);
        }
        let mut textures = vec![packed];
        for (k, file) in files.iter().enumerate() {
            textures.push(PackedTexture::from_bytes(file).map_err(inside(k + 1))?);
        }
        for (index, texture) in textures.iter().enumerate() {
            expected.check_texture(index, texture).map_err(inside(index))?;
        }
        let unpacked = |(index, texture): (usize, PackedTexture<'_>)| {
            Ok(texture.unpack_levels(MAX_TEXEL_BYTES).map_err(inside(index))?.texels)
        };
        let texels = textures.into_iter().enumerate().map(unpacked).collect::<Result<_, _>>()?;
        Self::new(expected.header, texels)
    }

    /// Refuses more texels than any texture of the container has.
    fn check_bytes(&self) -> Result<(), FormatError> {
        let bytes: u64 = (0..self.header.textures.len()).map(|texture| self.texture_bytes(texture)).sum();
        if bytes <= MAX_TEXEL_BYTES {
            return Ok(());
        }
        let field = format!("{PWT_ENTRY} textures");
        Err(FormatError::whole(field, format!("{bytes} bytes of texels"), format!("at most {MAX_TEXEL_BYTES}")))
    }

    fn check_texture(&self, index: usize, texture: &PackedTexture<'_>) -> Result<(), FormatError> {
        if let Some(key) = texture.entries.keys().next().filter(|_| index > 0) {
            return Err(FormatError::whole("entries", key.clone(), "none that begins with brdfc."));
        }
        let found = (texture.format, texture.extent, texture.levels);
        let wanted = (self.header.textures[index].texel_format(), self.texture_shape(index), self.levels_of(index));
        if found == wanted {
            return Ok(());
        }
        let told = |(format, extent, levels): (TexelFormat, Extent, u32)| {
            format!("{levels} levels of {extent} texels of {format:?}")
        };
        Err(FormatError::whole("texture", told(found), format!("{}, as {PWT_ENTRY} says", told(wanted))))
    }
}

/// Says which texture an error is of, unless it is the file's own.
fn inside(texture: usize) -> impl Fn(FormatError) -> FormatError {
    move |error| match texture {
        0 => error,
        _ => FormatError { field: format!("{}, {}", texture_entry(texture), error.field).into(), ..error },
    }
}
