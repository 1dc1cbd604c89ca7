//! What is worth knowing of an input, as `brdfc info` prints it.

use super::StrayRows;
use brdfc_formats::crop::DirectionRange;

/// What is worth knowing of an input, as its reader says it.
pub trait Describe {
    /// Lines for people: names and values. [`Self::in_words`] adds the directions.
    fn lines(&self) -> Vec<(&'static str, String)>;

    /// Measured samples that came in; 0 for models.
    fn samples(&self) -> u64;

    /// Directions that a pack is for.
    fn directions(&self) -> DirectionRange {
        DirectionRange::ALL
    }

    /// Levels of detail less one, of packs alone: level 0 is the coarsest.
    fn levels(&self) -> Option<u32> {
        None
    }

    /// Rows with a negative channel, which was raised to 0.
    fn rows_raised(&self) -> u64 {
        0
    }

    /// Rows of a scan that stray from the azimuth of incidence of the others.
    fn stray_rows(&self) -> Option<StrayRows> {
        None
    }

    /// First and last wavelength, nm, of spectra that leave out a part of the visible range which colours depend on.
    fn partial_spectrum(&self) -> Option<[f64; 2]> {
        None
    }

    /// Lines for people: names and values.
    fn in_words(&self) -> Vec<(&'static str, String)> {
        let mut lines = self.lines();
        let directions = self.directions();
        if !directions.is_all() {
            lines.push(("directions", format!("{directions}; errors are of these")));
        }
        lines
    }
}
