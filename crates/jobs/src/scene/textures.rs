//! Textures of uses, which modulate their materials, and the bandwidth maps of textures.

use super::maps::{Packed, TEXTURE};
use super::place::{ManifestError, line_of};
use super::uses::{TEXTURE_SIZES, Use};
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_bandwidth::map::texture_map;
use brdfc_bandwidth::texture::Placement;
use brdfc_core::words::{format_number, quoted};
use brdfc_formats::FormatError;
use brdfc_source::tile_image::FileImage;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Sides of a texture in metres.
pub const TEXTURE_METRES: RangeInclusive<f64> = 1e-6..=1e6;

/// The texture of a material, of which a build makes a bandwidth map.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureJob {
    /// Path as written in the manifest.
    pub declared: String,
    /// Path, resolved against the manifest's folder.
    pub path: PathBuf,
    /// Width and height in metres.
    pub metres: [f64; 2],
}

impl TextureJob {
    /// The texture of a use; `None` without one.
    pub fn of(used: &Use, folder: &Path) -> Option<Self> {
        let (texture, metres) = (used.texture.as_ref()?, used.texture_size.as_ref()?);
        let declared = texture.get_ref().clone();
        Some(Self { path: folder.join(&declared), declared, metres: *metres.get_ref() })
    }

    /// Parameters that affect the bytes of its map.
    pub(super) fn recipe(&self) -> ([u64; 2], f64) {
        (self.metres.map(f64::to_bits), DEFAULT_EPSILON)
    }

    /// Makes the map of the texture. Returns the bytes of the file.
    ///
    /// # Errors
    /// Returns an error if the size in metres exceeds single precision, which manifests do not allow.
    pub(super) fn map(&self, image: &FileImage<3>) -> Result<(Vec<u8>, Packed<BandwidthFacts>), FormatError> {
        let placement = Placement { metres: self.metres, tiles: true };
        let map = texture_map(&image.pixels, image.width, placement, DEFAULT_EPSILON)?;
        let bytes = map.to_bytes(true);
        let packed = Packed::new(&bytes, BandwidthFacts::new(&map));
        Ok((bytes, packed))
    }
}

/// Checks the texture of a use, given the earlier uses of the same material.
pub(super) fn check(
    used: &Use,
    number: usize,
    text: &str,
    earlier: Option<(usize, &Use)>,
) -> Result<(), ManifestError> {
    let name = |key: &str| format!("uses[{number}].{key}");
    match (&used.texture, &used.texture_size) {
        (Some(texture), None) => {
            let wrong = format!("needs texture_size = {TEXTURE_SIZES}");
            return Err(ManifestError::new(line_of(text, Some(texture.span())), name(TEXTURE), String::new(), wrong));
        }
        (None, Some(size)) => {
            let line = line_of(text, Some(size.span()));
            return Err(ManifestError::new(line, name("texture_size"), String::new(), "needs texture, the image"));
        }
        (Some(_), Some(size)) if !size.get_ref().iter().all(|side| TEXTURE_METRES.contains(side)) => {
            let [width, height] = size.get_ref().map(format_number);
            let (line, found) = (line_of(text, Some(size.span())), format!("[{width}, {height}]"));
            return Err(ManifestError::new(line, name("texture_size"), found, TEXTURE_SIZES));
        }
        _ => {}
    }
    let of = |used: &Use| TextureJob::of(used, Path::new(""));
    let Some((first, other)) = earlier.filter(|(_, other)| of(other) != of(used)) else { return Ok(()) };
    let shown = |used: &Use| match (&used.texture, &used.texture_size) {
        (Some(texture), Some(size)) => {
            let [width, height] = size.get_ref().map(format_number);
            format!("{} of [{width}, {height}] m", quoted(texture.get_ref()))
        }
        _ => "none".to_owned(),
    };
    let span = used.texture.as_ref().map_or(used.material.span(), |texture| texture.span());
    let allowed = format!("{}, as in uses[{first}]; a material has one texture", shown(other));
    Err(ManifestError::new(line_of(text, Some(span)), name(TEXTURE), shown(used), allowed))
}
