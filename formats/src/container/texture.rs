//! The KTX2 container of every pack. Layout: `formats/src/container/spec.md`.
//!
//! Headers, level index and data format descriptor are the `ktx2` crate's; this file sequences them by the rules of
//! the Khronos validator and holds incoming files to the few shapes that packs have.

use super::texel_format::TexelFormat;
use crate::{FormatError, memory};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// Who wrote the file, in the `KTXwriter` entry. Holds no version, so that bytes change with contents alone.
pub const WRITER: &str = "brdfc";
/// Orientation of a 3D texture, in the `KTXorientation` entry: x right, y down, z inwards.
pub const ORIENTATION_3D: &str = "rdi";
/// Orientation of 2D textures and their arrays: x right, y down.
pub const ORIENTATION_2D: &str = "rd";
/// Most texels along one axis of a 3D texture: the limit of WebGPU.
pub const MAX_EXTENT: u32 = 2048;
/// Most texels along one axis of a 2D texture: the limit of WebGPU.
pub const MAX_EXTENT_2D: u32 = 8192;
/// Most layers of a 2D array, as desktop drivers have them. WebGPU promises 256.
pub const MAX_LAYERS: u32 = 2048;
/// Most bytes of texels in one pack, after decompression.
pub const MAX_TEXEL_BYTES: u64 = 1 << 30;
/// Zstandard level: past this the files hardly shrink, and time grows.
const ZSTD_LEVEL: i32 = 3;

/// What kind of texture a pack is, and how large.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// A 2D texture: width and height, each 1 to [`MAX_EXTENT_2D`].
    D2([u32; 2]),
    /// An array of 2D textures: width and height, each 1 to [`MAX_EXTENT_2D`], and 1 to [`MAX_LAYERS`] layers.
    D2Array([u32; 3]),
    /// A 3D texture: width, height and depth, each 1 to [`MAX_EXTENT`].
    D3([u32; 3]),
}

impl Extent {
    /// Texels.
    pub fn texels(self) -> u64 {
        match self {
            Self::D2(sides) => sides.into_iter().map(u64::from).product(),
            Self::D2Array(sides) | Self::D3(sides) => sides.into_iter().map(u64::from).product(),
        }
    }

    /// The extent of a mipmap level, 0 the finest: each side halved as often, rounded down, 1 at least.
    pub fn level(self, level: u32) -> Self {
        let side = |side: u32| side.checked_shr(level).unwrap_or(0).max(1);
        match self {
            Self::D2(sides) => Self::D2(sides.map(side)),
            Self::D2Array([width, height, layers]) => Self::D2Array([side(width), side(height), layers]),
            Self::D3(sides) => Self::D3(sides.map(side)),
        }
    }

    /// Mipmap levels down to the one of a single texel.
    pub fn most_levels(self) -> u32 {
        let largest = match self {
            Self::D2(sides) => sides.into_iter().max(),
            Self::D2Array([width, height, _]) => Some(width.max(height)),
            Self::D3(sides) => sides.into_iter().max(),
        };
        largest.unwrap_or(1).max(1).ilog2() + 1
    }

    /// Texels of the finest `levels` levels together.
    pub fn texels_of_levels(self, levels: u32) -> u64 {
        (0..levels).map(|level| self.level(level).texels()).sum()
    }

    /// Width, height, depth and layer count of the header; 0 is the depth and the layer count of what has none.
    fn fields(self) -> [u32; 4] {
        match self {
            Self::D2([width, height]) => [width, height, 0, 0],
            Self::D2Array([width, height, layers]) => [width, height, 0, layers],
            Self::D3([width, height, depth]) => [width, height, depth, 0],
        }
    }

