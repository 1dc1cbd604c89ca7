//! The parts `weights` and `shadow`: what a texel has of the base and of each component, and how much of each light reaches it.
//! Both have mipmaps.

use super::header::{BASE_LAYERS, GROUP, MAX_GROUPS};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{Extent, MAX_EXTENT_2D, MAX_LAYERS, TexelFormat, Texture};
use crate::cursor::Cursor;
use crate::flat_btf::layout::{word, wrong_extent};

/// The entry that makes a texture the weights of a factored flat BTF.
const WEIGHTS: &str = "brdfc.flat-btf.weights";
/// The entry that makes a texture the shadows of a factored flat BTF.
const SHADOW: &str = "brdfc.flat-btf.shadow";
const VERSION: u32 = 1;

/// Layers of bytes with mipmaps.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Layers {
    part: &'static str,
    format: TexelFormat,
    size: u32,
    layers: u32,
    levels: u32,
    texels: Vec<u8>,
}

impl Layers {
    fn check(self, most_layers: u32) -> Result<Self, FormatError> {
        let Self { part, size, layers, levels, .. } = self;
        let checked = |what: &str, found: u32, last: u32| {
            FormatError::check_range(format!("{what} of the part {part}"), found, 1..=last)
        };
        checked("size", size, MAX_EXTENT_2D)?;
        checked("layers", layers, most_layers)?;
        checked("levels", levels, self.extent().most_levels())?;
        let wanted = self.extent().texels_of_levels(levels) * self.format.texel_bytes() as u64;
        if self.texels.len() as u64 != wanted {
            let field = format!("bytes of the part {part}");
            return Err(FormatError::whole(
                field,
                self.texels.len().to_string(),
                format!("{wanted}, as its size says"),
            ));
        }
        Ok(self)
    }

    fn extent(&self) -> Extent {
        Extent::D2Array([self.size, self.size, self.layers])
    }

    /// A layer of a mipmap level.
    fn layer(&self, level: u32, layer: u32) -> &[u8] {
        let texel = self.format.texel_bytes();
        let side = (self.size >> level).max(1) as usize;
        let first = self.extent().texels_of_levels(level) as usize * texel;
        let length = side * side * texel;
        &self.texels[first + layer as usize * length..][..length]
    }

    fn from_texture(
        texture: Texture,
        part: &'static str,
        format: TexelFormat,
        most_layers: u32,
    ) -> Result<Self, FormatError> {
        if texture.format != format {
            let field = format!("texels of the part {part}");
            return Err(FormatError::whole(field, format!("{:?}", texture.format), format!("{format:?}")));
        }
        match texture.extent {
            Extent::D2Array([width, height, layers]) if width == height => {
                Self { part, format, size: width, layers, levels: texture.levels, texels: texture.texels }
                    .check(most_layers)
            }
            other => Err(wrong_extent(part, other, "a 2D array of equal sides")),
        }
    }
}

/// What a weight of 0 to 1 stands for: `low + scale texel`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightRange {
    /// What texels are multiplied by.
    pub scale: f32,
    /// What is added to that.
    pub low: f32,
}

impl WeightRange {
    /// What the byte of a texel stands for.
    pub fn of_byte(self, byte: u8) -> f32 {
        self.low + self.scale * (f32::from(byte) * (1.0 / 255.0))
    }
}

/// Numbers of the base and weights of all components: four to a texel, and to a layer. The base has the first layers.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightMap {
    layers: Layers,
    ranges: Vec<WeightRange>,
}

impl WeightMap {
    const PART: &'static str = "weights";

    /// Weights from texels of four bytes: all mipmap levels from the finest, layer by layer, row by row. A range per number
    /// says how many layers there are: those of the base, and one at least of components.
    ///
    /// # Errors
    /// Sizes out of range, another number of bytes, ranges that are not four to a layer or not finite.
    pub fn new(size: u32, levels: u32, ranges: Vec<WeightRange>, texels: Vec<u8>) -> Result<Self, FormatError> {
        let least = (BASE_LAYERS as usize + 1) * GROUP;
        if !ranges.len().is_multiple_of(GROUP) || ranges.len() < least {
            let field = format!("numbers of the part {}", Self::PART);
            return Err(FormatError::whole(
                field,
                ranges.len().to_string(),
                format!("a multiple of {GROUP}, {least} at least"),
            ));
        }
        if let Some(k) = ranges.iter().position(|range| !(range.scale.is_finite() && range.low.is_finite())) {
            let (found, allowed) = (format!("{:?}", ranges[k]), "finite numbers");
            return Err(FormatError::whole(format!("{WEIGHTS} range {k}"), found, allowed));
        }
        let (part, format, layers) = (Self::PART, TexelFormat::Rgba8Unorm, (ranges.len() / GROUP) as u32);
        let layers = Layers { part, format, size, layers, levels, texels }.check(BASE_LAYERS + MAX_GROUPS)?;
        Ok(Self { layers, ranges })
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.layers.size
    }

