//! The file of the lobes of a BRDF. Byte layout: `formats/src/lobes/spec.md`.

use super::header::{LOBES_ENTRY, LobesHeader, MAX_SHARPNESS};
use crate::FormatError;
use crate::bindings::{Binding, Bindings, PackFile, Texels};
use crate::container::entries::{check_texels, entry};
use crate::container::{TexelFormat, Texture, half};
use std::collections::BTreeMap;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("lobes", 2);

/// WGSL look-up. It declares a uniform block and a texture in bind group 1; see the file.
pub const LOBES_WGSL: &str = include_str!("lobes.wgsl");

const FORMAT: TexelFormat = TexelFormat::Rgba16Float;

/// Lobes of a BRDF, with weights for each view angle.
#[derive(Debug, Clone, PartialEq)]
pub struct LobesPack {
    header: LobesHeader,
    /// Weight of each channel without the scale and sharpness, for each row, azimuth and node.
    weights: Vec<[f32; 4]>,
}

impl LobesPack {
    /// Creates a pack from weights, divided by the header's scale, and sharpnesses, row by row, one per view angle and azimuth. Angles
    /// vary fastest. They are rounded to half floats.
    ///
    /// # Errors
    /// Returns an error if the header is out of range, the number of weights is wrong, a weight is not 0 to 65504, or a
    /// sharpness is out of range.
    pub fn new(header: LobesHeader, weights: &[[f32; 4]]) -> Result<Self, FormatError> {
        let rounded = |c: f32| half::decode(half::encode(c));
        Self::checked(header, weights.iter().map(|texel| texel.map(rounded)).collect())
    }

    fn checked(header: LobesHeader, weights: Vec<[f32; 4]>) -> Result<Self, FormatError> {
        header.check()?;
        let expected = header.views() * header.rows as usize;
        if weights.len() != expected {
            let allowed = format!("{expected}, as the header says");
            return Err(FormatError::whole("lobes texels", weights.len().to_string(), allowed));
        }
        for (at, [r, g, b, sharpness]) in weights.iter().enumerate() {
            let is_weight = |c: &f32| c.is_finite() && *c >= 0.0;
            if ![r, g, b].into_iter().all(is_weight) || !(0.0..=MAX_SHARPNESS).contains(sharpness) {
                let (node, row) = (at % header.nodes as usize, at / header.nodes as usize);
                let found = format!("[{r}, {g}, {b}, {sharpness}]");
                let allowed = format!("weights of 0 to {}, and a sharpness of 0 to {MAX_SHARPNESS}", half::MAX);
                return Err(FormatError::whole(format!("lobes texel ({node}, {row})"), found, allowed));
            }
        }
        Ok(Self { header, weights })
    }

    /// The same pack with other errors, see [`LobesHeader::delta_e`].
    ///
    /// # Errors
    /// Returns an error if an error is negative or not finite.
    pub fn with_delta_e(mut self, delta_e: [f32; 2]) -> Result<Self, FormatError> {
        self.header.delta_e = delta_e;
        self.header.check()?;
        Ok(self)
    }

    /// Sizes, errors and lobes.
    pub fn header(&self) -> &LobesHeader {
        &self.header
    }

    /// Weights of red, green and blue without the scale, and sharpness, row by row, azimuth by azimuth.
    pub fn weights(&self) -> &[[f32; 4]] {
        &self.weights
    }

    /// Number of look-ups in the environment.
    pub fn fetches(&self) -> usize {
        self.header.lobes.len()
    }

    /// Size of the texture on a GPU, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        (self.weights.len() * FORMAT.texel_bytes()) as u64
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let entries = BTreeMap::from([(LOBES_ENTRY.to_owned(), self.header.to_bytes())]);
        self.bindings().to_file(entries, supercompress)
    }

    /// Bindings of the pack's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        let texels: Vec<u8> = self.weights.iter().flatten().flat_map(|c| half::encode(*c).to_le_bytes()).collect();
        let all = [
            Binding::uniform(41, "lobes_parameters", self.header.uniform().to_vec()),
            Binding::texture(42, "lobes_weights", Texels::new(FORMAT, self.header.extent(), texels).of_file()),
        ];
        Bindings::new(DECODER.0, DECODER.1, all)
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/lobes/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/lobes/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let pack = Self::from_texture(&file.take_own())?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }

    fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        texture.check_one_level()?;
        let header = LobesHeader::from_bytes(entry(texture, LOBES_ENTRY, "lobes of a BRDF")?)?;
        check_texels(texture, "texture", header.extent(), FORMAT, LOBES_ENTRY)?;
        let (words, _) = texture.texels.as_chunks::<2>();
        let number = |word: &[u8; 2]| half::decode(u16::from_le_bytes(*word));
        let texels = words.as_chunks::<4>().0.iter().map(|[r, g, b, s]| [r, g, b, s].map(number)).collect();
        Self::checked(header, texels)
    }
}
