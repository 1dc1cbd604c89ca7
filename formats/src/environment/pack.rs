//! The file of a prefiltered environment. Byte layout: `formats/src/environment/spec.md`.

use super::header::{ENVIRONMENT_ENTRY, EnvironmentHeader, IRRADIANCE_SIDE, MAX_SCALE, MIN_SCALE};
use crate::FormatError;
use crate::bindings::{Binding, Bindings, PackFile, Texels};
use crate::container::entries::{check_texels, entry};
use crate::container::{Extent, TexelFormat, Texture, rgb9e5};
use std::collections::BTreeMap;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("environment", 1);

/// WGSL look-up. It declares a uniform block, two cube maps and a sampler in bind group 1; see the file.
pub const ENVIRONMENT_WGSL: &str = include_str!("environment.wgsl");

const FORMAT: TexelFormat = TexelFormat::Rgb9E5;
const SAMPLER: &str = "environment_sampler";
/// Name of the texture of the irradiance.
const IRRADIANCE: &str = "environment_irradiance";
const IRRADIANCE_EXTENT: Extent = Extent::Cube(IRRADIANCE_SIDE);

/// A prefiltered environment: radiance from all directions, at several sharpnesses.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentPack {
    header: EnvironmentHeader,
    texels: Vec<u32>,
    irradiance: Vec<u32>,
}

impl EnvironmentPack {
    /// Encodes the levels of a cube map, from the finest, and the irradiance over π: texels in the order of the file,
    /// linear RGB in W/(m² sr), finite and not negative. The scale becomes the smallest power of two, 2^-100 or more, that all
    /// texels fit into.
    ///
    /// # Errors
    /// Returns an error if the side is out of range, the number of texels is wrong, or a texel is negative or not
    /// finite.
    pub fn new(side: u32, levels: &[Vec<[f32; 3]>], irradiance: &[[f32; 3]]) -> Result<Self, FormatError> {
        let all = || levels.iter().flatten().chain(irradiance);
        let largest = all().flatten().fold(0.0f32, |most, c| most.max(*c));
        let mut scale = 1.0f32;
        while largest > rgb9e5::MAX * scale && scale < MAX_SCALE {
            scale *= 2.0;
        }
        // Small texels would lose digits: the format has a smallest exponent.
        while largest > 0.0 && largest <= 0.5 * rgb9e5::MAX * scale && scale > MIN_SCALE {
            scale *= 0.5;
        }
        let header = EnvironmentHeader { side, scale };
        header.check()?;
        let of_levels = (0..header.levels()).map(|level| header.extent().level(level).texels());
        let expected: Vec<u64> = of_levels.chain([IRRADIANCE_EXTENT.texels()]).collect();
        let found: Vec<u64> = levels.iter().map(Vec::len).chain([irradiance.len()]).map(|count| count as u64).collect();
        if found != expected {
            return Err(FormatError::whole("environment texels", format!("{found:?}"), format!("{expected:?}")));
        }
        if let Some(texel) = all().find(|texel| texel.iter().any(|c| !(c.is_finite() && *c >= 0.0))) {
            return Err(FormatError::whole("environment texel", format!("{texel:?}"), "finite values of 0 or more"));
        }
        let word = |texel: &[f32; 3]| rgb9e5::encode(texel.map(|c| c / scale));
        let texels = levels.iter().flatten().map(word).collect();
        Ok(Self { header, texels, irradiance: irradiance.iter().map(word).collect() })
    }

    /// Sizes and scale.
    pub fn header(&self) -> EnvironmentHeader {
        self.header
    }

    /// Texels of all levels and of the irradiance, in the order of the file, as packed words.
    pub fn texels(&self) -> impl Iterator<Item = u32> + '_ {
        self.texels.iter().chain(&self.irradiance).copied()
    }

    /// Radiance of the texels of a mipmap level, in the order of the file.
    pub fn level(&self, level: u32) -> impl Iterator<Item = [f32; 3]> + '_ {
        let extent = self.header.extent();
        let (start, length) = (extent.texels_of_levels(level) as usize, extent.level(level).texels() as usize);
        self.decoded(&self.texels[start..start + length])
    }

    /// Irradiance over π, in the order of the file, on faces of [`IRRADIANCE_SIDE`] texels per side.
    pub fn irradiance(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        self.decoded(&self.irradiance)
    }

    fn decoded<'a>(&self, words: &'a [u32]) -> impl Iterator<Item = [f32; 3]> + use<'a> {
        let scale = self.header.scale;
        words.iter().map(move |word| rgb9e5::decode(*word).map(|c| c * scale))
    }

    /// Size on a GPU, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        4 * self.texels().count() as u64
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let entries = BTreeMap::from([(ENVIRONMENT_ENTRY.to_owned(), self.header.to_bytes())]);
        self.bindings().to_file(entries, supercompress)
    }

    /// Bindings of the pack's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        let bytes = |words: &[u32]| -> Vec<u8> { words.iter().flat_map(|word| word.to_le_bytes()).collect() };
        let map = Texels::new(FORMAT, self.header.extent(), bytes(&self.texels)).of_file();
        let irradiance = Texels::new(FORMAT, IRRADIANCE_EXTENT, bytes(&self.irradiance));
        let all = [
            Binding::uniform(37, "environment_parameters", self.header.uniform().to_vec()),
            Binding::texture(38, "environment_map", map.sampled(SAMPLER).with_levels(self.header.levels())),
            Binding::texture(39, IRRADIANCE, irradiance.sampled(SAMPLER)),
            Binding::sampler(40, SAMPLER, false),
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
        let (texture, irradiance) = (file.take_own(), file.take_texture(IRRADIANCE));
        let pack = Self::from_textures(&texture, irradiance)?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }

    fn from_textures(texture: &Texture, irradiance: Option<Texture>) -> Result<Self, FormatError> {
        let header = EnvironmentHeader::from_bytes(entry(texture, ENVIRONMENT_ENTRY, "a prefiltered environment")?)?;
        check_texels(texture, "texture", header.extent(), FORMAT, ENVIRONMENT_ENTRY)?;
        if texture.levels != header.levels() {
            let allowed = format!("{}, as {ENVIRONMENT_ENTRY} says", header.levels());
            return Err(FormatError::whole("levelCount", texture.levels.to_string(), allowed));
        }
        let missing = || FormatError::whole(IRRADIANCE, "no texels", "texels of a cube map").problem();
        let irradiance = irradiance.ok_or_else(missing)?;
        check_texels(&irradiance, IRRADIANCE, IRRADIANCE_EXTENT, FORMAT, ENVIRONMENT_ENTRY)?;
        let words = |texture: &Texture| -> Vec<u32> {
            texture.texels.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect()
        };
        Ok(Self { header, texels: words(texture), irradiance: words(&irradiance) })
    }
}
