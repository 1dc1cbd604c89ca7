//! `brdfc bench`: studies that repeat the papers' tables.

#[cfg(feature = "render")]
mod adaptive;
mod arguments;
mod flat_btf;
#[cfg(feature = "render")]
mod on_adapter;
mod rays;
mod studies;

pub use arguments::Arguments;
pub use studies::Report;

use super::output::{check_folder, print, print_json};
use super::{CliError, Common};
use crate::table::{percent, plain};
use brdfc_studies::{StudyRow, wavelet_table_1};
use clap::ValueEnum;
use studies::{Study, StudyResult};

/// Studies of adaptive shading.
const ADAPTIVE: &[Study] = &[Study::Adaptive, Study::PixelBandwidth, Study::BandwidthDirections, Study::Antialiasing];

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    if arguments.study == Study::WaveletBrdf && !arguments.inputs.is_empty() {
        let text = "INPUT: found with --study wavelet-brdf; allowed with the studies that draw (throughput, \
                    level-of-detail and images: materials), and with flat-btf and rays (structures)";
        return Err(CliError::Usage(text.into()));
    }
    if !matches!(arguments.study, Study::LevelOfDetail | Study::Rays) && arguments.out.is_some() {
        let allowed = "allowed with --study level-of-detail and --study rays";
        return Err(CliError::Usage(format!("--out: found with another study; {allowed}")));
    }
    for (given, option, studies) in [
        (arguments.texels.is_some(), "texels", &[Study::FlatBtf, Study::Rays][..]),
        (arguments.flat_texels.is_some(), "flat-texels", &[Study::FlatBtf]),
        (arguments.directions.is_some(), "directions", &[Study::FlatBtf]),
        (arguments.environment.is_some(), "environment", ADAPTIVE),
        (arguments.pixels.is_some(), "pixels", ADAPTIVE),
        (arguments.truth.is_some(), "truth", ADAPTIVE),
        (arguments.adapter.is_some(), "adapter", &[Study::Throughput, Study::LevelOfDetail, Study::Images]),
    ] {
        if given && !studies.contains(&arguments.study) {
            let names: Vec<String> =
                studies.iter().filter_map(|s| Some(s.to_possible_value()?.get_name().to_owned())).collect();
            let allowed = names.join(", ");
            return Err(CliError::Usage(format!(
                "--{option}: found with another study; allowed with --study {allowed}"
            )));
        }
    }
    if let Some(folder) = &arguments.out {
        check_folder(folder)?;
    }
    let result = match arguments.study {
        Study::WaveletBrdf => {
            let rows = wavelet_table_1().map_err(|error| CliError::Internal(error.to_string()))?;
            StudyResult::WaveletBrdf { rows }
        }
        Study::FlatBtf => flat_btf::run(arguments, common)?,
        Study::Rays => rays::run(arguments, common)?,
        #[cfg(feature = "render")]
        study if ADAPTIVE.contains(&study) => adaptive::run(arguments, common)?,
        #[cfg(feature = "render")]
        _ => on_adapter::run(arguments, common)?,
        #[cfg(not(feature = "render"))]
        _ => return Err(CliError::without_renderer()),
    };
    if arguments.json {
        return print_json(&Report { version: 1, result });
    }
    match &result {
        StudyResult::WaveletBrdf { rows } => print(&table_1(rows)),
        StudyResult::FlatBtf { settings, rows } => print(&flat_btf::text(settings, rows)),
        StudyResult::Rays(study) => print(&rays::text(study)),
        #[cfg(feature = "render")]
        StudyResult::Adaptive { rows } => print(&adaptive::equal_error_text(rows)),
        #[cfg(feature = "render")]
        StudyResult::PixelBandwidth { rows } => print(&adaptive::fourier_text(rows)),
        #[cfg(feature = "render")]
        StudyResult::BandwidthDirections { rows } => print(&adaptive::directions_text(rows)),
        #[cfg(feature = "render")]
        StudyResult::Antialiasing { rows } => print(&adaptive::antialiasing_text(rows)),
        #[cfg(feature = "render")]
        other => print(&on_adapter::text(other)),
    }
}

fn table_1(rows: &[StudyRow]) -> String {
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
    plain(&header, &cells)
        + "\n32 x 32 x 32 x 32 tangent-pole table, one channel, bias 0.01; ε and ε_r at 16 bits unless said otherwise.\n\
           The paper does not print its parameters: its figures show the magnitude to expect, not the same materials.\n"
}
