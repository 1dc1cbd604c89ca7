//! `brdfc compare`: error of one input against another.

use super::inputs::refuse_stdin_twice;
use super::output::{print, print_json, remark};
use super::{CliError, Common};
use crate::table;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::measured::scan_csv::directions_from_bytes;
use brdfc_metrics::compare::{Comparison, compare};
use brdfc_metrics::fraction::Fraction;
use brdfc_metrics::sampling::{PairSet, random_pairs};
use brdfc_source::Input;
use brdfc_source::open::{Facts, open};
use clap::Args;
use serde::Serialize;

/// Measure the error of B against A.
///
/// A is the reference. Both may be any source or pack. Exits with 1 when --max-error is given and missed.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc compare paint.brdf paint.ktx2
  brdfc compare red.binary red.ktx2 --directions 100000 --max-error 0.05
  brdfc compare a.ktx2 b.ktx2 --directions pairs.csv --json")]
pub struct Arguments {
    /// The reference: a path, - for stdin, or synth:MODEL?param=value&...
    a: Input,
    /// The approximation, likewise.
    b: Input,
    /// How many random direction pairs (uniform over both hemispheres, fixed seed), a CSV of pairs, or - for one from stdin (default: those at
    /// which 'encode' and 'build' measure, 65536 of three kinds).
    #[arg(long, value_name = "N|FILE.csv", allow_hyphen_values = true)]
    directions: Option<Input>,
    /// Largest mean relative difference ε_r that passes: a fraction or a percentage, 0.05 or 5%.
    #[arg(long, value_name = "E")]
    max_error: Option<Fraction>,
}

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// The reference.
    a: Facts,
    /// The approximation.
    b: Facts,
    /// Direction pairs.
    pairs: usize,
    /// Directions that are compared: those that both are for, or all where pairs are given.
    directions: DirectionRange,
    /// What was measured.
    #[serde(flatten)]
    comparison: Comparison,
}

const SEED: u64 = 2007;
const MOST_PAIRS: usize = 100_000_000;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    let limit = arguments.max_error.map(|limit| {
        limit.checked().map_err(|allowed| CliError::Usage(format!("--max-error: found {limit}; allowed {allowed}")))
    });
    let limit = limit.transpose()?;
    let inputs =
        [("A", Some(&arguments.a)), ("B", Some(&arguments.b)), ("--directions", arguments.directions.as_ref())];
    refuse_stdin_twice(&inputs)?;
    let (a, b) = (open(&arguments.a, None)?, open(&arguments.b, None)?);
    // A pack that is for some directions only is no worse for what it does not hold.
    let both = a.facts.directions().common(b.facts.directions()).ok_or_else(|| {
        CliError::Check(format!(
            "directions: found a pack for {}, and one for {}; allowed packs that have some in common",
            a.facts.directions(),
            b.facts.directions()
        ))
    })?;
    let set = match &arguments.directions {
        Some(directions) => PairSet::new(pairs(directions)?),
        None => PairSet::within(both),
    };
    if !both.is_all() && arguments.directions.is_none() {
        remark(common, &format!("compared where both are: {both}"));
    }
    let (comparison, _) = compare(a.source.as_ref(), b.source.as_ref(), &set);
    let found = comparison.norms.relative_mean;
    let comparison_counts = comparison.norms.counted() > 0;
    if common.json {
        let (pairs, directions) = (set.pairs.len(), set.directions);
        print_json(&Report { version: 1, a: a.facts, b: b.facts, pairs, directions, comparison })?;
    } else {
        print(&table::comparison(&comparison, set.directions))?;
    }
    match limit {
        Some(_) if !comparison_counts => Err(CliError::Check(
            "mean relative difference: found no sample above 0.1 % of the reference's mean; allowed at least one, or \
             the check says nothing"
                .to_owned(),
        )),
        Some(allowed) if found > allowed => Err(CliError::Check(format!(
            "mean relative difference: found {}; allowed {}",
            table::percent(found),
            table::percent(allowed)
        ))),
        _ => Ok(()),
    }
}

fn pairs(directions: &Input) -> Result<Vec<DirectionPair>, CliError> {
    let number = directions.path().and_then(|path| path.to_str()?.parse::<usize>().ok());
    if let Some(count) = number {
        if !(1..=MOST_PAIRS).contains(&count) {
            return Err(CliError::Usage(format!("--directions: found {count}; allowed 1 to {MOST_PAIRS}")));
        }
        return Ok(random_pairs(count, SEED));
    }
    let is_number = |path: &std::path::Path| path.to_str().is_some_and(|text| text.parse::<f64>().is_ok());
    let no_list = |path: &std::path::Path| !path.exists() && (path.extension().is_none() || is_number(path));
    if directions.path().is_none_or(no_list) && !directions.is_stdin() {
        let allowed = "a number of directions, or a list of them in a .csv file";
        return Err(CliError::Usage(format!("--directions: found {directions}; allowed {allowed}")));
    }
    let bytes = directions.read_text()?;
    let pairs = directions_from_bytes(&bytes).map_err(|error| CliError::Input(format!("{directions}: {error}")))?;
    if pairs.is_empty() {
        return Err(CliError::Input(format!("{directions}: records: found none; allowed at least one")));
    }
    Ok(pairs.into_iter().map(|(incoming, outgoing)| DirectionPair::new(incoming, outgoing)).collect())
}
