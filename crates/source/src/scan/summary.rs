//! What is worth knowing about a scan.

use brdfc_core::StrayRows;

/// What was found while a scan was taken in.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ScanSummary {
    /// Rows of the file.
    pub rows: usize,
    /// Direction pairs after equal ones, mirror images included, were averaged.
    pub distinct: usize,
    /// Largest difference between rows of one direction pair, as a fraction of the larger value.
    pub largest_disagreement: f64,
    /// Rows with a negative channel (noise, or a colour outside the gamut), raised to 0.
    pub negative: usize,
    /// Rows that are 0 in all channels.
    pub zero: usize,
    /// Whether all rows have one azimuth of incidence, but for strays, or leave it open, so that the material is taken as
    /// isotropic.
    pub isotropic: bool,
    /// Rows that stray from the azimuth of incidence that the others have. Absent where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strays: Option<StrayRows>,
    /// Rows of the file that say nothing about reflectance: directions at or below the horizon.
    /// Absent where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out: Option<usize>,
}
