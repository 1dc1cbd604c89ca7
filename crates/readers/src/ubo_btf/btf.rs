//! BTFs as products of matrices.

use super::colour::ColourModel;
use super::matrix::Channel;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::{FormatError, memory};

/// Signature at the beginning of every file.
pub const SIGNATURE: &[u8; 10] = b"!DFMF08FCR";
/// Supported versions of the header.
pub const VERSIONS: std::ops::RangeInclusive<u32> = 1..=4;
/// Maximum width and height, texels.
pub const MAX_SIZE: u32 = 4096;
/// Number of channels of a colour.
pub const CHANNELS: usize = 3;
/// Number of bytes of each name in the header.
pub(super) const NAME_BYTES: usize = 80;

/// Supported versions, for messages.
pub(super) fn versions() -> String {
    format!("{} to {}", VERSIONS.start(), VERSIONS.end())
}

/// Metadata of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Version of the header.
    pub version: u32,
    /// Names of the measurement setup, of the sensor and of the light.
    pub devices: [String; 3],
    /// Texels per millimetre, as stored.
    pub texels_per_millimetre: f32,
    /// Factors of red, green and blue, as stored. They are not applied to values.
    pub rgb_factors: [f32; 3],
    /// True if values include the cosine of the light's polar angle.
    pub has_cosine: bool,
    /// Size of the skipped XML about the measurement, bytes.
    pub xml_bytes: u32,
    /// Directions to the viewer.
    pub views: DirectionSet,
    /// Directions to the light; the same for every view.
    pub lights: DirectionSet,
    /// Width and height, texels.
    pub size: [usize; 2],
    /// Conversion of channels to red, green and blue.
    pub colour_model: ColourModel,
}

/// A BTF with its matrices as stored; values are computed on demand.
///
/// Row 0 is the first in the file, the top of the tile.
#[derive(Debug, Clone, PartialEq)]
pub struct UboBtf {
    pub(super) description: Description,
    pub(super) channels: [Channel; CHANNELS],
}

impl UboBtf {
    /// Creates a checked BTF. Row `view * lights + light` of a channel's first matrix belongs to a pair of directions,
    /// row `row * width + column` of its second matrix to a texel.
    ///
    /// # Errors
    /// Returns an error for a size outside 1 to [`MAX_SIZE`], matrices with other numbers of rows, a version outside
    /// [`VERSIONS`], version 1 with a cosine flag, and a PCA whose numbers are not finite.
    pub fn new(description: Description, channels: [Channel; CHANNELS]) -> Result<Self, FormatError> {
        let wrong = |field: &'static str, found: usize, allowed: String| {
            Err(FormatError::whole(field, found.to_string(), allowed))
        };
        for side in description.size {
            FormatError::check_range("texels along a side", side, 1..=MAX_SIZE as usize)?;
        }
        if !VERSIONS.contains(&description.version) {
            return wrong("version", description.version as usize, versions());
        }
        if description.has_cosine && description.version == 1 {
            return Err(FormatError::whole(
                "cosine flag",
                "set, but version 1 has no such flag",
                "an unset flag, or version 2 to 4",
            )
            .problem());
        }
        if !description.colour_model.is_finite() {
            return Err(FormatError::whole("colour model", "values that are not finite", "finite numbers").problem());
        }
        let pairs = description.views.len() * description.lights.len();
        let [width, height] = description.size;
        for channel in &channels {
            if channel.pairs().rows() != pairs {
                return wrong("rows of pairs of directions", channel.pairs().rows(), pairs.to_string());
            }
            if channel.texels().rows() != width * height {
                return wrong("rows of texels", channel.texels().rows(), (width * height).to_string());
            }
        }
        Ok(Self { description, channels })
    }

    /// Metadata of the file.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The channels before conversion to colours.
    pub fn channels(&self) -> &[Channel; CHANNELS] {
        &self.channels
    }

    /// Size of the matrices in memory, bytes.
    pub fn memory_bytes(&self) -> u64 {
        self.channels.iter().map(|channel| channel.pairs().memory_bytes() + channel.texels().memory_bytes()).sum()
    }

    /// Linear RGB of one texel, by indices of the view and the light and by `row * width + column`.
    ///
    /// Values are the results of the matrices and the colour model, without clipping: they may be slightly negative. If
    /// [`Description::has_cosine`] is false, they exclude the cosine of the light's polar angle.
    ///
    /// # Errors
    /// Returns an error for indices out of range.
    pub fn texel(&self, view: usize, light: usize, texel: usize) -> Result<[f32; 3], FormatError> {
        let pair = self.pair(view, light)?;
        let [width, height] = self.description.size;
        if texel >= width * height {
            return Err(FormatError::whole("texel", texel.to_string(), format!("less than {}", width * height)));
        }
        let rows = self.channels.each_ref().map(|channel| channel.pairs().row(pair));
        Ok(self.colour(std::array::from_fn(|c| self.channels[c].texels().dot(texel, &rows[c]))))
    }

    /// Linear RGB of the whole tile, as from [`Self::texel`], row by row from the top.
    ///
    /// # Errors
    /// Returns an error for indices out of range.
    pub fn image(&self, view: usize, light: usize) -> Result<Vec<[f32; 3]>, FormatError> {
        let pair = self.pair(view, light)?;
        let [width, height] = self.description.size;
        let mut pixels = memory::filled("texels", width * height, [0.0; 3])?;
        for (c, channel) in self.channels.iter().enumerate() {
            let row = channel.pairs().row(pair);
            for (texel, pixel) in pixels.iter_mut().enumerate() {
                pixel[c] = channel.texels().dot(texel, &row);
            }
        }
        pixels.iter_mut().for_each(|pixel| *pixel = self.colour(*pixel));
        Ok(pixels)
    }

    /// Always finite, for any matrices.
    fn colour(&self, channels: [f32; 3]) -> [f32; 3] {
        self.description
            .colour_model
            .to_rgb(channels)
            .map(|c| if c.is_nan() { 0.0 } else { c.clamp(f32::MIN, f32::MAX) })
    }

    fn pair(&self, view: usize, light: usize) -> Result<usize, FormatError> {
        let (views, lights) = (self.description.views.len(), self.description.lights.len());
        for (field, index, count) in [("view", view, views), ("light", light, lights)] {
            if index >= count {
                return Err(FormatError::whole(field, index.to_string(), format!("less than {count}")));
            }
        }
        Ok(view * lights + light)
    }
}
