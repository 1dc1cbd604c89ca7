//! `brdfc synth`: analytic models as files.

use super::CliError;
use super::output::write_file;
use crate::btf::structures::{Structure, describe_structures};
use crate::source::address::{self, AddressError};
use crate::source::simulate::{ScanPlan, merl_file, scan};
use brdfc_formats::measured::merl::{Dimensions, MAX_DIMENSION};
use brdfc_formats::measured::{scan as scan_text, scan_csv};
use brdfc_formats::meso::{obj, ply};
use clap::Args;
use std::path::{Path, PathBuf};

/// Write an analytic model as a measured file, or a structure as a mesh.
///
/// The extension says which: .binary is a MERL table, .brdf and .csv are scattered scans with seeded noise, gaps and
/// duplicates (.brdf with a spectrum of 31 bands that has the model's colour). .obj and .ply hold one tile of a structure, with its tints as
/// vertex colours.
#[derive(Debug, Args)]
#[command(after_help = models())]
pub struct Arguments {
    /// MODEL or STRUCTURE, or MODEL?param=value&...
    model: String,
    /// The file to write.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Samples of a MERL table along theta_h, theta_d and phi_d.
    #[arg(long, value_name = "HxDxP", default_value = "90x90x180")]
    dimensions: String,
    /// Rows of a scan.
    #[arg(long, default_value_t = 1440)]
    rows: usize,
    /// Incoming polar angles of a scan, between 10 and 80 degrees.
    #[arg(long, default_value_t = 8)]
    incidences: usize,
    /// Incoming azimuths of a scan; default 1 for isotropic models, 8 for others.
    #[arg(long)]
    azimuths: Option<usize>,
    /// Standard deviation of a scan's noise, a fraction of the value.
    #[arg(long, default_value_t = 0.0)]
    noise: f64,
    /// Fraction of the outgoing hemisphere that a scan does not see.
    #[arg(long, default_value_t = 0.0)]
    gaps: f64,
    /// Fraction of a scan's rows that repeat a direction pair.
    #[arg(long, default_value_t = 0.0)]
    duplicates: f64,
    /// Seed of noise, gaps and duplicates.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn models() -> String {
    format!(
        "Models:\n{}\nStructures (.obj, .ply):\n{}\nExamples:\n  brdfc synth lambert?kd=0.5 -o white.binary --dimensions 16x16x32\n  \
         brdfc synth 'ggx?kd=0.1,0.1,0.4&alpha=0.3' -o paint.brdf --noise 0.05 --gaps 0.1 --seed 7\n  \
         brdfc synth 'folds?resolution=64' -o folds.ply",
        address::describe_models(),
        describe_structures()
    )
}

const MOST_ROWS: usize = 10_000_000;
/// Most cells of a table that is written: 6 GiB of file.
const MOST_CELLS: usize = 1 << 28;

pub(super) fn run(arguments: &Arguments) -> Result<(), CliError> {
    let kind = arguments.output.extension().and_then(|e| e.to_str()).unwrap_or("");
    if ["obj", "ply"].contains(&kind) {
        return write_structure(arguments, kind);
    }
    let wrong = |error: AddressError| CliError::Input(format!("{}: {error}", arguments.model));
    let text = arguments.model.strip_prefix(address::SYNTH_PREFIX).unwrap_or(&arguments.model);
    let model = address::parse_model(text).map_err(wrong)?;
    let extension = arguments.output.extension().and_then(|e| e.to_str()).unwrap_or("");
    let mut bytes = Vec::new();
    match extension {
        "binary" => bytes = merl_file(model.as_ref(), dimensions(&arguments.dimensions)?),
        "brdf" | "csv" => {
            let isotropic = model.symmetry().isotropic;
            let rows = scan(model.as_ref(), &plan(arguments, if isotropic { 1 } else { 8 })?);
            let written = if extension == "csv" {
                scan_csv::write(&mut bytes, &rows)
            } else {
                scan_text::write(&mut bytes, &comment(arguments, &address::canonical(model.as_ref())), &rows)
            };
            written.expect("memory can be written to");
        }
        _ => {
            return Err(CliError::Usage(format!(
                "--output: found {}; allowed a name that ends in .binary, .brdf or .csv (models), .obj or .ply \
                 (structures)",
                Path::new(&arguments.output).display()
            )));
        }
    }
    write_file(&arguments.output, &bytes)
}

fn write_structure(arguments: &Arguments, kind: &str) -> Result<(), CliError> {
    let text = arguments.model.strip_prefix(address::SYNTH_PREFIX).unwrap_or(&arguments.model);
    let structure = Structure::parse(text).map_err(|error| CliError::Input(format!("{}: {error}", arguments.model)))?;
    let mesh = structure.mesh().to_triangle_mesh();
    let mut bytes = Vec::new();
    let written = if kind == "obj" { obj::write(&mut bytes, &mesh) } else { ply::write(&mut bytes, &mesh) };
    written.expect("memory can be written to");
    write_file(&arguments.output, &bytes)
}

fn comment(arguments: &Arguments, address: &str) -> String {
    format!(
        "simulated scan of {address}\nnoise {}, gaps {}, duplicates {}, seed {}",
        arguments.noise, arguments.gaps, arguments.duplicates, arguments.seed
    )
}

fn dimensions(text: &str) -> Result<Dimensions, CliError> {
    let wrong = || {
        CliError::Usage(format!(
            "--dimensions: found {text}; allowed three numbers from 1 to {MAX_DIMENSION}, such as 90x90x180, of at \
             most {MOST_CELLS} cells"
        ))
    };
    let parts: Vec<usize> = text.split('x').map(|p| p.parse().unwrap_or(0)).collect();
    let [theta_half, theta_difference, phi_difference] = parts[..] else { return Err(wrong()) };
    if parts.iter().any(|n| !(1..=MAX_DIMENSION).contains(n)) || parts.iter().product::<usize>() > MOST_CELLS {
        return Err(wrong());
    }
    Ok(Dimensions { theta_half, theta_difference, phi_difference })
}

fn plan(arguments: &Arguments, default_azimuths: usize) -> Result<ScanPlan, CliError> {
    let count = |name: &str, value: usize, most: usize| {
        if (1..=most).contains(&value) {
            return Ok(value);
        }
        Err(CliError::Usage(format!("--{name}: found {value}; allowed 1 to {most}")))
    };
    let fraction = |name: &str, value: f64, most: f64| {
        if (0.0..=most).contains(&value) {
            return Ok(value);
        }
        Err(CliError::Usage(format!("--{name}: found {value}; allowed 0 to {most}")))
    };
    Ok(ScanPlan {
        rows: count("rows", arguments.rows, MOST_ROWS)?,
        incidences: count("incidences", arguments.incidences, 1000)?,
        azimuths: count("azimuths", arguments.azimuths.unwrap_or(default_azimuths), 1000)?,
        noise: fraction("noise", arguments.noise, 2.0)?,
        gaps: fraction("gaps", arguments.gaps, 0.9)?,
        duplicates: fraction("duplicates", arguments.duplicates, 0.9)?,
        seed: arguments.seed,
    })
}
