//! `brdfc compare`: error of one input against another.

mod flat;

use self::flat::FlatReport;
use super::inputs::refuse_stdin_twice;
use super::output::{json_or, note, note_gaps, print, refuse_flags, remark};
use super::reading::{PhotographOptions, ReadingOptions, checked};
use super::{Common, Error};
use crate::table;
use brdfc::compare::{
    BtfComparison, Compared as Measured, Comparison, DirectionRange, Pairs, PhotographComparison, reflectances,
};
use brdfc::evaluate::pairs_from_csv;
use brdfc::inspect::{Kind, PackKind};
use brdfc::{Facts, Fraction, Input, Material, Reading, open_with};
use clap::Args;
use serde::Serialize;
use std::path::Path;

/// Measure the error of B, compared with the reference A.
///
/// Both may be any source or pack. The exit code is 1 if --max-error or --max-delta-e is exceeded.
///
/// If A is an RTI capture (a folder with an .lp, or the list itself), B is a pack, .ptm or .rti made from it, or another
/// capture with the same lights. The program compares them photograph by photograph, in 8-bit sRGB
/// levels and as ΔE.
///
/// If A is a BTF (a folder of images or a .btf file), B is a pack of 'brdfc pwt --view all'. The program compares them view
/// by view in the same way.
///
/// If A is a flat BTF (the file that 'brdfc flatten' wrote, or its folder), B is another flat BTF of the same surface,
/// such as a smaller one. The program compares them by ΔE at random positions, views and lights.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc compare paint.brdf paint.ktx2
  brdfc compare red.binary red.ktx2 --directions 100000 --max-error 0.05
  brdfc compare a.ktx2 b.ktx2 --directions pairs.csv --json
  brdfc compare icon icon.ktx2 --max-delta-e 3
  brdfc compare cloth cloth.ktx2 --max-delta-e 3
  brdfc compare whole button --max-delta-e 4")]
pub struct Arguments {
    /// The reference: a path, - for stdin, or synth:MODEL?param=value&...
    a: Input,
    /// The approximation, in the same form.
    b: Input,
    /// Direction pairs: a number N of random pairs (1 to 100000000, uniform over both hemispheres, fixed seed), or a
    /// CSV file, or - for a CSV from stdin (default: the 65536 pairs of three kinds at which 'encode' and 'build'
    /// measure).
    #[arg(long, value_name = "N|FILE.csv", allow_hyphen_values = true)]
    directions: Option<Input>,
    /// Maximum mean relative difference ε_r: a fraction or a percentage, 0.05 or 5%.
    #[arg(long, value_name = "E")]
    max_error: Option<Fraction>,
    /// Maximum mean ΔE (CIE76) of RTI captures, BTFs and flat BTFs, 0 to 1000.
    #[arg(long, value_name = "E")]
    max_delta_e: Option<f64>,
    #[command(flatten)]
    reading: ReadingOptions,
    #[command(flatten)]
    images: PhotographOptions,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Comparison, by kind of input.
    #[serde(flatten)]
    compared: Compared,
}

/// Comparison, by kind of input.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[serde(untagged)]
#[allow(clippy::large_enum_variant)]
enum Compared {
    /// Two sources of reflectance.
    Reflectances(ReflectanceReport),
    /// Photographs under known lights.
    Photographs(PhotographReport),
    /// A BTF.
    Btf(BtfReport),
    /// Two flat BTFs.
    FlatBtfs(FlatReport),
}

/// Photographs under known lights, compared with an approximation.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct PhotographReport {
    /// 'rti-capture'.
    kind: &'static str,
    /// Measured errors.
    #[serde(flatten)]
    comparison: PhotographComparison,
}

/// A BTF, compared with a pack of all its views.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct BtfReport {
    /// 'btf'.
    kind: &'static str,
    /// Measured errors.
    #[serde(flatten)]
    comparison: BtfComparison,
}

/// Error of one source or pack against another.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct ReflectanceReport {
    /// The reference.
    a: Facts,
    /// The approximation.
    b: Facts,
    /// Direction pairs.
    pairs: usize,
    /// Compared directions: those that both inputs contain, or all if pairs are given.
    directions: DirectionRange,
    /// Measured errors.
    #[serde(flatten)]
    comparison: Comparison,
}

