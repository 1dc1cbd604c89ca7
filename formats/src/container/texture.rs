//! KTX2 container of every pack. Layout: `formats/src/container/spec.md`.
//!
//! The `ktx2` crate handles header, level index and data format descriptor. This module orders them by the rules of the
//! Khronos validator and restricts files to the forms that packs use.

use super::checksum;
use super::extent::Extent;
use super::levels;
use super::texel_format::TexelFormat;
use crate::FormatError;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Value of `KTXwriter`. It has no version, so that files change only with their contents.
pub const WRITER: &str = "brdfc";
/// Maximum size of the texels of a pack after decompression, bytes.
pub const MAX_TEXEL_BYTES: u64 = 1 << 30;
/// Zstandard level; higher levels hardly shrink files and take longer.
const ZSTD_LEVEL: i32 = 3;
/// Offset of `levelCount` in the header.
const LEVEL_COUNT: u64 = 40;

/// A texture and its key/value data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    /// Format of each texel.
    pub format: TexelFormat,
    /// Dimension and number of texels along each axis.
    pub extent: Extent,
    /// Key/value data under `brdfc.*` keys; the container adds the `KTX*` keys.
    pub entries: BTreeMap<String, Vec<u8>>,
    /// Number of mipmap levels, 1 to [`Extent::most_levels`].
    pub levels: u32,
    /// Texels: x fastest, then y, then z, the layer or the face, then levels from the finest; little-endian components.
    pub texels: Vec<u8>,
}

impl Texture {
    /// Contents of the file.
    ///
    /// # Panics
    /// Panics if the number of levels is 0 or more than the extent has, or if `texels` does not have the length that
    /// format, extent and levels require.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let [width, height, depth, layers, faces] = self.extent.fields();
        let texel_bytes = self.format.texel_bytes();
        assert!((1..=self.extent.most_levels()).contains(&self.levels), "{} levels", self.levels);
        let length = self.extent.texels_of_levels(self.levels) * texel_bytes as u64;
        assert_eq!(self.texels.len() as u64, length, "texel data has the wrong length");

        let mut rest = &self.texels[..];
        let levels: Vec<(Cow<'_, [u8]>, usize)> = (0..self.levels)
            .map(|level| {
                let length = (self.extent.level(level).texels() * texel_bytes as u64) as usize;
                let (texels, coarser) = rest.split_at(length);
                rest = coarser;
                let stored = if supercompress {
                    let frame = zstd::bulk::compress(texels, ZSTD_LEVEL);
                    Cow::Owned(frame.expect("compression into memory does not fail"))
                } else {
                    Cow::Borrowed(texels)
                };
                (stored, length)
            })
            .collect();
        let descriptor = self.format.descriptor();
        let entries = self.entry_bytes();

        let descriptor_offset = ktx2::Header::LENGTH + levels.len() * ktx2::LevelIndex::LENGTH;
        let entries_offset = descriptor_offset + descriptor.len();
        // Levels are aligned to whole texels and 4 bytes unless supercompressed; all texel sizes are powers of two.
        let alignment = if supercompress { 1 } else { texel_bytes.max(4) };
        let mut end = entries_offset + entries.len();
        // The coarsest level comes first.
        let mut index: Vec<ktx2::LevelIndex> = levels
            .iter()
            .rev()
            .map(|(stored, length)| {
                let offset = end.next_multiple_of(alignment);
                end = offset + stored.len();
                ktx2::LevelIndex {
                    byte_offset: offset as u64,
                    byte_length: stored.len() as u64,
                    uncompressed_byte_length: *length as u64,
                }
            })
            .collect();
        index.reverse();

        let header = ktx2::Header {
            format: Some(self.format.vulkan()),
            type_size: self.format.component_bytes() as u32,
            pixel_width: width,
            pixel_height: height,
            pixel_depth: depth,
            layer_count: layers,
            face_count: faces,
            level_count: self.levels,
            supercompression_scheme: supercompress.then_some(ktx2::SupercompressionScheme::Zstandard),
            index: ktx2::Index {
                dfd_byte_offset: descriptor_offset as u32,
                dfd_byte_length: descriptor.len() as u32,
                kvd_byte_offset: entries_offset as u32,
                kvd_byte_length: entries.len() as u32,
                sgd_byte_offset: 0,
                sgd_byte_length: 0,
            },
        };
        let mut bytes = Vec::with_capacity(end);
        bytes.extend_from_slice(&header.as_bytes());
        index.iter().for_each(|level| bytes.extend_from_slice(&level.as_bytes()));
        bytes.extend_from_slice(&descriptor);
        bytes.extend_from_slice(&entries);
        for ((stored, _), place) in levels.iter().zip(&index).rev() {
            bytes.resize(place.byte_offset as usize, 0);
            bytes.extend_from_slice(stored);
        }
        bytes
    }

