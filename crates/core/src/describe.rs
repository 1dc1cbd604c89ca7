//! Facts about an input, as `brdfc info` prints them.

use super::StrayRows;
use brdfc_formats::crop::DirectionRange;
use std::array::from_fn;

/// Samples with the smallest value of each channel. If they are many, it may be a detector's limit or a mark of missing samples.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Darkest {
    /// The smallest values, 1/sr.
    pub value: [f64; 3],
    /// Number of samples.
    pub samples: u64,
}

impl Darkest {
    /// Counts the darkest of samples, which are 0 or more, or NaN if not measured; `None` if all have the same value above 0.
    pub fn of(samples: impl Iterator<Item = [f64; 3]> + Clone) -> Option<Self> {
        let (mut value, mut largest) = ([f64::INFINITY; 3], [0.0; 3]);
        for sample in samples.clone() {
            value = from_fn(|channel| sample[channel].min(value[channel]));
            largest = from_fn(|channel| sample[channel].max(largest[channel]));
        }
        let count = || samples.filter(|sample| *sample == value).count() as u64;
        (value != largest || value == [0.0; 3]).then(|| Self { value, samples: count() })
    }
}

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

    /// The darkest samples; `None` for models, and if all samples have the same value above 0.
    fn darkest(&self) -> Option<Darkest> {
        None
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
