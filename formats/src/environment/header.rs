//! Sizes and kernels of a prefiltered environment.

use crate::FormatError;
use crate::container::Extent;
use crate::container::entries::sized;
use crate::cursor::{Cursor, block_bytes};

/// Key that identifies a prefiltered environment.
pub const ENVIRONMENT_ENTRY: &str = "brdfc.environment";

const VERSION: u32 = 1;
/// Minimum texels along each side of a face of the finest level.
pub const MIN_SIDE: u32 = 8;
/// Maximum texels along each side of a face of the finest level.
pub const MAX_SIDE: u32 = 2048;
/// Maximum factor of texel values, 2^112: all radiances are finite.
pub(super) const MAX_SCALE: f32 = f32::from_bits((112 + 127) << 23);
/// Smallest factor that the encoder uses, 2^-100: products with all texels are normal numbers.
pub(super) const MIN_SCALE: f32 = f32::from_bits((127 - 100) << 23);
/// Texels along each side of a face of the irradiance.
pub const IRRADIANCE_SIDE: u32 = 16;
/// Standard deviation of a Gaussian level in texels of the cube's equator.
const TEXELS_PER_DEVIATION: f64 = 1.4;

/// Header of a prefiltered environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvironmentHeader {
    /// Texels along each side of a face of the finest level: a power of two, [`MIN_SIDE`] to [`MAX_SIDE`].
    pub side: u32,
    /// Factor of texel values, a positive normal number up to 2^112.
    pub scale: f32,
}

impl EnvironmentHeader {
    /// Size of the uniform block, bytes.
    pub const UNIFORM_SIZE: usize = 16;
    /// Length of the key's value, bytes.
    const LENGTH: usize = 12;

    /// True for an allowed side.
    pub fn is_side(side: u32) -> bool {
        side.is_power_of_two() && (MIN_SIDE..=MAX_SIDE).contains(&side)
    }

    /// Number of mipmap levels.
    pub fn levels(&self) -> u32 {
        self.sharpest()
    }

    /// Sharpness of the finest level, which is not filtered. The coarsest has 1.
    pub fn sharpest(&self) -> u32 {
        (self.side / MIN_SIDE).ilog2() + 1
    }

    /// Extent of the finest level.
    pub fn extent(&self) -> Extent {
        Extent::Cube(self.side)
    }

    /// Standard deviation of the kernel of a sharpness of 1 or more, radians; it halves with each step. At
    /// [`Self::sharpest`] the level is not filtered.
    pub fn deviation(sharpness: f64) -> f64 {
        TEXELS_PER_DEVIATION * std::f64::consts::FRAC_PI_2 / f64::from(MIN_SIDE) / (sharpness - 1.0).exp2()
    }

    /// Sharpness of a kernel with this standard deviation, radians, at least 1: the inverse of [`Self::deviation`].
    pub fn sharpness(deviation: f64) -> f64 {
        (1.0 + (Self::deviation(1.0) / deviation).log2()).max(1.0)
    }

    /// Mipmap level of a sharpness, 0 to `levels - 1`, with fractions.
    pub fn level(&self, sharpness: f32) -> f32 {
        let sharpest = self.sharpest() as f32;
        (sharpest - sharpness).clamp(0.0, sharpest - 1.0)
    }

    /// The uniform block `EnvironmentParameters`.
    pub fn uniform(&self) -> [u8; Self::UNIFORM_SIZE] {
        block_bytes([(self.sharpest() as f32).to_bits(), self.scale.to_bits()])
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        if !Self::is_side(self.side) {
            let allowed = format!("a power of two, {MIN_SIDE} to {MAX_SIDE}");
            return Err(FormatError::whole(format!("{ENVIRONMENT_ENTRY} side"), self.side.to_string(), allowed));
        }
        if !self.scale.is_normal() || !(0.0..=MAX_SCALE).contains(&self.scale) {
            let field = format!("{ENVIRONMENT_ENTRY} scale");
            return Err(FormatError::whole(field, self.scale.to_string(), "a positive normal number up to 2^112"));
        }
        Ok(())
    }

    pub(super) fn to_bytes(self) -> Vec<u8> {
        [VERSION, self.side, self.scale.to_bits()].into_iter().flat_map(u32::to_le_bytes).collect()
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(sized(bytes, ENVIRONMENT_ENTRY, Self::LENGTH)?);
        let version = cursor.u32("version")?;
        if version != VERSION {
            let field = format!("{ENVIRONMENT_ENTRY} version");
            return Err(FormatError::whole(field, version.to_string(), VERSION.to_string()));
        }
        let header = Self { side: cursor.u32("side")?, scale: f32::from_bits(cursor.u32("scale")?) };
        header.check()?;
        Ok(header)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_halve_and_levels_count_from_the_coarsest() {
        let header = EnvironmentHeader { side: 256, scale: 1.0 };
        assert_eq!((header.levels(), header.sharpest()), (6, 6));
        assert!((EnvironmentHeader::deviation(1.0).to_degrees() - 15.75).abs() < 1e-9);
        assert!((EnvironmentHeader::deviation(3.0).to_degrees() - 15.75 / 4.0).abs() < 1e-9);
        for sharpness in [1.0, 2.5, 9.0] {
            assert!((EnvironmentHeader::sharpness(EnvironmentHeader::deviation(sharpness)) - sharpness).abs() < 1e-9);
        }
        assert_eq!(EnvironmentHeader::sharpness(1.0), 1.0);
        assert_eq!([0.0, 5.5, 6.0, 9.0, -1.0].map(|s| header.level(s)), [5.0, 0.5, 0.0, 0.0, 5.0]);
    }
}
