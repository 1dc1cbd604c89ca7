//! `brdfc bench`: studies that repeat the papers' tables.

#[cfg(feature = "render")]
mod adaptive;
#[cfg(feature = "render")]
mod drawn;
mod flat_btf;
mod rays;

use super::output::{check_folder, print, print_json};
use super::{CliError, Common};
use crate::table::{percent, plain};
use brdfc_studies::{StudyRow, wavelet_table_1};
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::PathBuf;

/// Repeat a study of the papers, with the paper's own figures beside ours.
///
/// Timings of single stages are criterion benchmarks: 'cargo bench'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc bench
  brdfc bench --json > table-1.json
  brdfc bench --study flat-btf synth:knit --texels 64 --flat-texels 128
  brdfc bench --study rays synth:folds
  brdfc bench --study throughput
  brdfc bench --study level-of-detail --out frames
  brdfc bench --study images paint.brdf metal.bsdf synth:velvet
  brdfc bench --study adaptive red-plastic.binary paint.bsdf --environment museum.exr
  brdfc bench --study pixel-bandwidth red-plastic.binary --environment museum.exr")]
pub struct Arguments {
    /// Materials of the studies that draw (default: synth:velvet, and a glossy metal for level-of-detail and those of
    /// adaptive shading), or structures of flat-btf (default: all four) and of rays (default: synth:button).
    #[arg(value_name = "INPUT")]
    inputs: Vec<String>,
    /// Which study.
    #[arg(long, value_enum, default_value = "wavelet-brdf")]
    study: Study,
    /// Write the frames of level-of-detail into this folder, or the mesh and the rays of rays.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Texels of the reference plane per side, for flat-btf (default 128) and rays (default 64).
    #[arg(long, value_name = "N")]
    texels: Option<usize>,
    /// Texels of flat BTFs per side for flat-btf, a power of two (default: twice those of the plane).
    #[arg(long, value_name = "N")]
    flat_texels: Option<usize>,
    /// Views and lights of flat-btf, as for 'brdfc flatten --views' (default: ubo2003).
    #[arg(long, value_name = "SET")]
    directions: Option<String>,
    /// Latitude-longitude image, .exr or .hdr, that lights the studies of adaptive shading (default: a sky).
    #[arg(long, value_name = "FILE")]
    environment: Option<String>,
    /// Pixels per side of the studies of adaptive shading, 32 to 2048, for pixel-bandwidth 64 and more (default 512).
    #[arg(long, value_name = "N")]
    pixels: Option<usize>,
    /// Samples per pixel of their ground truth, 16 to 65536 (default 256).
    #[arg(long, value_name = "N")]
    truth: Option<usize>,
    /// Use the adapter whose name contains this (default: the fastest).
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Print JSON (schema: 'brdfc schema bench').
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Study {
    /// Table 1 of Claustres et al. 2007: errors of Lewis, Ward and Poulin-Fournier at 4:1, 16:1 and 32:1.
    WaveletBrdf,
    /// Section 4 of Hadim et al. 2009: reconstruction, coherency, sizes and interpolation of flat BTFs. Takes minutes for
    /// each of synth:button, folds, knit and sponge, which are the default.
    FlatBtf,
    /// Rays per second against a repeated structure. With --out: mesh.ply and rays.bin for other programs.
    Rays,
    /// Section 6.3: evaluations per second, shader and CPU decoder.
    Throughput,
    /// Section 6.3, figure 10: a terrain with and without levels of detail, time per level, flicker.
    LevelOfDetail,
    /// Section 6.3, figure 9: colour differences on a cloth, shader against source, 4:1 and 8 bits.
    Images,
    /// Section 5 of Bagher et al. 2012: samples that adaptive and forward shading need for the same error, of every
    /// material on two shapes, on the CPU. Minutes for each material.
    Adaptive,
    /// Figure 12 of Bagher et al. 2012: predicted pixel bandwidth against windowed Fourier transforms, on a sphere.
    PixelBandwidth,
    /// Figure 13 of Bagher et al. 2012: error with bandwidth averaged over 16 to 1024 directions.
    BandwidthDirections,
    /// Figure 10 of Bagher et al. 2012: cost of adaptive shading with 1, 4 and 16 points per pixel.
    Antialiasing,
}

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// The study's figures.
    #[serde(flatten)]
    result: StudyResult,
}

/// Figures of a study.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[serde(tag = "study", rename_all = "kebab-case")]
pub enum StudyResult {
    /// Table 1.
    WaveletBrdf {
        /// Rows of the table.
        rows: Vec<StudyRow>,
    },
    /// Tables 1, 2 and 3 and figure 10 of Hadim et al. 2009.
    FlatBtf {
        /// What was computed.
        settings: brdfc_studies::flat_btf::StudySettings,
        /// One for each model.
        rows: Vec<brdfc_studies::flat_btf::ModelRow>,
    },
    /// Rays per second.
    Rays(brdfc_studies::rays::RayStudy),
    /// Evaluations per second.
    #[cfg(feature = "render")]
    Throughput(brdfc_studies::throughput::Throughput),
    /// The terrain.
    #[cfg(feature = "render")]
    LevelOfDetail(brdfc_studies::level_of_detail::LevelOfDetail),
    /// Colour differences on the cloth.
    #[cfg(feature = "render")]
    Images {
        /// One for each material.
        rows: Vec<brdfc_studies::images::ImageRow>,
    },
    /// Adaptive and forward shading at equal error.
    #[cfg(feature = "render")]
    Adaptive {
        /// One for each material, shape and error.
        rows: Vec<brdfc_studies::adaptive::EqualErrorRow>,
    },
    /// Predicted bandwidth against Fourier transforms.
    #[cfg(feature = "render")]
    PixelBandwidth {
        /// One for each material.
        rows: Vec<brdfc_studies::adaptive::FourierRow>,
    },
    /// Numbers of incident directions.
    #[cfg(feature = "render")]
    BandwidthDirections {
        /// One for each material.
        rows: Vec<adaptive::DirectionsStudy>,
    },
    /// Points per pixel.
    #[cfg(feature = "render")]
    Antialiasing {
        /// One for each material and shape.
        rows: Vec<adaptive::AntialiasingStudy>,
    },
}

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
        _ => drawn::run(arguments, common)?,
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
        drawn => print(&drawn::text(drawn)),
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