    /// Key/value data sorted by key bytes, each padded to 4 bytes.
    fn entry_bytes(&self) -> Vec<u8> {
        let text = |s: &str| format!("{s}\0").into_bytes();
        let mut all = self.entries.clone();
        all.insert("KTXorientation".to_owned(), text(self.extent.orientation()));
        all.insert("KTXwriter".to_owned(), text(WRITER));
        let mut bytes = Vec::new();
        for (key, value) in &all {
            bytes.extend_from_slice(&((key.len() + 1 + value.len()) as u32).to_le_bytes());
            bytes.extend_from_slice(key.as_bytes());
            bytes.push(0);
            bytes.extend_from_slice(value);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        bytes
    }

    /// Reads a single-level file of the form that [`Self::to_bytes`] writes.
    ///
    /// # Errors
    /// Returns an error if the file is not a 2D texture, 2D array, 3D texture or cube map with one level in one of the
    /// [`TexelFormat`]s, without supercompression or with Zstandard. [`PackedTexture::unpack_levels`] reads several
    /// levels.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_bytes_within(bytes, MAX_TEXEL_BYTES)
    }

    /// Same as [`Self::from_bytes`], with a limit in bytes on the texels, checked before decompression.
    ///
    /// # Errors
    /// Same as [`Self::from_bytes`]; also returns an error if the texels take more than `limit` bytes.
    pub fn from_bytes_within(bytes: &[u8], limit: u64) -> Result<Self, FormatError> {
        PackedTexture::from_bytes(bytes)?.unpack(limit)
    }

    /// Size of all levels on a GPU, bytes.
    pub fn texel_bytes(&self) -> u64 {
        self.texels.len() as u64
    }

    /// Returns an error if there are several mipmap levels.
    pub(crate) fn check_one_level(&self) -> Result<(), FormatError> {
        if self.levels == 1 { Ok(()) } else { Err(several_levels(self.levels)) }
    }
}

/// A [`Texture`] whose texels are still compressed; format, extent and key/value data are available.
pub struct PackedTexture<'a> {
    /// Format of each texel after decompression.
    pub format: TexelFormat,
    /// Dimension and number of texels along each axis.
    pub extent: Extent,
    /// Key/value data under `brdfc.*` keys.
    pub entries: BTreeMap<String, Vec<u8>>,
    /// Number of mipmap levels, 1 to [`Extent::most_levels`].
    pub levels: u32,
    scheme: u32,
    bytes: &'a [u8],
    reader: ktx2::Reader<&'a [u8]>,
}