const MAX_PAIRS: usize = 100_000_000;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let limit = arguments
        .max_error
        .map(|limit| limit.checked().map_err(|allowed| Error::wrong_usage("--max-error", limit, allowed)));
    let limit = limit.transpose()?;
    let inputs =
        [("A", Some(&arguments.a)), ("B", Some(&arguments.b)), ("--directions", arguments.directions.as_ref())];
    refuse_stdin_twice(&inputs)?;
    let reading = checked(arguments.reading, &[&arguments.a, &arguments.b])?;
    let kind = Kind::of(&arguments.a)?;
    match (kind, arguments.a.path()) {
        (Kind::RtiCapture, Some(stack)) => return photographs(arguments, stack, common),
        (Kind::Btf, Some(folder)) => return btf(arguments, folder, common),
        _ => {}
    }
    arguments.images.refuse(if kind.is_flat_btf() { "flat BTFs" } else { "reflectances" })?;
    if kind.is_flat_btf() {
        arguments.refuse_flags_of_reflectances("flat BTFs")?;
        let report = FlatReport::new(&arguments.a, &arguments.b)?;
        print_compared(common, Compared::FlatBtfs(report), report.table())?;
        return arguments.max_delta_e.map_or(Ok(()), |limit| report.check(&arguments.a, limit));
    }
    let (a, b) = (opened(&arguments.a, reading)?, opened(&arguments.b, reading)?);
    if arguments.max_delta_e.is_some() {
        let text = "--max-delta-e does not apply to BRDFs; use --max-error, or compare RTI captures or flat BTFs";
        return Err(Error::usage(text));
    }
    let at = arguments.directions.as_ref().map_or(Ok(Pairs::default()), pairs)?;
    let Measured { pairs, directions, comparison } = reflectances(&a, &b, at)?;
    for (input, material) in [(&arguments.a, &a), (&arguments.b, &b)] {
        note_gaps(common, input, material.source());
    }
    if !directions.is_all() {
        remark(common, &format!("compared only at directions that both contain: {directions}"));
    }
    let found = comparison.norms.relative_mean;
    let comparison_counts = comparison.norms.counted() > 0;
    let text = table::comparison(&comparison, directions);
    let [a, b] = [a, b].map(|material| material.facts().clone());
    let report = ReflectanceReport { a, b, pairs, directions, comparison };
    print_compared(common, Compared::Reflectances(report), text)?;
    match limit {
        Some(_) if !comparison_counts => {
            Err(Error::check("--max-error: no sample above 0.1 % of the reference's mean; nothing to check"))
        }
        Some(allowed) if found > allowed => Err(Error::check(format!(
            "--max-error: found {}, expected at most {}",
            table::percent(found),
            table::percent(allowed)
        ))),
        _ => Ok(()),
    }
}

/// Opens a source or pack. Errors of inputs that can be relit name the order of their comparison.
fn opened(input: &Input, reading: Reading) -> Result<Material, Error> {
    open_with(input, reading).map_err(|error| {
        let can_be_relit =
            matches!(Kind::of(input), Ok(Kind::RtiCapture | Kind::Ptm | Kind::Rti | Kind::Pack(PackKind::Pwt)));
        let text =
            format!("{error}; for relightable images, A is the folder of photographs and B the pack, .ptm or .rti");
        if can_be_relit { error.with_message(text) } else { error }
    })
}

impl Arguments {
    /// Rejects flags that apply only to reflectances.
    fn refuse_flags_of_reflectances(&self, what: &str) -> Result<(), Error> {
        let given = [(self.directions.is_some(), "--directions"), (self.max_error.is_some(), "--max-error")];
        refuse_flags(what, &given.map(|(given, flag)| (given, flag, "reflectances")))?;
        match self.max_delta_e.filter(|limit| !(0.0..=1000.0).contains(limit)) {
            Some(limit) => Err(Error::wrong_usage("--max-delta-e", limit, "0 to 1000")),
            None => Ok(()),
        }
    }
}

fn print_compared(common: Common, compared: Compared, text: String) -> Result<(), Error> {
    print(&json_or(common, &Report { version: 1, compared }, text))
}

