//! The file of a prefiltered environment. Byte layout: `formats/src/environment/spec.md`.

use super::header::{ENVIRONMENT_ENTRY, EnvironmentHeader, MAX_SCALE};
use crate::FormatError;
use crate::bindings::{Binding, Bindings, PackFile, Texels};
use crate::container::entries::{check_texels, entry};
use crate::container::{TexelFormat, Texture, rgb9e5};
use std::collections::BTreeMap;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("environment", 1);

/// WGSL look-up. It declares a uniform block, a cube map and a sampler in bind group 1; see the file.
pub const ENVIRONMENT_WGSL: &str = include_str!("environment.wgsl");

const FORMAT: TexelFormat = TexelFormat::Rgb9E5;
const SAMPLER: &str = "environment_sampler";

/// A prefiltered environment: radiance from all directions, at several sharpnesses.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentPack {
    header: EnvironmentHeader,
    texels: Vec<u32>,
}

impl EnvironmentPack {
    /// Encodes the levels of a cube map, from the finest: texels in the order of the file, linear RGB in W/(m² sr),
    /// finite and not negative. The scale becomes the smallest power of two, 1 or more, that all texels fit into.
    ///
    /// # Errors
    /// Returns an error if the side is out of range, the number of texels is wrong, or a texel is negative or not
    /// finite.
    pub fn new(side: u32, levels: &[Vec<[f32; 3]>]) -> Result<Self, FormatError> {
        let largest = levels.iter().flatten().flatten().fold(0.0f32, |most, c| most.max(*c));
        let mut scale = 1.0f32;
        while largest > rgb9e5::MAX * scale && scale < MAX_SCALE {
            scale *= 2.0;
        }
        let header = EnvironmentHeader { side, scale };
        header.check()?;
        let expected: Vec<u64> = (0..header.levels()).map(|level| header.extent().level(level).texels()).collect();
        let found: Vec<u64> = levels.iter().map(|level| level.len() as u64).collect();
        if found != expected {
            return Err(FormatError::whole("environment texels", format!("{found:?}"), format!("{expected:?}")));
        }
        if let Some(texel) = levels.iter().flatten().find(|texel| texel.iter().any(|c| !(c.is_finite() && *c >= 0.0))) {
            return Err(FormatError::whole("environment texel", format!("{texel:?}"), "finite values of 0 or more"));
        }
        let word = |texel: &[f32; 3]| rgb9e5::encode(texel.map(|c| c / scale));
        Ok(Self { header, texels: levels.iter().flatten().map(word).collect() })
    }

    /// Sizes and scale.
    pub fn header(&self) -> EnvironmentHeader {
        self.header
    }

    /// Texels in the order of the file, as packed words.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// Radiance of the texels of a mipmap level, in the order of the file.
    pub fn level(&self, level: u32) -> impl Iterator<Item = [f32; 3]> + '_ {
        let extent = self.header.extent();
        let (start, length) = (extent.texels_of_levels(level) as usize, extent.level(level).texels() as usize);
        self.texels[start..start + length].iter().map(|word| rgb9e5::decode(*word).map(|c| c * self.header.scale))
    }

    /// Size on a GPU, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        std::mem::size_of_val(&self.texels[..]) as u64
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let entries = BTreeMap::from([(ENVIRONMENT_ENTRY.to_owned(), self.header.to_bytes())]);
        self.bindings().to_file(entries, supercompress)
    }

    /// Bindings of the pack's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        let texels: Vec<u8> = self.texels.iter().flat_map(|word| word.to_le_bytes()).collect();
        let texels = Texels::new(FORMAT, self.header.extent(), texels).of_file();
        let all = [
            Binding::uniform(37, "environment_parameters", self.header.uniform().to_vec()),
            Binding::texture(38, "environment_map", texels.sampled(SAMPLER).with_levels(self.header.levels())),
            Binding::sampler(39, SAMPLER, false),
        ];
        Bindings::new(DECODER.0, DECODER.1, all)
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/environment/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/environment/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let pack = Self::from_texture(&file.take_own())?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }

    fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let header = EnvironmentHeader::from_bytes(entry(texture, ENVIRONMENT_ENTRY, "a prefiltered environment")?)?;
        check_texels(texture, "texture", header.extent(), FORMAT, ENVIRONMENT_ENTRY)?;
        if texture.levels != header.levels() {
            let allowed = format!("{}, as {ENVIRONMENT_ENTRY} says", header.levels());
            return Err(FormatError::whole("levelCount", texture.levels.to_string(), allowed));
        }
        let words = texture.texels.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        Ok(Self { header, texels: words })
    }
}