    fn from_fields(fields: [u32; 4]) -> Result<Self, FormatError> {
        let [width, height, depth, layers] = fields;
        let side = if depth == 0 { MAX_EXTENT_2D } else { MAX_EXTENT };
        for (axis, (field, range)) in [
            ("pixelWidth", 1..=side),
            ("pixelHeight", 1..=side),
            ("pixelDepth", 0..=MAX_EXTENT),
            // Arrays of 3D textures are in the format, but hardly anything reads them.
            ("layerCount", 0..=if depth == 0 { MAX_LAYERS } else { 0 }),
        ]
        .into_iter()
        .enumerate()
        {
            if !range.contains(&fields[axis]) {
                let (first, last) = (range.start(), range.end());
                let allowed = if first == last { first.to_string() } else { format!("{first} to {last}") };
                return Err(FormatError::at_byte(20 + 4 * axis as u64, field, fields[axis].to_string(), allowed));
            }
        }
        Ok(match (depth, layers) {
            (0, 0) => Self::D2([width, height]),
            (0, _) => Self::D2Array([width, height, layers]),
            _ => Self::D3([width, height, depth]),
        })
    }

    fn orientation(self) -> &'static str {
        match self {
            Self::D2(_) | Self::D2Array(_) => ORIENTATION_2D,
            Self::D3(_) => ORIENTATION_3D,
        }
    }
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::D2([width, height]) => write!(f, "{width} x {height}"),
            Self::D2Array([width, height, layers]) => write!(f, "{layers} layers of {width} x {height}"),
            Self::D3([width, height, depth]) => write!(f, "{width} x {height} x {depth}"),
        }
    }
}

/// A texture, and its entries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    /// How a texel is stored.
    pub format: TexelFormat,
    /// 2D, 2D array or 3D, and the number of texels along each axis.
    pub extent: Extent,
    /// Key/value entries named `brdfc.*`; the container adds its own `KTX*` entries.
    pub entries: BTreeMap<String, Vec<u8>>,
    /// Mipmap levels, 1 to as many as [`Extent::most_levels`] allows.
    pub levels: u32,
    /// Texels, x fastest, then y, then z or the layer, then the level from the finest; little-endian components.
    pub texels: Vec<u8>,
}

impl Texture {
    /// The bytes of the file.
    ///
    /// # Panics
    /// When `texels` does not have the length that format, extent and levels call for: a mistake of the caller.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let [width, height, depth, layers] = self.extent.fields();
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
        // Levels are aligned to whole texels and 4 bytes, unless supercompressed; all our texel sizes are powers of two.
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
            face_count: 1,
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

    /// Entries sorted by the bytes of their keys, each padded to 4 bytes.
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

    /// Reads a file that [`Self::to_bytes`] could have written; other KTX2 files are refused with the reason.
    ///
    /// # Errors
    /// Anything that is not a 2D texture, 2D array or 3D texture of one level in one of the [`TexelFormat`]s,
    /// uncompressed or with Zstandard. Mipmaps are for [`PackedTexture::unpack_levels`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_bytes_within(bytes, MAX_TEXEL_BYTES)
    }

    /// [`Self::from_bytes`] for a pack whose texels take at most `limit` bytes: known before they are unpacked.
    ///
    /// # Errors
    /// As [`Self::from_bytes`], and more texels than `limit`.
    pub fn from_bytes_within(bytes: &[u8], limit: u64) -> Result<Self, FormatError> {
        PackedTexture::from_bytes(bytes)?.unpack(limit)
    }

    /// Bytes of texels on a GPU.
    pub fn texel_bytes(&self) -> u64 {
        self.texels.len() as u64
    }
}

/// A [`Texture`] whose texels have not been unpacked: enough to tell what it is.
pub struct PackedTexture<'a> {
    /// How a texel is stored.
    pub format: TexelFormat,
    /// Texels along each axis.
    pub extent: Extent,
    /// Key/value entries named `brdfc.*`.
    pub entries: BTreeMap<String, Vec<u8>>,
    /// Mipmap levels.
    pub levels: u32,
    scheme: u32,
    reader: ktx2::Reader<&'a [u8]>,
}

