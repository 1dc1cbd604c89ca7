//! `brdfc samples`: importance samples of a material's lobes, as a pack.

use super::info::{importance_lines, lines_of};
use super::output::{
    json_or, note_coverage, note_repairs, output_parser, print_report, refuse_unfit_output, write_file,
};
use super::reading::{ReadingOptions, open_read};
use super::{Common, Error};
use crate::table;
use brdfc::samples::{HalfGrid, ImportanceFacts, ImportanceRecipe, draw};
use brdfc::{FormatError, Fraction, Input, Tally};
use brdfc_terminal::values::any_whole_number;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Precompute importance samples of a material's lobes, for rendering with few samples.
///
/// For each outgoing direction, the pack contains half vectors drawn in proportion to reflectance times cosine, each
/// with its density. A renderer may take any number of them, from any position in the list;
/// formats/src/importance/spec.md describes the layout.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc samples red-plastic.binary -o red.samples.ktx2
  brdfc samples 'synth:ward?ax=0.1&ay=0.4' -o brushed.samples.ktx2 --polar 32 --azimuths 24
  brdfc samples chrome.binary -o chrome.samples.ktx2 --count 4096 --rings 512 --json")]
pub struct Arguments {
    /// A material: a path, - for stdin, or synth:MODEL?param=value&...
    input: Input,
    /// The pack to write, or - for stdout.
    #[arg(long, short, value_name = "SAMPLES.ktx2", value_parser = output_parser())]
    output: PathBuf,
    /// Samples per outgoing direction, 1 to 8192 (default: 1024).
    #[arg(
        long,
        value_name = "M",
        default_value_t = ImportanceRecipe::default().samples,
        value_parser = any_whole_number::<u32>("1 to 8192"),
    )]
    count: u32,
    /// Polar angles of the outgoing direction, 1 to 1024 (default: 64 for isotropic materials, 32 for others).
    #[arg(long, value_name = "P", value_parser = any_whole_number::<u32>("1 to 1024"))]
    polar: Option<u32>,
    /// Azimuths of the outgoing direction, a multiple of 4 up to 256 (default: 16). Isotropic materials have one
    /// azimuth.
    #[arg(long, value_name = "A", value_parser = any_whole_number::<u32>("a multiple of 4 up to 256"))]
    azimuths: Option<u32>,
    /// Rings of the table of half vectors that is inverted, 1 to 4096, with finer spacing near the normal (default:
    /// 128).
    #[arg(
        long,
        value_name = "N",
        default_value_t = HalfGrid::DEFAULT.polar,
        value_parser = any_whole_number::<usize>("1 to 4096"),
    )]
    rings: usize,
    /// Cells per ring of this table, an even number from 2 to 4096 (default: 64).
    #[arg(
        long,
        value_name = "N",
        default_value_t = HalfGrid::DEFAULT.azimuths,
        value_parser = any_whole_number::<usize>("an even number, 2 to 4096"),
    )]
    cells: usize,
    /// Fraction of the samples that do not follow the lobe, above 0, up to 1 (default: 0.1). They bound the error where
    /// the table misses a feature.
    #[arg(long, value_name = "SHARE", default_value_t = Fraction::bare(ImportanceRecipe::default().defensive))]
    defensive: Fraction,
    #[command(flatten)]
    reading: ReadingOptions,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'importance-pack'.
    kind: &'static str,
    /// Contents of the pack.
    #[serde(flatten)]
    facts: ImportanceFacts,
    /// Rings of the table of half vectors.
    rings: usize,
    /// Cells of each ring.
    cells: usize,
    /// Fraction of the samples that do not follow the lobe.
    defensive: f64,
    /// Bytes of the file.
    bytes_on_disk: usize,
    /// Counts of repairs.
    #[serde(rename = "repaired")]
    repairs: Tally,
    /// Seconds spent on reading and sampling.
    seconds: Seconds,
}

