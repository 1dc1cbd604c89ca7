//! `brdfc convert`: writes a source in a file format of other programs.

use super::options::{by_flags, failed};
use super::output::{
    json_or, note, note_gaps, output_parser, print_report, refuse_flags, refuse_unfit_output, write_file,
};
use super::reading::{ReadingOptions, open_read};
use super::synth::dimensions;
use super::{Common, Error};
use crate::table;
use brdfc::compare::Comparison;
use brdfc::convert::{ConvertError, PairGrid, Target, convert};
use brdfc::encode::{ErrorLimits, GateResult, check_output, check_report, fit_error};
use brdfc::relight::PTM;
use brdfc::{Budget, Facts, FitLimits, Fraction, Input};
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
    /// Maximum mean ΔE between renderings of the file and of the input; 95 % have to be below four times this. If the file
    /// misses a limit, the program writes it, and exits with code 1.
    #[arg(long, value_name = "E")]
    max_delta_e: Option<f64>,
    /// Maximum mean relative error ε_r: a fraction or a percentage, 0.05 or 5%.
    #[arg(long, value_name = "E")]
    max_error: Option<Fraction>,
    /// Scans: maximum error of the fit to the samples, estimated from held-out samples: a fraction or a percentage.
    #[arg(long, value_name = "E")]
    max_fit_error: Option<Fraction>,
    /// Scans: count the error against the fit to a scan as the error against the material.
    #[arg(long)]
    trust_fit: bool,
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
    /// Cause of a visible error.
    loss: Option<String>,
    /// Results of the checks of limits, if any were requested.
    gates: Vec<GateResult>,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let output: &Path = &arguments.output;
    let is_map = output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(PTM));
    refuse_unfit_output(output, &["binary", "bsdf", "csv"], arguments.input.path().as_slice()).map_err(|error| {
        let text = format!("{error}; 'brdfc pwt' writes .ptm");
        if is_map { error.with_message(text) } else { error }
    })?;
    let (kind, target) = target(arguments)?;
    let limits = Budget::checked(arguments.max_delta_e, None, arguments.max_error, None, None).map_err(by_flags)?;
    let limits = ErrorLimits::from(&limits);
    let checked =
        |limit: Fraction| limit.checked().map_err(|allowed| Error::wrong_usage("--max-fit-error", limit, allowed));
    let of_fit = FitLimits { error: arguments.max_fit_error.map(checked).transpose()?, trusted: arguments.trust_fit };
    let material = open_read(&arguments.input, arguments.reading)?;
    note_gaps(common, &arguments.input, material.source());
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
    let mut gates = check_output(limits, &comparison);
    if limits != ErrorLimits::default() || of_fit.error.is_some() {
        let fit = fit_error(material.source(), material.source().directions(), &())?;
        let of_source = check_report(of_fit, limits, fit, &comparison);
        // A black material fails both.
        let is_new = |result: &GateResult| gates.iter().all(|other| other.gate != result.gate);
        let of_source: Vec<GateResult> = of_source.into_iter().filter(is_new).collect();
        gates.extend(of_source);
    }
    if let Some(loss) = &converted.loss {
        note(common, &arguments.input, loss);
    }
    let missed = failed(&gates).map(|missed| Error::check(missed).prefixed(&arguments.input));
    let wrote = format!("{values} values, {}\n", table::bytes(bytes_on_disk as u64));
    let text = wrote + &table::comparison(&comparison, material.source().directions());
    let (source, loss) = (material.facts().clone(), converted.loss);
    let report = Report { version: 2, kind, source, values, bytes_on_disk, comparison, loss, gates };
    print_report(common, output, &json_or(common, &report, text))?;
    missed.map_or(Ok(()), Err)
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
