//! Pack in memory, and its file.

use super::header::{MAX_TEXTURES, PWT_ENTRY, PwtErrors, PwtHeader, TextureHeader};
use super::light_map::LightMap;
use crate::FormatError;
use crate::bindings::PackFile;
use crate::container::entries::{check_texels, entry};
use crate::container::{Extent, MAX_TEXEL_BYTES, TexelFormat, Texture};
use crate::direction_mesh::DirectionMesh;
use std::collections::BTreeMap;

/// An image under variable light: all terms of the light as mipmapped texels, each from the finest level that it needs.
#[derive(Debug, Clone, PartialEq)]
pub struct PwtPack {
    header: PwtHeader,
    /// All mipmap levels of each texture from its finest, layer by layer, view by view, row by row from the top.
    texels: Vec<Vec<u8>>,
}

/// Bindings of the textures. A pack uses the first ones.
pub(super) const TEXTURES: [&str; MAX_TEXTURES] = [
    "pwt_texture_0",
    "pwt_texture_1",
    "pwt_texture_2",
    "pwt_texture_3",
    "pwt_texture_4",
    "pwt_texture_5",
    "pwt_texture_6",
    "pwt_texture_7",
];

/// Binding of the learned terms.
pub(super) const LIGHT_MAP: &str = "pwt_light_map";
pub(super) const LIGHT_MAP_FORMAT: TexelFormat = TexelFormat::Rgba16Float;

/// Binding of the mesh of views.
pub(super) const VIEWS: &str = "direction_mesh_words";
/// Texels per row of that mesh.
const MESH_WIDTH: u32 = 256;

/// Size of the texture of a mesh.
pub(super) fn mesh_extent(mesh: &DirectionMesh) -> Extent {
    Extent::D2([MESH_WIDTH, mesh.words().len().div_ceil(MESH_WIDTH as usize) as u32])
}

/// Bytes on a GPU of a mesh of views.
pub fn mesh_bytes(mesh: &DirectionMesh) -> u64 {
    4 * mesh_extent(mesh).texels_of_levels(1)
}

