//! Settings of importance samples.

use super::grid::HalfGrid;
use brdfc_formats::FormatError;
use brdfc_formats::importance::ImportanceHeader;

/// Sizes and shares of [`importance_samples`](super::importance_samples).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ImportanceRecipe {
    /// Number of polar angles of the outgoing direction for isotropic materials, 1 to 1024.
    pub isotropic_polar: u32,
    /// Number of polar angles of the outgoing direction for other materials.
    pub anisotropic_polar: u32,
    /// Number of azimuths of the outgoing direction for other materials, a multiple of 4 up to 256.
    pub anisotropic_azimuths: u32,
    /// Samples per outgoing direction, 1 to 8192.
    pub samples: u32,
    /// Grid of the half vectors.
    pub grid: HalfGrid,
    /// Share of the samples that does not follow the lobe, above 0 up to 1. It keeps densities above 0 where the table
    /// misses part of the lobe.
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
    /// Sizes of the pack.
    pub fn header(&self, isotropic: bool) -> ImportanceHeader {
        let (polar, azimuths) =
            if isotropic { (self.isotropic_polar, 1) } else { (self.anisotropic_polar, self.anisotropic_azimuths) };
        ImportanceHeader { polar, azimuths, samples: self.samples }
    }

    /// Checks ranges and returns the sizes of the pack.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
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
