//! Flags that determine how a scan is read.

use super::Error;
use brdfc::inspect::is_scan;
use brdfc::{Input, Material, Reading, open_with};
use clap::Args;

/// Settings of reading scans.
#[derive(Debug, Clone, Copy, Args)]
pub struct ReadingOptions {
    /// Scans: number of neighbours of a fit, 1 to the number of distinct direction pairs (default: chosen by left-out rows,
    /// which 'brdfc info' prints).
    #[arg(long, value_name = "N")]
    neighbours: Option<usize>,
}

impl ReadingOptions {
    /// Opens a material.
    pub fn open(self, input: &Input) -> Result<Material, Error> {
        open_with(input, self.reading(None, &[input])?)
    }

    /// Settings of reading inputs, with a level of detail of packs. Rejects flags without effect, if none of the inputs is
    /// a scan.
    pub fn reading(self, level: Option<f32>, inputs: &[&Input]) -> Result<Reading, Error> {
        let Some(neighbours) = self.neighbours else { return Ok(level.into()) };
        if neighbours == 0 {
            let expected = "1 to the number of distinct direction pairs of the scan";
            return Err(Error::wrong_usage("--neighbours", neighbours, expected));
        }
        for input in inputs {
            if is_scan(input)? {
                return Ok(Reading { level, neighbours: Some(neighbours) });
            }
        }
        let inputs: Vec<String> = inputs.iter().map(|input| input.short_name()).collect();
        Err(Error::usage(format!("--neighbours does not apply to {}, only to scans", inputs.join(" and "))))
    }
}
