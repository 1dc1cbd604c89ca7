//! The KTX2 container of every pack. Layout: `formats/src/container/spec.md`.
//!
//! Headers, level index and data format descriptor are the `ktx2` crate's; this file sequences them by the rules of
//! the Khronos validator and holds incoming files to the few shapes that packs have.

use super::texel_format::TexelFormat;
use crate::{FormatError, memory};
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

/// A texture of one level, and its entries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    /// How a texel is stored.
    pub format: TexelFormat,
    /// 2D, 2D array or 3D, and the number of texels along each axis.
    pub extent: Extent,
    /// Key/value entries named `brdfc.*`; the container adds its own `KTX*` entries.
    pub entries: BTreeMap<String, Vec<u8>>,
    /// Texels, x fastest, then y, then z or the layer; little-endian components.
    pub texels: Vec<u8>,
}

impl Texture {
    /// The bytes of the file.
    ///
    /// # Panics
    /// When `texels` does not have the length that format and extent call for: a mistake of the caller.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let [width, height, depth, layers] = self.extent.fields();
        let texel_bytes = self.format.texel_bytes();
        let length = self.extent.texels() * texel_bytes as u64;
        assert_eq!(self.texels.len() as u64, length, "texel data has the wrong length");

        let compressed = supercompress
            .then(|| zstd::bulk::compress(&self.texels, ZSTD_LEVEL).expect("compression into memory does not fail"));
        let level: &[u8] = compressed.as_deref().unwrap_or(&self.texels);
        let descriptor = self.format.descriptor();
        let entries = self.entry_bytes();

        let descriptor_offset = ktx2::Header::LENGTH + ktx2::LevelIndex::LENGTH;
        let entries_offset = descriptor_offset + descriptor.len();
        // Levels are aligned to whole texels and 4 bytes, unless supercompressed; all our texel sizes are powers of two.
        let alignment = if supercompress { 1 } else { texel_bytes.max(4) };
        let level_offset = (entries_offset + entries.len()).next_multiple_of(alignment);

        let header = ktx2::Header {
            format: Some(self.format.vulkan()),
            type_size: self.format.component_bytes() as u32,
            pixel_width: width,
            pixel_height: height,
            pixel_depth: depth,
            layer_count: layers,
            face_count: 1,
            level_count: 1,
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
        let index = ktx2::LevelIndex {
            byte_offset: level_offset as u64,
            byte_length: level.len() as u64,
            uncompressed_byte_length: self.texels.len() as u64,
        };
        let mut bytes = Vec::with_capacity(level_offset + level.len());
        bytes.extend_from_slice(&header.as_bytes());
        bytes.extend_from_slice(&index.as_bytes());
        bytes.extend_from_slice(&descriptor);
        bytes.extend_from_slice(&entries);
        bytes.resize(level_offset, 0);
        bytes.extend_from_slice(level);
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
    /// uncompressed or with Zstandard.
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
                "9, 37, 70, 76, 91, 97, 103, 109 or 123",
            )
        })?;
        check_descriptor(bytes, &header.index, format)?;
        let reader = ktx2::Reader::new(bytes).map_err(refused)?;
        let extent =
            Extent::from_fields([header.pixel_width, header.pixel_height, header.pixel_depth, header.layer_count])?;
        for (offset, field, found, allowed) in [
            (16, "typeSize", header.type_size, format.component_bytes() as u32),
            (36, "faceCount", header.face_count, 1),
            (40, "levelCount", header.level_count, 1),
        ] {
            if found != allowed {
                return Err(FormatError::at_byte(offset, field, found.to_string(), allowed.to_string()));
            }
        }
        let mut entries = BTreeMap::new();
        for (key, value) in reader.key_value_data().filter(|(key, _)| key.starts_with("brdfc.")) {
            if entries.insert(key.to_owned(), value.to_owned()).is_some() {
                return Err(FormatError::whole(key.to_owned(), "two entries of this name", "one"));
            }
        }
        let scheme = u32::from_le_bytes([bytes[44], bytes[45], bytes[46], bytes[47]]);
        Ok(Self { format, extent, entries, scheme, reader })
    }

    /// Bytes of texels on a GPU.
    pub fn texel_bytes(&self) -> u64 {
        self.extent.texels() * self.format.texel_bytes() as u64
    }

    /// Unpacks texels of at most `limit` bytes: known before.
    ///
    /// # Errors
    /// More texels; texels that are not as the rest says.
    pub fn unpack(self, limit: u64) -> Result<Texture, FormatError> {
        let size = self.texel_bytes();
        let limit = limit.min(MAX_TEXEL_BYTES);
        if size > limit {
            let allowed = format!("at most {limit}");
            return Err(FormatError::at_byte(20, "texture", format!("{size} bytes of texels"), allowed));
        }
        let level = self.reader.levels().next().expect("levelCount is 1");
        let texels = texels(&level, self.scheme, size)?;
        Ok(Texture { format: self.format, extent: self.extent, entries: self.entries, texels })
    }
}

fn texels(level: &ktx2::Level<'_>, scheme: u32, size: u64) -> Result<Vec<u8>, FormatError> {
    const LEVEL_INDEX: u64 = 80;
    let wrong_size = |offset, field, found: u64| {
        FormatError::at_byte(offset, field, found.to_string(), format!("{size}, as format and extent say"))
    };
    if level.uncompressed_byte_length != size {
        return Err(wrong_size(LEVEL_INDEX + 16, "uncompressedByteLength", level.uncompressed_byte_length));
    }
    match scheme {
        0 if level.data.len() as u64 == size => Ok(level.data.to_vec()),
        0 => Err(wrong_size(LEVEL_INDEX + 8, "byteLength", level.data.len() as u64)),
        2 => {
            let refused =
                |found: String| FormatError::whole("level 0", found, format!("Zstandard data of {size} bytes"));
            // A frame says how long its contents are: believe that before asking for memory.
            let declared = zstd::zstd_safe::get_frame_content_size(level.data).ok().flatten();
            if declared != Some(size) {
                return Err(refused(
                    declared.map_or("no content size".to_owned(), |n| format!("a frame of {n} bytes")),
                ));
            }
            // A block of 128 KiB takes 4 bytes at least.
            if size > (level.data.len() as u64 / 4 + 1) << 17 {
                return Err(refused(format!("{} bytes, too few for that", level.data.len())));
            }
            let mut texels = memory::reserved("texels", size as usize)?;
            zstd::bulk::Decompressor::new()
                .and_then(|mut decompressor| decompressor.decompress_to_buffer(level.data, &mut texels))
                .map_err(|error| refused(error.to_string()))?;
            if texels.len() as u64 == size { Ok(texels) } else { Err(refused(format!("{} bytes", texels.len()))) }
        }
        other => {
            Err(FormatError::at_byte(44, "supercompressionScheme", other.to_string(), "0 (none) or 2 (Zstandard)"))
        }
    }
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
