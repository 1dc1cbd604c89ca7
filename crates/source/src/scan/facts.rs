//! Facts about a file of a scan.

use super::fit::{NEIGHBOURS_3D, NEIGHBOURS_4D};
use super::summary::ScanSummary;
use brdfc_core::words::percent;
use brdfc_core::{Darkest, Describe, StrayRows};

/// Range that a spectrum has to cover for its colour to be known, nm. Below it are 14 % of the observer's z̄ and 3 % of x̄,
/// above it 4 % of x̄.
const COLOURED: [f64; 2] = [430.0, 650.0];

/// Facts about a scattered scan.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ScanFacts {
    /// Wavelengths in nm; empty for RGB columns.
    pub wavelengths: Vec<f64>,
    /// Header of an ALTA table; absent for other scans.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alta: Option<AltaHeader>,
    /// Counts and repairs of the scan's rows.
    #[serde(flatten)]
    pub summary: ScanSummary,
}

/// Header of an ALTA table, verbatim.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct AltaHeader {
    /// Parameterisation of directions, `PARAM_IN`.
    pub directions: String,
    /// Quantity of the values, `PARAM_OUT`.
    pub values: String,
    /// Number of values of a row: 1 or 3.
    pub channels: usize,
}

impl Describe for ScanFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        let Self { wavelengths, alta, summary } = self;
        let s = summary;
        let isotropic = if s.strays.is_some() {
            "taken as isotropic: one azimuth of incidence, except for a few rows"
        } else if s.isotropic {
            "taken as isotropic: one azimuth of incidence"
        } else {
            "anisotropic: several azimuths of incidence"
        };
        let spectrum = match (wavelengths.first(), wavelengths.last(), alta) {
            (Some(only), _, _) if wavelengths.len() == 1 => format!("1 wavelength, {only} nm"),
            (Some(first), Some(last), _) => format!("{} wavelengths, {first} to {last} nm", wavelengths.len()),
            (.., Some(alta)) if alta.channels == 1 => format!("one column, {}", alta.values),
            (.., Some(alta)) => format!("RGB columns, {}", alta.values),
            _ => "RGB columns".to_owned(),
        };
        let zero = s.darkest.filter(|darkest| darkest.value == [0.0; 3]).map_or(0, |darkest| darkest.samples);
        let [least, most] = s.neighbours;
        // Without smoothing the residuals may be errors of the fit.
        let is_smoothed = most > if s.isotropic { NEIGHBOURS_3D } else { NEIGHBOURS_4D };
        let noise = match most {
            1 => "unknown: one neighbour leaves no residual".to_owned(),
            _ => format!("{}{}", if is_smoothed { "" } else { "at most " }, percent(s.noise)),
        };
        let neighbours = if least == most { least.to_string() } else { format!("{least} to {most}") };
        let mut lines = vec![
            ("kind", if alta.is_some() { "scattered scan, ALTA table" } else { "scattered scan" }.to_owned()),
            ("rows", format!("{} ({} distinct direction pairs)", s.rows, s.distinct)),
            ("material", isotropic.to_owned()),
            ("values", spectrum),
            ("repeated or mirrored rows differ up to", percent(s.largest_disagreement)),
            ("rows with negative channels, raised to 0", s.negative.to_string()),
            ("rows that are all 0", zero.to_string()),
            ("estimated noise of the rows", noise),
            ("neighbours of a fit", neighbours),
        ];
        if let Some(alta) = alta {
            lines.insert(2, ("directions", alta.directions.clone()));
        }
        if let Some(strays) = s.strays {
            lines.push(("rows of another azimuth", strays.summary()));
        }
        if let Some(left_out) = s.left_out {
            lines.push(("skipped rows, at or below the horizon", left_out.to_string()));
        }
        lines
    }

    fn samples(&self) -> u64 {
        self.summary.rows as u64
    }

    fn rows_raised(&self) -> u64 {
        self.summary.negative as u64
    }

    fn darkest(&self) -> Option<Darkest> {
        self.summary.darkest
    }

    fn stray_rows(&self) -> Option<StrayRows> {
        self.summary.strays
    }

    fn partial_spectrum(&self) -> Option<[f64; 2]> {
        let ends = [*self.wavelengths.first()?, *self.wavelengths.last()?];
        (ends[0] > COLOURED[0] || ends[1] < COLOURED[1]).then_some(ends)
    }
}
