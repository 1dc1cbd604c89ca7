//! `brdfc convert`: writes a source in a file format of other programs.

use super::output::{json_or, output_parser, print_report, refuse_flags, refuse_unfit_output, write_file};
use super::reading::{ReadingOptions, open_read};
use super::synth::dimensions;
use super::{Common, Error};
use crate::table;
use brdfc::compare::Comparison;
use brdfc::convert::{ConvertError, PairGrid, Target, convert};
use brdfc::relight::PTM;
use brdfc::{Facts, Input};
use brdfc_terminal::words::quoted;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Convert a material or a pack to a file format of other programs, and measure the error.
///
/// The extension selects the format. .binary is a MERL table for isotropic materials; most readers expect 90 x 90 x 180
/// values. .bsdf is a material of the RGL database in RGB, which Mitsuba's 'measured' reads. .csv is a list of
/// direction pairs with values. The program reads the written file back and compares it with the input at the pairs at
/// which packs are measured.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc convert paint.brdf -o paint.binary
  brdfc convert brushed.ktx2 -o brushed.bsdf
  brdfc convert red.ktx2 -o red.csv --grid 16x24x72
  brdfc convert synth:lewis -o small.binary --dimensions 45x45x90 --json")]
pub struct Arguments {
    /// A material or a pack: a path, - for stdin, or synth:MODEL?param=value&...
    input: Input,
    /// The file to write: .binary, .bsdf or .csv, or - for a MERL table on stdout.
    #[arg(long, short, value_name = "FILE", value_parser = output_parser())]
    output: PathBuf,
    /// Samples of a MERL table along theta_h, theta_d and phi_d, each 1 to 4096 (default: 90x90x180).
    #[arg(long, value_name = "HxDxP", allow_hyphen_values = true)]
    dimensions: Option<String>,
    /// Incoming polar angles, outgoing polar angles and outgoing azimuths of a list, each 2 to 1000 (default:
    /// 12x24x48). Polar angles range from 0 to 85 degrees. Isotropic materials have 1 incoming azimuth, others 8.
    #[arg(long, value_name = "IxOxA", allow_hyphen_values = true)]
    grid: Option<String>,
    #[command(flatten)]
    reading: ReadingOptions,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'merl', 'rgl' or 'csv'.
    kind: &'static str,
    /// The input.
    source: Facts,
    /// Values in the file: cells of a table above the horizon, or rows of a list.
    values: usize,
    /// Bytes of the file.
    bytes_on_disk: usize,
    /// Comparison of the file with the input.
    #[serde(flatten)]
    comparison: Comparison,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let output: &Path = &arguments.output;
    let is_map = output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(PTM));
    refuse_unfit_output(output, &["binary", "bsdf", "csv"], arguments.input.path().as_slice()).map_err(|error| {
        let text = format!("{error}; 'brdfc pwt' writes .ptm");
        if is_map { error.with_message(text) } else { error }
    })?;
    let (kind, target) = target(arguments)?;
    let material = open_read(&arguments.input, arguments.reading)?;
    let converted = convert(material.source(), target).map_err(|error| match error {
        ConvertError::Anisotropic => Error::input(format!("{}: {error}", arguments.input)),
        ConvertError::Format(error) => match [("grid", &arguments.grid), ("dimensions", &arguments.dimensions)] {
            [(flag, Some(size)), _] | [_, (flag, Some(size))] => {
                Error::usage(format!("--{flag}: found {size}, which gives {}, expected {}", error.found, error.allowed))
            }
            _ => ConvertError::from(error).into(),
        },
    })?;
    write_file(output, &converted.bytes)?;
    let (values, bytes_on_disk, comparison) = (converted.values, converted.bytes.len(), converted.comparison);
    let wrote = format!("{values} values, {}\n", table::bytes(bytes_on_disk as u64));
    let text = wrote + &table::comparison(&comparison, material.source().directions());
    let report = Report { version: 1, kind, source: material.facts().clone(), values, bytes_on_disk, comparison };
    print_report(common, output, &json_or(common, &report, text))
}

/// Selects the target format by the extension of the output.
fn target(arguments: &Arguments) -> Result<(&'static str, Target), Error> {
    let is = |name: &str| arguments.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(name));
    let flags = [
        (arguments.dimensions.is_some() && !is("binary"), "--dimensions", ".binary files"),
        (arguments.grid.is_some() && !is("csv"), "--grid", ".csv files"),
    ];
    refuse_flags(arguments.output.display(), &flags)?;
    if is("csv") {
        return Ok(("csv", Target::Csv(pair_grid(arguments.grid.as_deref().unwrap_or("12x24x48"))?)));
    }
    if is("bsdf") {
        return Ok(("rgl", Target::Rgl));
    }
    Ok(("merl", Target::Merl(dimensions(arguments.dimensions.as_deref().unwrap_or("90x90x180"))?)))
}

/// Maximum of each number of `--grid`.
const MAX: usize = 1000;
/// Maximum number of rows of an anisotropic list.
const MAX_ROWS: usize = 10_000_000;

fn pair_grid(text: &str) -> Result<PairGrid, Error> {
    let parts: Vec<usize> = text.split('x').map(|part| part.parse().unwrap_or(0)).collect();
    match parts[..] {
        [incoming, outgoing, azimuths]
            if parts.iter().all(|part| (2..=MAX).contains(part)) && 8 * incoming * outgoing * azimuths <= MAX_ROWS =>
        {
            Ok(PairGrid { incoming, outgoing, azimuths })
        }
        _ => Err(Error::usage(format!(
            "--grid: found {}, expected three numbers from 2 to {MAX}, such as 12x24x48, of at most {} pairs",
            quoted(text),
            MAX_ROWS / 8
        ))),
    }
}
