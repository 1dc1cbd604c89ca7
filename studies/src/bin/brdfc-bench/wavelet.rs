//! The study of wavelet BRDFs.

use brdfc_studies::{StudyResult, StudyRow, wavelet_table_1};
use brdfc_terminal::Error;
use brdfc_terminal::table::{percent, plain};

pub(super) fn run() -> Result<StudyResult, Error> {
    let rows = wavelet_table_1().map_err(|error| Error::internal(error.to_string()))?;
    Ok(StudyResult::WaveletBrdf { rows })
}

pub(super) fn text(rows: &[StudyRow]) -> String {
    let header =
        ["model", "bias", "r_c", "slices", "mean", "ε", "ε_r", "ε_r, 8 bits", "paper mean", "paper ε", "paper ε_r"];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                row.model.clone(),
                row.bias.to_string(),
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
    plain(&header, &cells)
        + "\n32 x 32 x 32 x 32 tangent-pole table, one channel; ε and ε_r at 16 bits unless said otherwise.\n\
           The paper does not print parameters and biases. Ours are matched to its means and errors.\n"
}
