//! Facts about an input, as `brdfc info` prints them.

use super::StrayRows;
use brdfc_formats::crop::DirectionRange;

/// Facts about an input, from its reader.
pub trait Describe {
    /// Lines for people: names and values, without the directions that [`Self::summary`] adds.
    fn lines(&self) -> Vec<(&'static str, String)>;

    /// Number of measured samples; 0 for models.
    fn samples(&self) -> u64;

    /// Directions that the input covers.
    fn directions(&self) -> DirectionRange {
        DirectionRange::ALL
    }

    /// Index of the finest level of detail, for packs only: level 0 is the coarsest.
    fn levels(&self) -> Option<u32> {
        None
    }

    /// Number of rows with a negative channel, which was raised to 0.
    fn rows_raised(&self) -> u64 {
        0
    }

    /// Number of rows that are 0 in all channels.
    fn rows_zero(&self) -> u64 {
        0
    }

    /// Rows of a scan whose azimuth of incidence differs from the azimuth of the other rows.
    fn stray_rows(&self) -> Option<StrayRows> {
        None
    }

    /// First and last wavelength of the spectra, nm, if the spectra miss a part of the range that colours depend on.
    fn partial_spectrum(&self) -> Option<[f64; 2]> {
        None
    }

    /// Lines for people: names and values.
    fn summary(&self) -> Vec<(&'static str, String)> {
        let mut lines = self.lines();
        let directions = self.directions();
        if !directions.is_all() {
            lines.push(("directions", format!("{directions}; errors are measured there")));
        }
        lines
    }
}
