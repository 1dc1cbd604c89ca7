//! The parts `weights` and `residual`: values of the base and component weights of each texel, and corrections of shadows
//! in cells. Both have mipmaps.

use super::header::{BASE_LAYERS, GROUP, MAX_GROUPS, RESIDUAL_FORMAT};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{Extent, MAX_EXTENT_2D, MAX_LAYERS, TexelFormat, Texture};
use crate::cursor::Cursor;
use crate::flat_btf::layout::{word, wrong_extent};

/// Key that identifies the weights of a factored flat BTF.
const WEIGHTS: &str = "brdfc.flat-btf.weights";
/// Key that identifies the residual of shadows of a factored flat BTF.
const RESIDUAL: &str = "brdfc.flat-btf.residual";
const VERSION: u32 = 1;

/// Square layers of bytes with mipmaps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::flat_btf) struct ByteLayers {
    /// Name of the part in errors.
    pub part: &'static str,
    pub format: TexelFormat,
    /// Texels per side.
    pub size: u32,
    pub layers: u32,
    /// Number of mipmap levels.
    pub levels: u32,
    /// All levels from the finest, layer by layer, row by row.
    pub texels: Vec<u8>,
}

impl ByteLayers {
    pub fn check(self, most_layers: u32) -> Result<Self, FormatError> {
        let Self { part, size, layers, levels, .. } = self;
        let checked = |what: &str, found: u32, last: u32| {
            FormatError::check_range(format!("{what} of the part {part}"), found, 1..=last)
        };
        checked("size", size, MAX_EXTENT_2D)?;
        checked("layers", layers, most_layers)?;
        checked("levels", levels, self.extent().most_levels())?;
        let expected = self.extent().texels_of_levels(levels) * self.format.texel_bytes() as u64;
        if self.texels.len() as u64 != expected {
            let field = format!("bytes of the part {part}");
            return Err(FormatError::whole(
                field,
                self.texels.len().to_string(),
                format!("{expected}, as its size says"),
            ));
        }
        Ok(self)
    }

    pub fn extent(&self) -> Extent {
        Extent::D2Array([self.size, self.size, self.layers])
    }

    /// A layer of a mipmap level.
    pub fn layer(&self, level: u32, layer: u32) -> &[u8] {
        let texel = self.format.texel_bytes();
        let side = (self.size >> level).max(1) as usize;
        let first = self.extent().texels_of_levels(level) as usize * texel;
        let length = side * side * texel;
        &self.texels[first + layer as usize * length..][..length]
    }

    /// Checks the form of an image.
    pub fn from_texture(
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
            other => Err(wrong_extent(part, other, "a 2D array of square layers")),
        }
    }
}

/// Range of a component: a texel of 0 to 1 means `low + scale texel`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightRange {
    /// Factor of texel values.
    pub scale: f32,
    /// Value of a texel of 0.
    pub low: f32,
}

impl WeightRange {
    /// Decodes the byte of a texel.
    pub fn of_byte(self, byte: u8) -> f32 {
        self.low + self.scale * (f32::from(byte) * (1.0 / 255.0))
    }
}

/// Values of the base and weights of all components, four per texel and layer. The base has the first layers.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightMap {
    layers: ByteLayers,
    ranges: Vec<WeightRange>,
}

impl WeightMap {
    const PART: &'static str = "weights";

    /// Creates weights from texels of four bytes: all mipmap levels from the finest, layer by layer, row by row. There
    /// is one range per component, which determines the number of layers: layers of the base, then layers of
    /// components.
    ///
    /// # Errors
    /// Returns an error if sizes are out of range, the number of bytes is wrong, or ranges are not finite or not four
    /// per layer.
    pub fn new(size: u32, levels: u32, ranges: Vec<WeightRange>, texels: Vec<u8>) -> Result<Self, FormatError> {
        let least = BASE_LAYERS as usize * GROUP;
        if !ranges.len().is_multiple_of(GROUP) || ranges.len() < least {
            let field = format!("numbers of the part {}", Self::PART);
            return Err(FormatError::whole(
                field,
                ranges.len().to_string(),
                format!("a multiple of {GROUP}, at least {least}"),
            ));
        }
        if let Some(k) = ranges.iter().position(|range| !(range.scale.is_finite() && range.low.is_finite())) {
            let (found, allowed) = (format!("{:?}", ranges[k]), "finite numbers");
            return Err(FormatError::whole(format!("{WEIGHTS} range {k}"), found, allowed));
        }
        let (part, format, layers) = (Self::PART, TexelFormat::Rgba8Unorm, (ranges.len() / GROUP) as u32);
        let layers = ByteLayers { part, format, size, layers, levels, texels }.check(BASE_LAYERS + MAX_GROUPS)?;
        Ok(Self { layers, ranges })
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.layers.size
    }

    /// Number of mipmap levels.
    pub fn levels(&self) -> u32 {
        self.layers.levels
    }