    /// Mipmap levels.
    pub fn levels(&self) -> u32 {
        self.layers.levels
    }

    /// Layers, those of the base among them.
    pub fn layers(&self) -> u32 {
        self.layers.layers
    }

    /// What the numbers of each layer stand for, four to a layer.
    pub fn ranges(&self) -> &[WeightRange] {
        &self.ranges
    }

    /// All texels, as a GPU takes them.
    pub fn texels(&self) -> &[u8] {
        &self.layers.texels
    }

    /// Four bytes a texel, row by row.
    ///
    /// # Panics
    /// Without such a level or layer.
    pub fn layer(&self, level: u32, layer: u32) -> &[u8] {
        self.layers.layer(level, layer)
    }

    /// The entry of the ranges.
    pub(in crate::flat_btf) fn entry(&self) -> (String, Vec<u8>) {
        let words = [VERSION, self.ranges.len() as u32].into_iter();
        let words = words.chain(self.ranges.iter().flat_map(|range| [range.scale.to_bits(), range.low.to_bits()]));
        (WEIGHTS.to_owned(), words.flat_map(u32::to_le_bytes).collect())
    }

    /// Reads and checks the image of a file with its entry.
    pub(in crate::flat_btf) fn from_texture(texture: Texture) -> Result<Self, FormatError> {
        let bytes = entry(&texture, WEIGHTS, "the weights of a factored flat BTF")?;
        if bytes.len() < 8 {
            return Err(FormatError::whole(WEIGHTS, format!("{} bytes", bytes.len()), "8 bytes or more"));
        }
        let mut cursor = Cursor::new(bytes);
        word(&mut cursor, WEIGHTS, "version", VERSION..=VERSION)?;
        let numbers = word(&mut cursor, WEIGHTS, "numbers", 1..=(BASE_LAYERS + MAX_GROUPS) * GROUP as u32)?;
        sized(bytes, WEIGHTS, 8 + 8 * numbers as usize)?;
        let range = |_| Ok(WeightRange { scale: cursor.f32("scale")?, low: cursor.f32("low")? });
        let ranges = (0..numbers).map(range).collect::<Result<Vec<_>, FormatError>>()?;
        let layers = Layers::from_texture(texture, Self::PART, TexelFormat::Rgba8Unorm, BASE_LAYERS + MAX_GROUPS)?;
        if layers.layers as usize * GROUP != ranges.len() {
            let allowed = format!("{} layers, as {WEIGHTS} says", ranges.len().div_ceil(GROUP));
            return Err(wrong_extent(Self::PART, layers.extent(), allowed));
        }
        Self::new(layers.size, layers.levels, ranges, layers.texels)
    }
}

/// How much of each light reaches a texel, averaged over views: a factor of linear RGB, a layer to each light.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShadowMap {
    layers: Layers,
}

impl ShadowMap {
    const PART: &'static str = "shadow";

    /// Shadows from bytes, 0 in shadow and 255 lit: all mipmap levels from the finest, light by light, row by row.
    ///
    /// # Errors
    /// Sizes out of range, another number of bytes.
    pub fn new(size: u32, levels: u32, lights: u32, texels: Vec<u8>) -> Result<Self, FormatError> {
        let (part, format, layers) = (Self::PART, TexelFormat::R8Unorm, lights);
        let layers = Layers { part, format, size, layers, levels, texels }.check(MAX_LAYERS)?;
        Ok(Self { layers })
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.layers.size
    }

    /// Mipmap levels.
    pub fn levels(&self) -> u32 {
        self.layers.levels
    }

    /// Number of lights.
    pub fn lights(&self) -> u32 {
        self.layers.layers
    }

    /// All texels, as a GPU takes them.
    pub fn texels(&self) -> &[u8] {
        &self.layers.texels
    }

    /// A byte a texel, row by row.
    ///
    /// # Panics
    /// Without such a level or light.
    pub fn layer(&self, level: u32, light: u32) -> &[u8] {
        self.layers.layer(level, light)
    }

    /// The entry of the version.
    pub(in crate::flat_btf) fn entry(&self) -> (String, Vec<u8>) {
        (SHADOW.to_owned(), VERSION.to_le_bytes().to_vec())
    }

    /// Reads and checks the image of a file with its entry.
    pub(in crate::flat_btf) fn from_texture(texture: Texture) -> Result<Self, FormatError> {
        let bytes = sized(entry(&texture, SHADOW, "the shadows of a factored flat BTF")?, SHADOW, 4)?;
        word(&mut Cursor::new(bytes), SHADOW, "version", VERSION..=VERSION)?;
        Ok(Self { layers: Layers::from_texture(texture, Self::PART, TexelFormat::R8Unorm, MAX_LAYERS)? })
    }
}
