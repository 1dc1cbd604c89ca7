//! Header of view-dependent indirection maps.

use super::layout::wrong_extent;
use crate::FormatError;
use crate::container::{Extent, MAX_EXTENT_2D};
use std::f32::consts::FRAC_PI_2;
use std::ops::RangeInclusive;

/// Key that identifies a view-dependent indirection map.
pub(crate) const VDIM: &str = "brdfc.flat-btf.vdim";
/// Key that identifies compact samples.
pub(crate) const COMPACT: &str = "brdfc.flat-btf.compact";
/// Part that holds `Δ_v`.
pub(super) const VDIM_PART: &str = "vdim";
/// Maximum texels of the reference plane per side.
pub const MAX_VDIM_SIZE: u32 = 4096;
/// Polar angles and rows of azimuths that a map can have.
pub const POLAR_ANGLES: RangeInclusive<u32> = 2..=256;
/// Rows of azimuths that a map can have. The last row repeats the first.
pub const AZIMUTH_ROWS: RangeInclusive<u32> = 4..=256;
/// Maximum tangent of a polar angle in [`VdimHeader::growth`].
const MAX_TANGENT: f32 = 8.0;
/// Number that is added to the tangent.
const TANGENT_BIAS: f32 = 0.25;

/// Header of a view-dependent indirection map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VdimHeader {
    /// `M`, texels of the reference plane per side, 1 to [`MAX_VDIM_SIZE`]; a multiple of `2^(levels - 1)` blocks.
    pub size: u32,
    /// Texels per side that share a block of samples: 1, unless samples are compact.
    pub block: u32,
    /// `Z`, number of polar angles: sample `k` is at `k φ_max / (Z - 1)`.
    pub polar_angles: u32,
    /// `R`, number of rows: row `a` has the azimuth `2π a / (R - 1)`, so that the last repeats the first.
    pub azimuth_rows: u32,
    /// `φ_max`, the largest polar angle, radians, above 0 up to π/2. Steeper views use it.
    pub largest_angle: f32,
    /// Number of levels of detail: level m is a map of `M / 2^m` texels per side.
    pub levels: u32,
    /// Number of lights whose shadows are sampled, 0 for none.
    pub lights: u32,
}

impl VdimHeader {
    /// Texels of the reference plane per side of a level.
    pub fn side(&self, level: u32) -> u32 {
        self.size >> level
    }

    /// Extent of the reference.
    pub fn reference_extent(&self) -> Extent {
        Extent::D2([self.size; 2])
    }

    /// Extent of the packed map: `Z x R` samples for each block.
    pub fn packed_extent(&self) -> Extent {
        let blocks = self.size / self.block;
        Extent::D2([blocks * self.polar_angles, blocks * self.azimuth_rows])
    }

    /// Checks the number of texels of a part on all levels.
    pub(super) fn check_length(&self, part: &str, found: usize, extent: Extent) -> Result<(), FormatError> {
        let expected = extent.texels_of_levels(self.levels);
        if found as u64 == expected {
            return Ok(());
        }
        let field = format!("texels of the part {part}");
        Err(FormatError::whole(field, found.to_string(), format!("{expected}, as the header says")))
    }

    /// Polar angle and azimuth of the view of sample `(k, a)`, radians.
    pub fn view_angles(&self, k: u32, a: u32) -> [f64; 2] {
        let polar = f64::from(self.largest_angle) * f64::from(k) / f64::from(self.polar_angles - 1);
        [polar, std::f64::consts::TAU * f64::from(a) / f64::from(self.azimuth_rows - 1)]
    }

    /// Level of detail that a decoder uses: the nearest, as levels are not blended.
    pub(super) fn level(&self, detail: f32) -> u32 {
        (detail.max(0.0).min((self.levels - 1) as f32) + 0.5).floor() as u32
    }

    /// Checks all ranges, and that the packed map is not too large.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let checked = |field: &str, found, range| FormatError::check_range(format!("{VDIM} {field}"), found, range);
        checked("size", self.size, 1..=MAX_VDIM_SIZE)?;
        if self.block == 0 || !self.size.is_multiple_of(self.block) {
            let allowed = format!("a divisor of the size {}", self.size);
            return Err(FormatError::whole(format!("{COMPACT} block"), self.block.to_string(), allowed));
        }
        checked("polar angles", self.polar_angles, POLAR_ANGLES)?;
        checked("azimuth rows", self.azimuth_rows, AZIMUTH_ROWS)?;
        if !(self.largest_angle > 0.0 && self.largest_angle <= FRAC_PI_2) {
            let field = format!("{VDIM} largest angle");
            return Err(FormatError::whole(field, self.largest_angle.to_string(), "above 0, up to π/2 radians"));
        }
        checked("levels", self.levels, 1..=(self.size / self.block).trailing_zeros() + 1)?;
        checked("lights", self.lights, 0..=super::MAX_DIRECTIONS)?;
        let Extent::D2([width, height]) = self.packed_extent() else { unreachable!("a 2D texture") };
        if width.max(height) > MAX_EXTENT_2D {
            let allowed = format!(
                "at most {MAX_EXTENT_2D} on each side: blocks times polar angles, and blocks times rows of azimuths"
            );
            return Err(wrong_extent(VDIM_PART, self.packed_extent(), allowed));
        }
        Ok(())
    }

    /// Maximum tangent of the polar angle of a view, at which displacements stop to grow.
    pub fn largest_tangent(&self) -> f32 {
        let tangent = f64::from(self.largest_angle).tan() as f32;
        if tangent > 0.0 { tangent.min(MAX_TANGENT) } else { MAX_TANGENT }
    }

    /// Divisor of the displacements of sample `k`: displacements grow with the tangent of the polar angle.
    pub fn growth(&self, k: u32) -> f64 {
        let tangent = self.view_angles(k, 0)[0].tan();
        let most = f64::from(self.largest_tangent());
        f64::from(TANGENT_BIAS) + if (0.0..most).contains(&tangent) { tangent } else { most }
    }

    /// [`Self::growth`] of any view.
    pub(super) fn growth_towards(&self, [x, y, z]: [f32; 3]) -> f32 {
        let most = self.largest_tangent();
        let tangent = if z > 0.0 { ((x * x + y * y).sqrt() / z).min(most) } else { most };
        tangent + TANGENT_BIAS
    }

    /// Extent of the ranges: minima and extents of each block.
    pub(super) fn ranges_extent(&self) -> Extent {
        let blocks = self.size / self.block;
        Extent::D2Array([blocks, blocks, 2])
    }
}
