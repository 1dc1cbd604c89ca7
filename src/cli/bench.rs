//! `brdfc bench`: studies that repeat the papers' tables.

use super::output::{print, print_json};
use super::{CliError, Common};
use crate::report::study::{StudyRow, wavelet_table_1};
use crate::report::table::{percent, plain};
use clap::{Args, ValueEnum};
use serde::Serialize;

/// Repeat an error study of the papers, with the paper's own figures beside ours.
///
/// Timings of single stages are criterion benchmarks: 'cargo bench'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc bench
  brdfc bench --json > table-1.json")]
pub struct Arguments {
    /// Which study.
    #[arg(long, value_enum, default_value = "wavelet-brdf")]
    study: Study,
    /// Print JSON (schema: 'brdfc schema bench').
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Study {
    /// Table 1 of Claustres et al. 2007: errors of Lewis, Ward and Poulin-Fournier at 4:1, 16:1 and 32:1.
    WaveletBrdf,
}

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Rows of the table.
    rows: Vec<StudyRow>,
}

pub(super) fn run(arguments: &Arguments, _: Common) -> Result<(), CliError> {
    let Study::WaveletBrdf = arguments.study;
    let rows = wavelet_table_1().map_err(|error| CliError::Internal(error.to_string()))?;
    if arguments.json {
        return print_json(&Report { version: 1, rows });
    }
    let header = ["model", "r_c", "slices", "mean", "ε", "ε_r", "ε_r, 8 bits", "paper mean", "paper ε", "paper ε_r"];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                row.model.clone(),
                format!("{}:1", row.ratio),
                row.slices.to_string(),
                format!("{:.6}", row.mean),
                format!("{:.4e}", row.rms),
                percent(row.relative),
                percent(row.relative_8_bit),
                row.paper_mean.to_string(),
                row.paper_rms.to_string(),
                percent(row.paper_relative),
            ]
        })
        .collect();
    print(&plain(&header, &cells))?;
    print(
        "\n32 x 32 x 32 x 32 tangent-pole table, one channel, bias 0.01; ε and ε_r at 16 bits unless said otherwise.\n\
         The paper does not print its parameters: its figures show the magnitude to expect, not the same materials.\n",
    )
}