impl<'a> PackedTexture<'a> {
    /// Reads everything but the texels.
    ///
    /// # Errors
    /// As [`Texture::from_bytes`].
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let refused = |error| {
            let allowed = "a whole KTX2 file";
            match error {
                ktx2::ParseError::BadMagic => FormatError::at_byte(0, "identifier", "other bytes", allowed),
                ktx2::ParseError::UnexpectedEnd => {
                    FormatError::whole("container", format!("{} bytes, which end too early", bytes.len()), allowed)
                }
                other => FormatError::whole("container", other.to_string(), allowed),
            }
        };
        let first = bytes.first_chunk().ok_or_else(|| refused(ktx2::ParseError::UnexpectedEnd))?;
        let header = ktx2::Header::from_bytes(first).map_err(refused)?;
        let format = TexelFormat::ALL.into_iter().find(|f| Some(f.vulkan()) == header.format).ok_or_else(|| {
            FormatError::at_byte(
                12,
                "vkFormat",
                header.format.map_or("undefined or unknown".to_owned(), |f| f.value().to_string()),
                "9, 16, 37, 64, 70, 76, 91, 97, 103, 109 or 123",
            )
        })?;
        check_descriptor(bytes, &header.index, format)?;
        let reader = ktx2::Reader::new(bytes).map_err(refused)?;
        let extent =
            Extent::from_fields([header.pixel_width, header.pixel_height, header.pixel_depth, header.layer_count])?;
        for (offset, field, found, allowed) in [
            (16, "typeSize", header.type_size, format.component_bytes() as u32),
            (36, "faceCount", header.face_count, 1),
        ] {
            if found != allowed {
                return Err(FormatError::at_byte(offset, field, found.to_string(), allowed.to_string()));
            }
        }
        let most = extent.most_levels();
        if !(1..=most).contains(&header.level_count) {
            let allowed = if most == 1 { "1".to_owned() } else { format!("1 to {most}") };
            return Err(FormatError::at_byte(40, "levelCount", header.level_count.to_string(), allowed));
        }
        let mut entries = BTreeMap::new();
        for (key, value) in reader.key_value_data().filter(|(key, _)| key.starts_with("brdfc.")) {
            if entries.insert(key.to_owned(), value.to_owned()).is_some() {
                return Err(FormatError::whole(key.to_owned(), "two entries of this name", "one"));
            }
        }
        let scheme = u32::from_le_bytes([bytes[44], bytes[45], bytes[46], bytes[47]]);
        Ok(Self { format, extent, entries, levels: header.level_count, scheme, reader })
    }

    /// Bytes of texels on a GPU, of all levels.
    pub fn texel_bytes(&self) -> u64 {
        self.extent.texels_of_levels(self.levels) * self.format.texel_bytes() as u64
    }

    /// Unpacks texels of at most `limit` bytes: known before.
    ///
    /// # Errors
    /// More than one level; more texels; texels that are not as the rest says.
    pub fn unpack(self, limit: u64) -> Result<Texture, FormatError> {
        if self.levels != 1 {
            return Err(FormatError::at_byte(40, "levelCount", self.levels.to_string(), "1"));
        }
        self.unpack_levels(limit)
    }

    /// [`Self::unpack`] of all mipmap levels.
    ///
    /// # Errors
    /// More texels; texels that are not as the rest says.
    pub fn unpack_levels(self, limit: u64) -> Result<Texture, FormatError> {
        let size = self.texel_bytes();
        let limit = limit.min(MAX_TEXEL_BYTES);
        if size > limit {
            let allowed = format!("at most {limit}");
            return Err(FormatError::at_byte(20, "texture", format!("{size} bytes of texels"), allowed));
        }
        let level_bytes = |number: usize| self.extent.level(number as u32).texels() * self.format.texel_bytes() as u64;
        for (number, level) in self.reader.levels().enumerate() {
            check_level(&level, number, self.scheme, level_bytes(number))?;
        }
        let mut texels = memory::reserved("texels", size as usize)?;
        for (number, level) in self.reader.levels().enumerate() {
            unpack_level(&level, number, self.scheme, level_bytes(number), &mut texels)?;
        }
        let Self { format, extent, entries, levels, .. } = self;
        Ok(Texture { format, extent, entries, levels, texels })
    }
}

