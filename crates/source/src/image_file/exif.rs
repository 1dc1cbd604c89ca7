//! Orientation and colour space of EXIF metadata.

use super::colour::Colour;
use brdfc_formats::FormatError;

/// Tags of the directories, and the fields that are read.
const ORIENTATION: u16 = 0x0112;
const EXIF_DIRECTORY: u16 = 0x8769;
pub(super) const INTEROPERABILITY_DIRECTORY: u16 = 0xa005;
pub(super) const COLOUR_SPACE: u16 = 0xa001;
pub(super) const INTEROPERABILITY_INDEX: u16 = 0x0001;
/// Values of the colour space; that of Adobe RGB is not standard.
const SRGB: u16 = 1;
const ADOBE_RGB: u16 = 2;
const UNCALIBRATED: u16 = 0xffff;
/// Maximum number of entries of a directory that are read.
const MAX_ENTRIES: usize = 1024;

/// Fields of EXIF metadata that affect pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Exif {
    /// 1 to 8, as stored.
    pub orientation: Option<u16>,
    pub colour_space: Option<u16>,
    /// True for index R03, which means Adobe RGB.
    pub is_r03: bool,
}

/// Bytes before the header of a TIFF, in segments of JPEG, and in chunks of some writers of PNG.
pub(super) const EXIF: &[u8] = b"Exif\0\0";

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
        let number = |at: Option<usize>, tag| at.and_then(|at| tiff.number(at, tag));
        let short = |at, tag| number(at, tag).and_then(|value| u16::try_from(value).ok());
        exif.orientation = short(first, ORIENTATION);
        let inner = number(first, EXIF_DIRECTORY);
        exif.colour_space = short(inner, COLOUR_SPACE);
        let index = number(inner, INTEROPERABILITY_DIRECTORY).and_then(|at| tiff.field(at, INTEROPERABILITY_INDEX));
        exif.is_r03 = index.and_then(|field| bytes.get(field..field + 3)) == Some(b"R03");
        exif
    }

    /// Colour of code values without an ICC profile.
    pub(super) fn colour(&self) -> Result<Colour, FormatError> {
        match self.colour_space {
            Some(SRGB) => Ok(Colour::srgb("sRGB (EXIF)")),
            Some(ADOBE_RGB) => Colour::adobe_rgb("Adobe RGB (EXIF)"),
            _ if self.is_r03 => Colour::adobe_rgb("Adobe RGB (EXIF)"),
            Some(UNCALIBRATED) => Ok(Colour::srgb("sRGB (EXIF states an uncalibrated colour space)")),
            _ => Ok(Colour::srgb("sRGB (not stated)")),
        }
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

    /// Number of a field of type SHORT, LONG or IFD: writers do not agree on the type.
    fn number(&self, directory: usize, tag: u16) -> Option<usize> {
        let value = self.field(directory, tag)?;
        match self.u16_at(value - 6)? {
            3 => self.u16_at(value).map(usize::from),
            4 | 13 => self.u32_at(value),
            _ => None,
        }
    }

    /// Offset of the four bytes of a field.
    fn field(&self, directory: usize, tag: u16) -> Option<usize> {
        let entries = usize::from(self.u16_at(directory)?).min(MAX_ENTRIES);
        let mut places = (0..entries).map(|k| directory.saturating_add(2 + 12 * k));
        places.find(|at| self.u16_at(*at) == Some(tag)).map(|at| at + 8)
    }
}