/// Texels of the texture of a mesh: its words, padded with 0.
pub(super) fn mesh_texels(mesh: &DirectionMesh) -> Vec<u8> {
    let mut words = mesh.words().to_vec();
    words.resize(words.len().next_multiple_of(MESH_WIDTH as usize), 0);
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Reads and validates the texture of the mesh of `views` views.
fn mesh_of(texture: &Texture, views: u32) -> Result<DirectionMesh, FormatError> {
    let words = texture.texels.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    let mesh = DirectionMesh::from_words(&words.collect::<Vec<_>>())?;
    if mesh.directions() != views as usize {
        let allowed = format!("{views}, as {PWT_ENTRY} says");
        return Err(FormatError::whole(format!("{VIEWS}, directions"), mesh.directions().to_string(), allowed));
    }
    check_texels(texture, VIEWS, mesh_extent(&mesh), TexelFormat::R32Uint, "its counts")?;
    Ok(mesh)
}

/// Size of the texture of a light map.
pub(super) fn map_extent(side: u32, terms: usize) -> Extent {
    Extent::D2Array([side, side, terms as u32])
}

impl TextureHeader {
    /// Format of each texel, by the number of channels.
    pub fn texel_format(&self) -> TexelFormat {
        match self.channels {
            1 => TexelFormat::R8Unorm,
            2 => TexelFormat::Rg8Unorm,
            _ => TexelFormat::Rgba8Unorm,
        }
    }
}

impl PwtPack {
    /// Creates a pack from texels: for each texture all mipmap levels, from its finest to the coarsest.
    ///
    /// # Errors
    /// Returns an error if the header is out of range or the number of texels is wrong.
    pub fn new(header: PwtHeader, texels: Vec<Vec<u8>>) -> Result<Self, FormatError> {
        header.check()?;
        if texels.len() != header.textures.len() {
            let allowed = format!("{}, as the header says", header.textures.len());
            return Err(FormatError::whole("textures", texels.len().to_string(), allowed));
        }
        let pack = Self { header, texels };
        pack.check_bytes()?;
        for texture in 0..pack.texels.len() {
            let (found, expected) = (pack.texels[texture].len() as u64, pack.texture_bytes(texture));
            if found != expected {
                let field = format!("bytes of texture {texture}");
                return Err(FormatError::whole(field, found.to_string(), format!("{expected}, as the header says")));
            }
        }
        Ok(pack)
    }

    /// Replaces the measured errors in the header.
    #[must_use]
    pub fn with_errors(mut self, errors: PwtErrors) -> Self {
        self.header.errors = errors;
        self
    }

    /// Header of the pack.
    pub fn header(&self) -> &PwtHeader {
        &self.header
    }

    /// Texels of a texture: all mipmap levels from its finest, layer by layer.
    pub fn texels(&self, texture: usize) -> &[u8] {
        &self.texels[texture]
    }

    /// Offset in [`Self::texels`] and size of a mipmap level of a texture, counted from its own finest.
    pub fn level_of(&self, texture: usize, level: u32) -> (usize, [u32; 2]) {
        let extent = self.texture_shape(texture);
        let before = extent.texels_of_levels(level) as usize * self.header.textures[texture].channels as usize;
        (before, self.header.texture_extent(texture).map(|side| side >> level))
    }

    /// Number of mipmap levels of a texture.
    pub fn levels_of(&self, texture: usize) -> u32 {
        self.header.levels - self.header.textures[texture].level + 1
    }

    /// GPU memory of all levels, of the light map and of the mesh of views, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        let map = self.header.light_map.as_ref().map_or(0, LightMap::gpu_bytes);
        let views = self.header.views.as_ref().map_or(0, mesh_bytes);
        (0..self.texels.len()).map(|texture| self.texture_bytes(texture)).sum::<u64>() + map + views
    }

    /// Size of a texture, and its layers over all views: layer `i` of view `v` is `i views + v`.
    pub fn texture_shape(&self, texture: usize) -> Extent {
        let [width, height] = self.header.texture_extent(texture);
        Extent::D2Array([width, height, self.header.textures[texture].layers() * self.header.view_count()])
    }

    fn texture_bytes(&self, texture: usize) -> u64 {
        let texels = self.texture_shape(texture).texels_of_levels(self.levels_of(texture));
        texels * u64::from(self.header.textures[texture].channels)
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        self.bindings().to_file(BTreeMap::from([self.entry()]), supercompress)
    }

    /// Key and value of the header.
    pub(crate) fn entry(&self) -> (String, Vec<u8>) {
        (PWT_ENTRY.to_owned(), self.header.to_bytes())
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/pwt/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/pwt/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let pack = Self::take_from(&mut file)?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }

    /// Takes the pack's images of a file, which may have others.
    ///
    /// # Errors
    /// Returns an error if the header or these images violate `formats/src/pwt/spec.md`.
    pub(crate) fn take_from(file: &mut PackFile) -> Result<Self, FormatError> {
        let own = file.take_own();
        let [map, mesh] = [LIGHT_MAP, VIEWS].map(|name| file.take_texture(name));
        let missing = |name, what: &'static str| FormatError::whole(name, "no texels", what).problem();
        let mut light_map = |side, terms| {
            let map = map.as_ref().ok_or_else(|| missing(LIGHT_MAP, "the light map of learned terms"))?;
            check_texels(map, LIGHT_MAP, map_extent(side, terms), LIGHT_MAP_FORMAT, PWT_ENTRY)?;
            LightMap::from_bytes(side, &map.texels)
        };
        let mut views = |count| mesh_of(mesh.as_ref().ok_or_else(|| missing(VIEWS, "the mesh of views"))?, count);
        let value = entry(&own, PWT_ENTRY, "a polynomial wavelet tree")?;
        let header = PwtHeader::from_bytes(value, &mut light_map, &mut views)?;
        let expected = Self { texels: Vec::new(), header };
        expected.check_bytes()?;
        let others = TEXTURES[1..].iter().map_while(|name| file.take_texture(name));
        let textures: Vec<Texture> = [own].into_iter().chain(others).collect();
        if textures.len() != expected.header.textures.len() {
            let allowed = format!("{}, as {PWT_ENTRY} says", expected.header.textures.len());
            return Err(FormatError::whole("textures", textures.len().to_string(), allowed));
        }
        for (index, texture) in textures.iter().enumerate() {
            expected.check_texture(index, texture)?;
        }
        Self::new(expected.header, textures.into_iter().map(|texture| texture.texels).collect())
    }

    /// Checks that all textures together are within the limit of the container.
    fn check_bytes(&self) -> Result<(), FormatError> {
        let bytes: u64 = (0..self.header.textures.len()).map(|texture| self.texture_bytes(texture)).sum();
        if bytes <= MAX_TEXEL_BYTES {
            return Ok(());
        }
        let field = format!("{PWT_ENTRY} textures");
        Err(FormatError::whole(field, format!("{bytes} bytes of texels"), format!("at most {MAX_TEXEL_BYTES}")))
    }

    fn check_texture(&self, index: usize, texture: &Texture) -> Result<(), FormatError> {
        let found = (texture.format, texture.extent, texture.levels);
        let expected = (self.header.textures[index].texel_format(), self.texture_shape(index), self.levels_of(index));
        if found == expected {
            return Ok(());
        }
        let summary = |(format, extent, levels): (TexelFormat, Extent, u32)| {
            format!("{levels} levels of {extent} texels of {format:?}")
        };
        let allowed = format!("{}, as {PWT_ENTRY} says", summary(expected));
        Err(FormatError::whole(TEXTURES[index], summary(found), allowed))
    }
}