/// What a level with wrong Zstandard data is told as.
fn wrong_frame(number: usize, found: String, size: u64) -> FormatError {
    FormatError::whole(format!("level {number}"), found, format!("Zstandard data of {size} bytes"))
}

/// Whether a level of `size` bytes of texels may be in its data, before memory for them is asked for.
fn check_level(level: &ktx2::Level<'_>, number: usize, scheme: u32, size: u64) -> Result<(), FormatError> {
    const LEVEL_INDEX: u64 = 80;
    let index = LEVEL_INDEX + (number * ktx2::LevelIndex::LENGTH) as u64;
    let wrong_size = |offset, field, found: u64| {
        FormatError::at_byte(offset, field, found.to_string(), format!("{size}, as format and extent say"))
    };
    if level.uncompressed_byte_length != size {
        return Err(wrong_size(index + 16, "uncompressedByteLength", level.uncompressed_byte_length));
    }
    match scheme {
        0 if level.data.len() as u64 == size => Ok(()),
        0 => Err(wrong_size(index + 8, "byteLength", level.data.len() as u64)),
        2 => {
            // A frame says how long its contents are.
            let declared = zstd::zstd_safe::get_frame_content_size(level.data).ok().flatten();
            if declared != Some(size) {
                let found = declared.map_or("no content size".to_owned(), |n| format!("a frame of {n} bytes"));
                return Err(wrong_frame(number, found, size));
            }
            // A block of 128 KiB takes 4 bytes at least.
            if size > (level.data.len() as u64 / 4 + 1) << 17 {
                return Err(wrong_frame(number, format!("{} bytes, too few for that", level.data.len()), size));
            }
            Ok(())
        }
        other => {
            Err(FormatError::at_byte(44, "supercompressionScheme", other.to_string(), "0 (none) or 2 (Zstandard)"))
        }
    }
}

/// Appends the texels of a level that was checked.
fn unpack_level(
    level: &ktx2::Level<'_>,
    number: usize,
    scheme: u32,
    size: u64,
    texels: &mut Vec<u8>,
) -> Result<(), FormatError> {
    if scheme == 0 {
        texels.extend_from_slice(level.data);
        return Ok(());
    }
    let before = texels.len();
    let mut own = Vec::new();
    // The first level, or the only one, is unpacked in place.
    let target = if before == 0 { &mut *texels } else { &mut own };
    target.try_reserve_exact(size as usize).map_err(|_| wrong_frame(number, "too little memory".to_owned(), size))?;
    zstd::bulk::Decompressor::new()
        .and_then(|mut decompressor| decompressor.decompress_to_buffer(level.data, target))
        .map_err(|error| wrong_frame(number, error.to_string(), size))?;
    texels.extend_from_slice(&own);
    let found = (texels.len() - before) as u64;
    if found == size { Ok(()) } else { Err(wrong_frame(number, format!("{found} bytes"), size)) }
}

/// Compares bytes, before the `ktx2` crate parses them: it panics at a block dimension of 256.
fn check_descriptor(bytes: &[u8], index: &ktx2::Index, format: TexelFormat) -> Result<(), FormatError> {
    let start = index.dfd_byte_offset as usize;
    let found = bytes.get(start..).and_then(|rest| rest.get(..index.dfd_byte_length as usize));
    if found == Some(&format.descriptor()[..]) {
        return Ok(());
    }
    let found = if found.is_some() { "another description" } else { "end of data" };
    let place = u64::from(index.dfd_byte_offset);
    Err(FormatError::at_byte(place, "data format descriptor", found, "the one of vkFormat, linear"))
}
