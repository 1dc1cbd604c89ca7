//! Summary of a scan.

use brdfc_core::{Darkest, StrayRows};

/// Counts and repairs of a scan.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ScanSummary {
    /// Number of rows of the file.
    pub rows: usize,
    /// Number of direction pairs after averaging equal ones, including mirror images.
    pub distinct: usize,
    /// Largest difference between rows of one direction pair, as a fraction of the larger value.
    pub largest_disagreement: f64,
    /// Number of rows with a negative channel (noise, or a colour outside the gamut), raised to 0.
    pub negative: usize,
    /// Rows with the smallest value of each channel; absent if all rows have the same value above 0.
    pub darkest: Option<Darkest>,
    /// True if all rows have the same azimuth of incidence, except for strays, or none, so that the material is taken
    /// as isotropic.
    pub isotropic: bool,
    /// Rows whose azimuth of incidence differs from the azimuth of the other rows. Absent without such rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strays: Option<StrayRows>,
    /// Number of ignored rows of the file: directions at or below the horizon. Absent without such rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out: Option<usize>,
    /// Estimated noise of the rows: standard deviation as a fraction of the value, from left-out rows. Without noise it is
    /// the error of the fit.
    pub noise: f64,
    /// Smallest and largest number of neighbours of the fits at rows.
    pub neighbours: [usize; 2],
}
