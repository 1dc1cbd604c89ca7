//! Orientation and colour space of EXIF metadata.

/// Tags of the directories, and the fields that are read.
const ORIENTATION: u16 = 0x0112;
const EXIF_DIRECTORY: u16 = 0x8769;
const INTEROPERABILITY_DIRECTORY: u16 = 0xa005;
const COLOUR_SPACE: u16 = 0xa001;
const INTEROPERABILITY_INDEX: u16 = 0x0001;
/// Maximum number of entries of a directory that are read.
const MAX_ENTRIES: usize = 1024;

/// Fields of EXIF metadata that affect pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Exif {
    /// 1 to 8, as stored.
    pub orientation: Option<u16>,
    /// 1 for sRGB, 2 for Adobe RGB (not standard), 65535 for others.
    pub colour_space: Option<u16>,
    /// True for index R03, which means Adobe RGB.
    pub is_r03: bool,
}

impl Exif {
    /// Reads the directories after the header of a TIFF; fields of broken metadata are missing.
    pub(super) fn from_bytes(bytes: &[u8]) -> Self {
        let mut exif = Self::default();
        let big = match bytes.get(..4) {
            Some([b'I', b'I', 42, 0]) => false,
            Some([b'M', b'M', 0, 42]) => true,
            _ => return exif,
        };
        let tiff = Directories { bytes, big };
        let first = tiff.u32_at(4);
        exif.orientation = first.and_then(|at| tiff.field(at, ORIENTATION)).and_then(|field| tiff.u16_at(field));
        let next = |at: Option<usize>, tag| at.and_then(|at| tiff.field(at, tag)).and_then(|field| tiff.u32_at(field));
        let inner = next(first, EXIF_DIRECTORY);
        exif.colour_space = inner.and_then(|at| tiff.field(at, COLOUR_SPACE)).and_then(|field| tiff.u16_at(field));
        let index = next(inner, INTEROPERABILITY_DIRECTORY).and_then(|at| tiff.field(at, INTEROPERABILITY_INDEX));
        exif.is_r03 = index.and_then(|field| bytes.get(field..field + 3)) == Some(b"R03");
        exif
    }
}

struct Directories<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl Directories<'_> {
    fn u16_at(&self, at: usize) -> Option<u16> {
        let bytes = self.bytes.get(at..)?.first_chunk()?;
        Some(if self.big { u16::from_be_bytes(*bytes) } else { u16::from_le_bytes(*bytes) })
    }

    fn u32_at(&self, at: usize) -> Option<usize> {
        let bytes = self.bytes.get(at..)?.first_chunk()?;
        let value = if self.big { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) };
        usize::try_from(value).ok()
    }

    /// Offset of the four bytes of a field.
    fn field(&self, directory: usize, tag: u16) -> Option<usize> {
        let entries = usize::from(self.u16_at(directory)?).min(MAX_ENTRIES);
        let mut places = (0..entries).map(|k| directory.saturating_add(2 + 12 * k));
        places.find(|at| self.u16_at(*at) == Some(tag)).map(|at| at + 8)
    }
}
