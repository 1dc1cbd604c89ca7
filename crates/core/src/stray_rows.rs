//! Rows of a scan that are taken otherwise than they say.

use super::words::percent;

/// Rows of another azimuth of incidence than the others of their scan, too few to be a measurement of anisotropy: they are
/// taken as those of an isotropic material.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct StrayRows {
    /// How many.
    pub rows: usize,
    /// Rows of the scan.
    pub of: usize,
    /// Line of the file that the first starts at, where there is a file.
    pub line: Option<u64>,
    /// Azimuth of incidence of the first, degrees.
    pub azimuth: f64,
    /// Mean difference to what is fitted to the other rows, as a fraction of the larger value.
    pub difference: f64,
}

impl StrayRows {
    /// A line for people.
    pub fn in_words(&self) -> String {
        let Self { rows, of, azimuth, .. } = self;
        let (have, first) = if *rows == 1 { ("has", "") } else { ("have", "the first ") };
        let line = self.line.map_or(String::new(), |line| format!("on line {line}, "));
        let differ = if *rows == 1 { "it differs from the others" } else { "they differ from the others" };
        let difference = percent(self.difference);
        format!(
            "{rows} of {of} rows {have} another azimuth of incidence ({first}{line}{azimuth:.1}°), taken as isotropic; \
             {differ} by {difference}"
        )
    }
}
