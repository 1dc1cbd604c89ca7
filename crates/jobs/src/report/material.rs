//! The report of one encoded material.

use brdfc_formats::direction::Parameterisation;
use brdfc_metrics::compare::Comparison;
use brdfc_source::Tally;
use brdfc_wavelet::encode::Encoded;
use brdfc_wavelet::measure::GridError;
use brdfc_wavelet::recipe::Recipe;
use serde::{Deserialize, Serialize};

/// One material, encoded. The same input, options and version give the same report: times stand apart in
/// [`StageTime`]s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MaterialReport {
    /// Measured samples in the input; 0 for analytic models.
    pub samples_in: u64,
    /// Samples of the table that were evaluated; symmetry gives the others.
    pub evaluated: u64,
    /// What the two hemispheres of the table are.
    pub parameterisation: Parameterisation,
    /// Cells per axis and hemisphere.
    pub grid: usize,
    /// Finest level of detail that is stored.
    pub stored_levels: u32,
    /// Colour channels, 1 or 3.
    pub channels: u32,
    /// Bits per component.
    pub bits: u32,
    /// Whether the table was smoothed.
    pub smoothed: bool,
    /// Slices kept, the zero slice not counted.
    pub slices_kept: usize,
    /// Wavelet coefficients, of which a slice each would be kept at 1:1.
    pub slices_in_all: usize,
    /// `slices_in_all / slices_kept`.
    pub ratio: f64,
    /// Bytes of the pack's file.
    pub bytes_on_disk: u64,
    /// Bytes of texture and index map on a GPU.
    pub bytes_on_gpu: u64,
    /// `μ`, 1/sr.
    pub mean: f64,
    /// Codec error: decoded table against table.
    pub on_grid: GridError,
    /// What a user sees: filtered pack against source.
    pub off_grid: Comparison,
    /// What had to be mended while the table was made.
    #[serde(rename = "mended")]
    pub repairs: Tally,
}

impl MaterialReport {
    /// The report of a pack.
    pub fn new(encoded: &Encoded, recipe: &Recipe, samples_in: u64) -> Self {
        let header = &encoded.pack.header;
        let slices_kept = encoded.pack.slices() - 1;
        Self {
            samples_in,
            evaluated: encoded.evaluated,
            parameterisation: header.parameterisation,
            grid: header.grid(),
            stored_levels: header.stored_levels,
            channels: header.channels,
            bits: header.bits,
            smoothed: recipe.smooth,
            slices_kept,
            slices_in_all: header.cells(),
            ratio: header.cells() as f64 / slices_kept as f64,
            bytes_on_disk: encoded.bytes.len() as u64,
            bytes_on_gpu: encoded.pack.gpu_bytes(),
            mean: f64::from(header.mean),
            on_grid: encoded.on_grid,
            off_grid: encoded.off_grid.clone(),
            repairs: encoded.tally,
        }
    }
}

/// Wall-clock time of one stage.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct StageTime {
    /// The stage's name.
    pub stage: String,
    /// Seconds.
    pub seconds: f64,
}

/// Lines that say in words what a reader of the table should know; empty for a clean source.
pub fn remarks(report: &MaterialReport) -> Vec<String> {
    let mut lines = repairs_in_words(&report.repairs);
    for (norms, place) in [(&report.on_grid.norms, "on"), (&report.off_grid.norms, "off")] {
        if 2 * norms.below_floor > norms.samples {
            let share = 100.0 * norms.below_floor as f64 / norms.samples as f64;
            lines.push(format!(
                "{share:.1} % of the samples {place} the grid lie below 0.1 % of the mean: ε_r {place} the grid leaves them out"
            ));
        }
    }
    lines
}

/// Lines that say in words what had to be mended; empty for a clean source.
pub fn repairs_in_words(tally: &Tally) -> Vec<String> {
    let share = |count: u64| format!("{:.1} %", 100.0 * count as f64 / tally.evaluations.max(1) as f64);
    [
        (tally.partly_invalid, "interpolations left out invalid cells"),
        (tally.nearest_valid, "interpolations had no valid cell and took the nearest"),
        (tally.fell_to_linear, "local fits fell back to linear degree"),
        (tally.fell_to_constant, "local fits fell back to a weighted mean"),
        (tally.clamped_to_neighbours, "local fits were clamped to the range of their neighbours"),
        (tally.negative_raised, "negative values were raised to 0"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} of {} ({}) {what}", tally.evaluations, share(count)))
    .collect()
}
