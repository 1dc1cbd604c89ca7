//! Cube maps of radiance of any writer, `.ktx2`. Layout: `crates/readers/src/cube_map.md`. The header is parsed here, because errors
//! of the crate `ktx2` name no field.

use brdfc_formats::FormatError;
use brdfc_formats::container::{CUBE_FACES, MAX_EXTENT, half, rgb9e5, unpack_finest};
use brdfc_formats::cursor::Cursor;
use brdfc_formats::memory;

/// Names of the faces in the order of a file.
const FACES: [&str; CUBE_FACES as usize] = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"];

const IDENTIFIER: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Rows run down and columns to the right, as the specification of KTX2 requires of cube maps.
const ORIENTATION: &[u8] = b"rd";

/// The finest level of a cube map of radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct CubeMap {
    side: u32,
    texels: Vec<[f32; 3]>,
}

/// A texel format: value of `vkFormat`, its name without `VK_FORMAT_`, bytes of a texel, and their colour.
struct Format {
    value: u32,
    name: &'static str,
    bytes: usize,
    decode: fn(&[u8]) -> [f32; 3],
}

const FORMATS: [Format; 4] = [
    Format { value: 97, name: "R16G16B16A16_SFLOAT", bytes: 8, decode: halves },
    Format { value: 109, name: "R32G32B32A32_SFLOAT", bytes: 16, decode: floats },
    Format { value: 122, name: "B10G11R11_UFLOAT_PACK32", bytes: 4, decode: small_floats },
    Format { value: 123, name: "E5B9G9R9_UFLOAT_PACK32", bytes: 4, decode: |texel| rgb9e5::decode(word(texel)) },
];

fn halves(texel: &[u8]) -> [f32; 3] {
    [0, 2, 4].map(|at| half::decode(u16::from_le_bytes([texel[at], texel[at + 1]])))
}

fn floats(texel: &[u8]) -> [f32; 3] {
    [0, 4, 8].map(|at| f32::from_bits(word(&texel[at..])))
}

/// Halves without sign and low bits of the mantissa: red and green have 11 bits, blue has 10.
fn small_floats(texel: &[u8]) -> [f32; 3] {
    let word = word(texel);
    [(word & 0x7ff) << 4, (word >> 11 & 0x7ff) << 4, (word >> 22) << 5].map(|bits| half::decode(bits as u16))
}

fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// Returns true for a KTX2 file with keys of `brdfc`: a pack, and no cube map of another writer.
pub fn is_pack(bytes: &[u8]) -> bool {
    Header::new(bytes)
        .and_then(|header| header.keys(bytes))
        .is_ok_and(|keys| keys.iter().any(|(key, _)| key.starts_with(b"brdfc.")))
}

impl CubeMap {
    /// Reads level 0 of a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `crates/readers/src/cube_map.md`. Lengths are checked before memory is allocated.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let header = Header::new(bytes)?;
        let format = header.format()?;
        let side = header.side()?;
        if let Some((_, found)) = header.keys(bytes)?.iter().find(|(key, _)| *key == b"KTXorientation")
            && *found != ORIENTATION
        {
            let found = format!("\"{}\"", found.escape_ascii());
            return Err(FormatError::whole("KTXorientation", found, "\"rd\" for a cube map"));
        }
        let count = CUBE_FACES as usize * (side as usize).pow(2);
        let [offset, length, uncompressed] = header.finest;
        let stored = usize::try_from(offset).ok().zip(usize::try_from(length).ok());
        let data = stored.and_then(|(offset, length)| bytes.get(offset..)?.get(..length)).ok_or_else(|| {
            let found = format!("{length} bytes from byte {offset}, in a file of {} bytes", bytes.len());
            FormatError::whole("level 0", found, "a complete file")
        })?;
        let raw = unpack_finest(data, uncompressed, header.scheme, (count * format.bytes) as u64)?;
        let mut texels = memory::reserved("texels", count)?;
        texels.extend(raw.chunks_exact(format.bytes).map(format.decode));
        Self { side, texels }.checked()
    }

    /// Texels along each side of a face.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Radiance of all texels, linear RGB, finite and not negative: face by face, row by row.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    fn checked(self) -> Result<Self, FormatError> {
        let wrong = self.texels.iter().position(|texel| texel.iter().any(|c| !(c.is_finite() && *c >= 0.0)));
        let Some(at) = wrong else { return Ok(self) };
        let side = self.side as usize;
        let (face, row, column) = (FACES[at / (side * side)], at / side % side, at % side);
        let found = format!("{:?} at texel ({column}, {row}) of face {face}", self.texels[at]);
        Err(FormatError::whole("level 0", found, "finite values of 0 or more"))
    }
}