impl<'a> PackedTexture<'a> {
    /// Reads everything except the texels.
    ///
    /// # Errors
    /// Same as [`Texture::from_bytes`], but several levels are valid. Also returns an error if levels share bytes of
    /// the file.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let refused = |error| {
            let allowed = "a complete KTX2 file";
            match error {
                ktx2::ParseError::BadMagic => {
                    FormatError::at_byte(0, "identifier", "not the identifier of KTX2", allowed).problem()
                }
                ktx2::ParseError::UnexpectedEnd => {
                    FormatError::whole("container", format!("ends after {} bytes", bytes.len()), allowed).problem()
                }
                other => FormatError::whole("container", other.to_string(), allowed).problem(),
            }
        };
        let first = bytes.first_chunk().ok_or_else(|| refused(ktx2::ParseError::UnexpectedEnd))?;
        let header = ktx2::Header::from_bytes(first).map_err(refused)?;
        let format = TexelFormat::ALL.into_iter().find(|f| Some(f.vulkan()) == header.format).ok_or_else(|| {
            FormatError::at_byte(
                12,
                "vkFormat",
                header.format.map_or("0 (undefined)".to_owned(), |f| f.value().to_string()),
                "9, 16, 37, 64, 70, 76, 91, 97, 98, 103, 107, 109 or 123",
            )
        })?;
        check_descriptor(bytes, &header.index, format)?;
        let ktx2::Header { pixel_width, pixel_height, pixel_depth, layer_count, face_count, type_size, .. } = header;
        let extent = Extent::from_fields([pixel_width, pixel_height, pixel_depth, layer_count, face_count])?;
        if type_size != format.component_bytes() as u32 {
            let allowed = format.component_bytes().to_string();
            return Err(FormatError::at_byte(16, "typeSize", type_size.to_string(), allowed));
        }
        let most = extent.most_levels();
        if !(1..=most).contains(&header.level_count) {
            let allowed = if most == 1 { "1".to_owned() } else { format!("1 to {most}") };
            return Err(FormatError::at_byte(LEVEL_COUNT, "levelCount", header.level_count.to_string(), allowed));
        }
        let reader = ktx2::Reader::new(bytes).map_err(refused)?;
        levels::check_places(bytes, header.level_count)?;
        let mut entries = BTreeMap::new();
        for (key, value) in reader.key_value_data().filter(|(key, _)| key.starts_with("brdfc.")) {
            if entries.insert(key.to_owned(), value.to_owned()).is_some() {
                return Err(FormatError::whole(key.to_owned(), "duplicate key", "unique keys").problem());
            }
        }
        let scheme = u32::from_le_bytes([bytes[44], bytes[45], bytes[46], bytes[47]]);
        Ok(Self { format, extent, entries, levels: header.level_count, scheme, bytes, reader })
    }

    /// Compares the file with the value of its checksum.
    ///
    /// # Errors
    /// Returns an error if the checksum is missing or does not match.
    pub(crate) fn check_sum(&self, stored: Option<&[u8]>) -> Result<(), FormatError> {
        checksum::check(self.bytes, stored)
    }

    /// Size of all levels on a GPU, bytes.
    pub fn texel_bytes(&self) -> u64 {
        self.extent.texels_of_levels(self.levels) * self.format.texel_bytes() as u64
    }

    /// Decompresses the texels, which may take at most `limit` bytes. The size is checked before decompression.
    ///
    /// # Errors
    /// Returns an error if there is more than one level, the texels take more than `limit` bytes, or the data is
    /// inconsistent.
    pub fn unpack(self, limit: u64) -> Result<Texture, FormatError> {
        if self.levels != 1 {
            return Err(several_levels(self.levels));
        }
        self.unpack_levels(limit)
    }

    /// Same as [`Self::unpack`] for all mipmap levels, which together may take at most `limit` bytes.
    ///
    /// # Errors
    /// Returns an error if the texels take more than `limit` bytes or the data is inconsistent.
    pub fn unpack_levels(self, limit: u64) -> Result<Texture, FormatError> {
        let size = self.texel_bytes();
        let limit = limit.min(MAX_TEXEL_BYTES);
        if size > limit {
            let allowed = format!("at most {limit}");
            return Err(FormatError::at_byte(20, "texture", format!("{size} bytes of texels"), allowed));
        }
        let texel_bytes = self.format.texel_bytes() as u64;
        let sizes: Vec<u64> = (0..self.levels).map(|level| self.extent.level(level).texels() * texel_bytes).collect();
        let stored: Vec<ktx2::Level<'_>> = self.reader.levels().collect();
        let texels = levels::unpack(&stored, self.scheme, &sizes)?;
        let Self { format, extent, entries, levels, .. } = self;
        Ok(Texture { format, extent, entries, levels, texels })
    }
}

fn several_levels(found: u32) -> FormatError {
    FormatError::at_byte(LEVEL_COUNT, "levelCount", found.to_string(), "1")
}

/// Compares raw bytes before the `ktx2` crate parses them, because it panics at a block dimension of 256.
fn check_descriptor(bytes: &[u8], index: &ktx2::Index, format: TexelFormat) -> Result<(), FormatError> {
    let start = index.dfd_byte_offset as usize;
    let found = bytes.get(start..).and_then(|rest| rest.get(..index.dfd_byte_length as usize));
    if found == Some(&format.descriptor()[..]) {
        return Ok(());
    }
    let found = if found.is_some() { "does not match vkFormat" } else { "end of data" };
    let place = u64::from(index.dfd_byte_offset);
    Err(FormatError::at_byte(place, "data format descriptor", found, "the linear descriptor of vkFormat").problem())
}
