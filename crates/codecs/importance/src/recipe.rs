//! What a list of importance samples is made with.

use super::grid::HalfGrid;
use brdfc_formats::FormatError;
use brdfc_formats::importance::ImportanceHeader;

/// Sizes and shares of [`importance_samples`](super::importance_samples).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ImportanceRecipe {
    /// Polar angles of the outgoing direction for isotropic materials, 1 to 1024.
    pub isotropic_polar: u32,
    /// Polar angles of the outgoing direction for others.
    pub anisotropic_polar: u32,
    /// Azimuths of the outgoing direction for others, a multiple of 4 up to 256.
    pub anisotropic_azimuths: u32,
    /// Samples of each outgoing direction, 1 to 8192.
    pub samples: u32,
    /// Where half vectors are tabulated.
    pub grid: HalfGrid,
    /// Share of the samples that does not follow the lobe, above 0 up to 1: what keeps densities away from 0 where the
    /// table misses something.
    pub defensive: f64,
}

impl Default for ImportanceRecipe {
    fn default() -> Self {
        Self {
            isotropic_polar: 64,
            anisotropic_polar: 32,
            anisotropic_azimuths: 16,
            samples: 1024,
            grid: HalfGrid::DEFAULT,
            defensive: 0.1,
        }
    }
}

impl ImportanceRecipe {
    /// The sizes of the pack.
    pub fn header(&self, isotropic: bool) -> ImportanceHeader {
        let (polar, azimuths) =
            if isotropic { (self.isotropic_polar, 1) } else { (self.anisotropic_polar, self.anisotropic_azimuths) };
        ImportanceHeader { polar, azimuths, samples: self.samples }
    }

    /// Checks ranges, and gives the sizes of the pack.
    ///
    /// # Errors
    /// Names what is out of range.
    pub fn check(&self, isotropic: bool) -> Result<ImportanceHeader, FormatError> {
        let header = self.header(isotropic);
        header.check()?;
        if !isotropic && header.isotropic() {
            let found = format!("{} of an anisotropic material", header.azimuths);
            return Err(FormatError::whole("azimuth columns", found, "a multiple of 4"));
        }
        self.grid.check()?;
        if !(self.defensive > 0.0 && self.defensive <= 1.0) {
            return Err(FormatError::whole("defensive share", self.defensive.to_string(), "above 0, up to 1"));
        }
        Ok(header)
    }
}