/// Seconds per stage.
#[derive(Debug, Clone, Copy, Serialize, schemars::JsonSchema)]
pub struct Seconds {
    /// Reading and decoding the input.
    read: f64,
    /// Tabulating the lobes and inverting their distributions.
    samples: f64,
}

/// Names of the recipe's fields in errors, and the flags that set them.
const FLAGS: [(&str, &str); 7] = [
    ("polar rows", "--polar"),
    ("azimuth columns", "--azimuths"),
    ("samples", "--count"),
    ("half vectors of a ring", "--cells"),
    ("rings of half vectors", "--rings"),
    ("defensive share", "--defensive"),
    // All rows: polar angles times azimuths.
    ("rows", "--polar by --azimuths"),
];

fn recipe(arguments: &Arguments) -> ImportanceRecipe {
    let default = ImportanceRecipe::default();
    ImportanceRecipe {
        isotropic_polar: arguments.polar.unwrap_or(default.isotropic_polar),
        anisotropic_polar: arguments.polar.unwrap_or(default.anisotropic_polar),
        anisotropic_azimuths: arguments.azimuths.unwrap_or(default.anisotropic_azimuths),
        samples: arguments.count,
        grid: HalfGrid { polar: arguments.rings, azimuths: arguments.cells },
        defensive: arguments.defensive.value(),
    }
}

/// Converts an out-of-range error of the recipe to an error of its flag.
fn wrong_flag(arguments: &Arguments, error: FormatError) -> Error {
    match FLAGS.iter().find(|(field, _)| error.field.ends_with(field)) {
        // Report the share as it was given.
        Some((_, flag @ "--defensive")) => Error::wrong_usage(flag, arguments.defensive, error.allowed),
        Some((_, flag)) => Error::wrong_usage(flag, error.found, error.allowed),
        None => Error::own_layout(error),
    }
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let recipe = recipe(arguments);
    // Reject settings that do not depend on the material before reading it.
    recipe.check(true).map_err(|error| wrong_flag(arguments, error))?;
    refuse_unfit_output(&arguments.output, &["ktx2"], arguments.input.path().as_slice())?;
    let start = Instant::now();
    let material = open_read(&arguments.input, arguments.reading)?;
    let source = material.source();
    note_coverage(common, &arguments.input, source);
    let read = start.elapsed().as_secs_f64();
    let isotropic = source.symmetry().isotropic;
    if arguments.azimuths.is_some() && isotropic {
        return Err(Error::usage("--azimuths does not apply to isotropic materials, only to anisotropic ones"));
    }
    recipe.check(isotropic).map_err(|error| wrong_flag(arguments, error))?;
    let start = Instant::now();
    let (pack, repairs) = draw(&material, &recipe)?;
    let seconds = Seconds { read, samples: start.elapsed().as_secs_f64() };
    let bytes = pack.to_bytes(true);
    write_file(&arguments.output, &bytes)?;
    note_repairs(common, &arguments.input, &repairs);
    let report = Report {
        version: 1,
        kind: "importance-pack",
        facts: ImportanceFacts::new(&pack),
        rings: recipe.grid.polar,
        cells: recipe.grid.azimuths,
        defensive: recipe.defensive,
        bytes_on_disk: bytes.len(),
        repairs,
        seconds,
    };
    print_report(common, &arguments.output, &json_or(common, &report, report.text()))
}

impl Report {
    fn text(&self) -> String {
        let mut lines = importance_lines(&self.facts);
        lines.push(("bytes on disk", table::bytes(self.bytes_on_disk as u64)));
        lines.push(("half vectors", format!("{} rings of {} cells", self.rings, self.cells)));
        lines.push(("defensive share", table::percent(self.defensive)));
        let Seconds { read, samples } = self.seconds;
        lines.push(("seconds", format!("{read:.3} to read, {samples:.3} for the samples")));
        lines_of(&lines)
    }
}