/// Compares photographs of an RTI capture with an approximation.
fn photographs(arguments: &Arguments, reference: &Path, common: Common) -> Result<(), Error> {
    arguments.refuse_flags_of_reflectances("an RTI capture")?;
    let comparison = brdfc::compare::photographs(reference, &arguments.b, arguments.images.codes)?;
    let PhotographComparison { errors, photographs, notes } = &comparison;
    notes.iter().for_each(|line| note(common, &arguments.a, line));
    let (found, nothing) = (errors.delta_e, errors.nothing_shown());
    let worst = photographs.iter().max_by(|a, b| a.delta_e.total_cmp(&b.delta_e));
    let [x, y, z] = worst.map_or([0.0; 3], |worst| worst.light);
    let row = vec![
        errors.lights.to_string(),
        format!("{:.2}", errors.psnr),
        format!("{found:.2}"),
        worst.map_or("-".to_owned(), |worst| format!("{:.2}", worst.delta_e)),
        format!("({x:.2}, {y:.2}, {z:.2})"),
    ];
    let text = table::plain(&["photographs", "dB", "mean ΔE", "worst", "under the light"], &[row]);
    print_compared(common, Compared::Photographs(PhotographReport { kind: "rti-capture", comparison }), text)?;
    arguments.check_delta_e(found, nothing)
}

/// Compares a BTF with a pack of all its views.
fn btf(arguments: &Arguments, reference: &Path, common: Common) -> Result<(), Error> {
    arguments.refuse_flags_of_reflectances("a BTF")?;
    let comparison = brdfc::compare::btf(reference, &arguments.b, arguments.images.codes)?;
    let BtfComparison { errors, views } = &comparison;
    let (found, nothing) = (errors.delta_e, errors.nothing_shown());
    let worst = views.iter().max_by(|a, b| a.delta_e.total_cmp(&b.delta_e));
    let [x, y, z] = worst.map_or([0.0; 3], |worst| worst.view);
    let row = vec![
        views.len().to_string(),
        errors.lights.to_string(),
        format!("{:.2}", errors.psnr),
        format!("{found:.2}"),
        worst.map_or("-".to_owned(), |worst| format!("{:.2}", worst.delta_e)),
        format!("({x:.2}, {y:.2}, {z:.2})"),
    ];
    let text = table::plain(&["views", "images", "dB", "mean ΔE", "worst", "of the view"], &[row]);
    print_compared(common, Compared::Btf(BtfReport { kind: "btf", comparison }), text)?;
    arguments.check_delta_e(found, nothing)
}

impl Arguments {
    /// Checks the limit of the mean ΔE.
    fn check_delta_e(&self, found: f64, nothing: Option<String>) -> Result<(), Error> {
        match self.max_delta_e {
            Some(limit) if nothing.is_some() => {
                let nothing = nothing.unwrap_or_default();
                Err(Error::check(format!("--max-delta-e: {nothing}; expected at most {limit}")))
            }
            Some(limit) if found > limit => Err(Error::check(format!(
                "--max-delta-e: found {}, expected at most {limit}",
                table::apart(found, limit)
            ))),
            _ => Ok(()),
        }
    }
}

fn pairs(directions: &Input) -> Result<Pairs, Error> {
    let number = directions.path().and_then(|path| path.to_str()?.parse::<usize>().ok());
    if let Some(count) = number {
        if !(1..=MAX_PAIRS).contains(&count) {
            return Err(Error::usage(format!("--directions: found {count}, expected 1 to {MAX_PAIRS}")));
        }
        return Ok(Pairs::Random(count));
    }
    let is_number = |path: &Path| path.to_str().is_some_and(|text| text.parse::<f64>().is_ok());
    let no_list = |path: &std::path::Path| !path.exists() && (path.extension().is_none() || is_number(path));
    if directions.path().is_none_or(no_list) && !directions.is_stdin() {
        let allowed = "a number of direction pairs or a .csv file";
        return Err(Error::wrong_usage("--directions", directions, allowed));
    }
    let pairs = pairs_from_csv(directions, &directions.read_text()?)?;
    if pairs.is_empty() {
        return Err(Error::input(format!("{directions}: no direction pairs; expected at least one row")));
    }
    Ok(Pairs::Given(pairs))
}
