//! Rows of a scan whose azimuth of incidence is ignored.

use super::words::percent;

/// Rows whose azimuth of incidence differs from the azimuth of the other rows, too few for a measurement of anisotropy:
/// the material is taken as isotropic.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct StrayRows {
    /// Number of such rows.
    pub rows: usize,
    /// Number of rows of the scan.
    pub of: usize,
    /// Line of the file at which the first of these rows starts; absent without a file.
    pub line: Option<u64>,
    /// Azimuth of incidence of the first of these rows, degrees.
    pub azimuth: f64,
    /// Mean difference from a fit to the other rows, as a fraction of the larger value.
    pub difference: f64,
}

impl StrayRows {
    /// Summary in one line.
    pub fn summary(&self) -> String {
        let Self { rows, of, azimuth, .. } = self;
        let (have, first) = if *rows == 1 { ("has", "") } else { ("have", "the first ") };
        let line = self.line.map_or(String::new(), |line| format!("on line {line}, "));
        let differ = if *rows == 1 { "this row differs" } else { "these rows differ" };
        let difference = percent(self.difference);
        format!(
            "{rows} of {of} rows {have} another azimuth of incidence ({first}{line}{azimuth:.1}°); the material is \
             taken as isotropic, although {differ} from the others by {difference}"
        )
    }
}