    /// Number of layers, including layers of the base.
    pub fn layers(&self) -> u32 {
        self.layers.layers
    }

    /// Ranges of the components, four per layer.
    pub fn ranges(&self) -> &[WeightRange] {
        &self.ranges
    }

    /// All texels in GPU layout.
    pub fn texels(&self) -> &[u8] {
        &self.layers.texels
    }

    /// Texels of a layer, four bytes each, row by row.
    ///
    /// # Panics
    /// Panics if there is no such level or layer.
    pub fn layer(&self, level: u32, layer: u32) -> &[u8] {
        self.layers.layer(level, layer)
    }

    /// Key and value of the ranges.
    pub(in crate::flat_btf) fn entry(&self) -> (String, Vec<u8>) {
        let words = [VERSION, self.ranges.len() as u32].into_iter();
        let words = words.chain(self.ranges.iter().flat_map(|range| [range.scale.to_bits(), range.low.to_bits()]));
        (WEIGHTS.to_owned(), words.flat_map(u32::to_le_bytes).collect())
    }

    /// Reads and validates the image of a file with its ranges.
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
        let layers = ByteLayers::from_texture(texture, Self::PART, TexelFormat::Rgba8Unorm, BASE_LAYERS + MAX_GROUPS)?;
        if layers.layers as usize * GROUP != ranges.len() {
            let allowed = format!("{} layers, as {WEIGHTS} says", ranges.len().div_ceil(GROUP));
            return Err(wrong_extent(Self::PART, layers.extent(), allowed));
        }
        Self::new(layers.size, layers.levels, ranges, layers.texels)
    }
}

/// The residual of shadows. Rays of light determine whether a light reaches a point. These are the share of the value that
/// the point has if it does, and the share of its diffuse albedo that it has otherwise: 1 and 0, if there were only direct
/// light and the relief were exact. In cells, which may be much larger than texels, with a layer per light.
///
/// Cells have two bytes, the share of lit points and that of shaded ones: byte b is `(b / 180)²`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResidualMap {
    layers: ByteLayers,
}

impl ResidualMap {
    const PART: &'static str = "residual";

    /// Creates a residual of `size` cells per side from bytes, two per cell: all mipmap levels down to one cell from the
    /// finest, light by light, row by row.
    ///
    /// # Errors
    /// Returns an error if sizes are out of range or the number of bytes is wrong.
    pub fn new(size: u32, lights: u32, texels: Vec<u8>) -> Result<Self, FormatError> {
        let levels = Extent::D2([size; 2]).most_levels();
        let (part, format, layers) = (Self::PART, RESIDUAL_FORMAT, lights);
        let layers = ByteLayers { part, format, size, layers, levels, texels }.check(MAX_LAYERS)?;
        Ok(Self { layers })
    }

    /// `R`, cells per side.
    pub fn size(&self) -> u32 {
        self.layers.size
    }

    /// Number of mipmap levels.
    pub fn levels(&self) -> u32 {
        self.layers.levels
    }

    /// Number of lights, one for each layer.
    pub fn lights(&self) -> u32 {
        self.layers.layers
    }

    /// All texels in GPU layout.
    pub fn texels(&self) -> &[u8] {
        &self.layers.texels
    }

    /// Cells of a light, two bytes each, row by row.
    ///
    /// # Panics
    /// Panics if there is no such level or light.
    pub fn layer(&self, level: u32, light: u32) -> &[u8] {
        self.layers.layer(level, light)
    }

    /// The byte of a share of the light.
    pub fn byte_of(share: f32) -> u8 {
        (180.0 * share.max(0.0).sqrt()).round().min(255.0) as u8
    }

    /// Share of the light of a filtered number, 0 to 1.
    pub fn share(root: f32) -> f32 {
        let root = root * (255.0 / 180.0);
        root * root
    }

    /// Key and value of the version.
    pub(in crate::flat_btf) fn entry(&self) -> (String, Vec<u8>) {
        (RESIDUAL.to_owned(), VERSION.to_le_bytes().to_vec())
    }

    /// Reads and validates the image of a file with its version.
    pub(in crate::flat_btf) fn from_texture(texture: Texture) -> Result<Self, FormatError> {
        let bytes = sized(entry(&texture, RESIDUAL, "the residual of a factored flat BTF")?, RESIDUAL, 4)?;
        word(&mut Cursor::new(bytes), RESIDUAL, "version", VERSION..=VERSION)?;
        let ByteLayers { size, layers, levels, texels, .. } =
            ByteLayers::from_texture(texture, Self::PART, RESIDUAL_FORMAT, MAX_LAYERS)?;
        let expected = Extent::D2([size; 2]).most_levels();
        if levels != expected {
            let allowed = format!("{expected}, down to one cell");
            return Err(FormatError::whole(format!("levels of the part {}", Self::PART), levels.to_string(), allowed));
        }
        Self::new(size, layers, texels)
    }
}
