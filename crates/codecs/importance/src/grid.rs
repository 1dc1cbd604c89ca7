//! Cells of the hemisphere of half vectors.

use brdfc_formats::FormatError;
use brdfc_formats::direction::{Vector, from_polar};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Rings around the normal with equally many cells each. The borders of the rings are at `(k / polar)² π/2`, as in MERL
/// tables: with 128 rings, the first ends at 0.006 degrees, and a lobe one degree wide covers ten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct HalfGrid {
    /// Number of rings.
    pub polar: usize,
    /// Cells per ring, an even number.
    pub azimuths: usize,
}

impl HalfGrid {
    /// Default grid, fine enough for the lobe of chrome.
    pub const DEFAULT: Self = Self { polar: 128, azimuths: 64 };

    /// Checks ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        FormatError::check_range("rings of half vectors", self.polar, 1..=4096)?;
        if !(2..=4096).contains(&self.azimuths) || !self.azimuths.is_multiple_of(2) {
            let allowed = "an even number, 2 to 4096";
            return Err(FormatError::whole("half vectors of a ring", self.azimuths.to_string(), allowed));
        }
        Ok(())
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.polar * self.azimuths
    }

    /// `1 - cos` of a ring border, 0 to `polar`, computed without cancellation near the normal.
    pub fn border(&self, ring: usize) -> f64 {
        let sine = (0.5 * self.angle(ring as f64)).sin();
        2.0 * sine * sine
    }

    /// Solid angle of each cell of a ring, sr.
    pub fn solid_angle(&self, ring: usize) -> f64 {
        (self.border(ring + 1) - self.border(ring)) * TAU / self.azimuths as f64
    }

    /// Half vector at the centre of a cell.
    pub fn centre(&self, ring: usize, cell: usize) -> Vector {
        from_polar(self.angle(ring as f64 + 0.5), (cell as f64 + 0.5) * TAU / self.azimuths as f64)
    }

    fn angle(&self, position: f64) -> f64 {
        let share = position / self.polar as f64;
        share * share * FRAC_PI_2
    }
}