/// A key and its value.
type Pair<'a> = (&'a [u8], &'a [u8]);

/// Fields of a KTX2 file that matter.
struct Header {
    vk_format: u32,
    /// Width, height, depth, layers, faces and levels.
    sizes: [u32; 6],
    scheme: u32,
    /// Offset and length of the key/value data, bytes.
    keys: [u32; 2],
    /// Level 0: offset and length in the file, and length after decompression, bytes.
    finest: [u64; 3],
}

impl Header {
    fn new(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(bytes);
        if cursor.take(IDENTIFIER.len(), "identifier")? != IDENTIFIER {
            return Err(FormatError::at_byte(0, "identifier", "not the identifier of KTX2", "a KTX2 file").problem());
        }
        let vk_format = cursor.u32("vkFormat")?;
        cursor.u32("typeSize")?;
        let mut sizes = [0; 6];
        for (size, (field, ..)) in sizes.iter_mut().zip(SIZES) {
            *size = cursor.u32(field)?;
        }
        let scheme = cursor.u32("supercompressionScheme")?;
        cursor.take(8, "dfdByteOffset and dfdByteLength")?;
        let keys = [cursor.u32("kvdByteOffset")?, cursor.u32("kvdByteLength")?];
        cursor.take(16, "sgdByteOffset and sgdByteLength")?;
        let finest = [cursor.u64("byteOffset")?, cursor.u64("byteLength")?, cursor.u64("uncompressedByteLength")?];
        Ok(Self { vk_format, sizes, scheme, keys, finest })
    }

    fn format(&self) -> Result<&'static Format, FormatError> {
        FORMATS.iter().find(|format| format.value == self.vk_format).ok_or_else(|| {
            let names = FORMATS.map(|format| format!("{} ({})", format.value, format.name));
            let [most @ .., last] = &names;
            let allowed = format!("{} or {last}", most.join(", "));
            FormatError::at_byte(12, "vkFormat", self.vk_format.to_string(), allowed)
        })
    }

    /// Texels along each side of a face, after all sizes are checked.
    fn side(&self) -> Result<u32, FormatError> {
        let side = self.sizes[0];
        // Faces first: other textures than cube maps have another number.
        for at in [4, 0, 1, 2, 3, 5] {
            let (field, allowed, text) = SIZES[at];
            if !allowed(self.sizes[at], side) {
                let found = self.sizes[at].to_string();
                return Err(FormatError::at_byte(20 + 4 * at as u64, field, found, text));
            }
        }
        Ok(side)
    }

    /// Keys and values, without NUL bytes at the end of a value.
    fn keys<'a>(&self, bytes: &'a [u8]) -> Result<Vec<Pair<'a>>, FormatError> {
        let cut =
            |offset: u64| FormatError::at_byte(offset, "key/value data", "end of data", "a complete file").problem();
        let [offset, length] = self.keys.map(|word| word as usize);
        let mut rest = bytes.get(offset..).and_then(|rest| rest.get(..length)).ok_or_else(|| cut(offset as u64))?;
        let mut keys = Vec::new();
        while let Some((head, after)) = rest.split_first_chunk() {
            let length = u32::from_le_bytes(*head) as usize;
            let pair = after.get(..length).ok_or_else(|| cut((offset + self.keys[1] as usize - rest.len()) as u64))?;
            let mut parts = pair.splitn(2, |byte| *byte == 0);
            let (key, value) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
            let end = value.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
            keys.push((key, &value[..end]));
            rest = after.get(length.next_multiple_of(4)..).unwrap_or_default();
        }
        Ok(keys)
    }
}

/// A size: its field, whether a value is allowed next to a width, and the allowed values.
type Size = (&'static str, fn(u32, u32) -> bool, &'static str);

const SIZES: [Size; 6] = [
    ("pixelWidth", |width, _| (1..=MAX_EXTENT).contains(&width), "1 to 2048 texels along each side of a face"),
    ("pixelHeight", |height, width| height == width, "the pixelWidth: faces are square"),
    ("pixelDepth", |depth, _| depth == 0, "0 for a cube map"),
    ("layerCount", |layers, _| layers <= 1, "0 or 1: a single cube map"),
    ("faceCount", |faces, _| faces == CUBE_FACES, "6, a cube map"),
    // 0 asks for mipmaps to be made at loading.
    ("levelCount", |levels, width| levels <= width.max(1).ilog2() + 1, "at most the levels down to a single texel"),
];

#[cfg(test)]
mod tests;
