//! `brdfc encode`: encodes one material as a pack.

use super::encode_lobes;
use super::options::{PackOptions, by_flags};
use super::output::{json_or, note, output_parser, print_report, refuse_unfit_output};
use super::progress::{Materials, label};
use super::reading::{ReadingOptions, open_read};
use super::{Common, Error};
use crate::table;
use brdfc::encode::{GateResult, OptionError, StageClock, StageTime, codecs, remarks};
use brdfc::inspect::Kind;
use brdfc::lobes::CODEC;
use brdfc::scene::near_miss;
use brdfc::{Facts, Input, MaterialReport, Progress as _, Stage};
use brdfc_terminal::words::one_of;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Encode one material as a pack for GPUs.
///
/// Without options, the result is the smallest pack, among sizes in doublings, whose renderings look like those of its
/// source: a mean ΔE of 0.5, a 95th percentile below 2, and 90 % of the highlight's light. Prints every candidate, and the
/// bytes, fetches and errors of the selected pack, which also contains its errors.
///
/// With --codec lobes, the result is for light from environments instead of lights: the fewest look-ups in a prefiltered
/// environment, see 'brdfc environment', with a mean ΔE of at most 1 (up to 16 look-ups; --max-delta-e and --max-fetches set
/// other limits). The schema of its --json is 'encode-lobes'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc encode red-plastic.binary -o red.ktx2
  brdfc encode paint.brdf -o paint.ktx2 --max-delta-e 0.3 --max-bytes 65536
  brdfc encode paint.brdf -o paint.ktx2 --codec table --max-bytes 4096
  brdfc encode 'synth:ggx?alpha=0.2' -o ggx.ktx2 --codec wavelet --ratio 16 --json
  brdfc encode paint.brdf -o paint.lobes.ktx2 --codec lobes
  brdfc encode - -o - < paint.brdf > paint.ktx2")]
pub struct Arguments {
    /// A path, - for stdin, or synth:MODEL?param=value&...
    pub(super) input: Input,
    /// The pack to write, or - for stdout.
    #[arg(long, short, value_name = "PACK.ktx2", value_parser = output_parser())]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) options: PackOptions,
    #[command(flatten)]
    pub(super) reading: ReadingOptions,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// The input.
    input: Facts,
    /// The pack and its measured errors.
    #[serde(flatten)]
    report: MaterialReport,
    /// Results of the checks of the fit to a scan, if any were requested.
    gates: Vec<GateResult>,
    /// Seconds per stage.
    stages: Vec<StageTime>,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    refuse_unfit_output(&arguments.output, &["ktx2"], arguments.input.path().as_slice())?;
    if let Some(options) = arguments.options.of_lobes() {
        return encode_lobes::run(arguments, options, common);
    }
    let request = arguments.options.request().map_err(|error| by_flags(with_lobes(error)))?;
    // An interrupt ends the process at once: the single output file is either complete or absent.
    let progress = Materials::new(1, false, common);
    let name = label(&arguments.output);
    let part = progress.part(&name);
    let clock = StageClock::new(part.as_ref());
    clock.stage(Stage::Read, 1)?;
    let named = |error: Error| by_flags(error).prefixed(&arguments.input);
    let material =
        open_read(&arguments.input, arguments.reading).map_err(|error| of_folder(&arguments.input, error))?;
    let pack = material.encode_closest(request, &clock).map_err(named)?;
    clock.stage(Stage::Write, 1)?;
    pack.write(&arguments.output)?;
    let stages = clock.finish();
    drop(part);
    drop(progress);
    let report = pack.report().clone();
    let of_trials: Vec<f64> =
        stages.iter().filter(|stage| stage.stage == Stage::Try.name()).map(|stage| stage.seconds).collect();
    let missed = pack.missed_error().map(named);
    for line in remarks(&report) {
        note(common, &arguments.input, &line);
    }
    let mut row = vec![arguments.output.display().to_string()];
    row.extend(table::material_row(&report, Some(stages.iter().map(|s| s.seconds).sum())));
    let mut header = table::MATERIAL_HEADER;
    header[0] = "pack";
    let mut text = table::plain(&header, &[row]);
    if !report.tried.is_empty() {
        text = format!("{}\n{text}", table::trials(&report.tried, &of_trials));
    }
    let report = Report { version: 2, input: material.facts().clone(), report, gates: pack.gates().to_vec(), stages };
    print_report(common, &arguments.output, &json_or(common, &report, text))?;
    missed.map_or(Ok(()), Err)
}

/// Adds lobes, which only this command makes, to the codecs in the error of an unknown one.
fn with_lobes(error: OptionError) -> OptionError {
    if error.field != "codec" || error.found.is_empty() {
        return error;
    }
    let known: Vec<&str> = codecs().chain([CODEC]).collect();
    let meant = near_miss(error.found.trim_matches('"'), &known)
        .map_or(String::new(), |name| format!("; did you mean {name}?"));
    OptionError::new("codec", error.found, format!("{}{meant}", one_of(&known)))
}

/// Names the command for folders in the error of a folder.
fn of_folder(input: &Input, error: Error) -> Error {
    let text = format!("{error}; use 'brdfc build' for a folder");
    if matches!(Kind::of(input), Ok(Kind::Folder)) { error.with_message(text) } else { error }
}
