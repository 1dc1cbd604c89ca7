//! `brdfc encode --codec lobes`: the lobes of one material.

use super::encode::Arguments;
use super::options::{by_flags, failed, first_key, flag_of};
use super::output::{json_or, note, note_repairs, print_report, write_file};
use super::progress::{Materials, label};
use super::reading::open_read;
use super::{Common, Error};
use crate::table;
use brdfc::compare::DirectionRange;
use brdfc::encode::{ErrorLimits, Found, GateResult, Reliability, StageClock, StageTime, check};
use brdfc::lobes::{LobesFacts, LobesRecipe, LobesTrial, encode, missed};
use brdfc::{EncodeOptions, Facts, FitLimits, Progress as _, Stage, Tally};
use serde::Serialize;

/// Report of `brdfc encode --codec lobes --json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// The input.
    input: Facts,
    /// The pack.
    pack: Candidate,
    /// All packs that were tried, from few look-ups to many.
    tried: Vec<Candidate>,
    /// Properties of the source on which the meaning of the errors depends.
    reliability: Reliability,
    /// Results of the checks of the source, if limits were requested.
    gates: Vec<GateResult>,
    /// Bytes of the file.
    bytes_on_disk: usize,
    /// Counts of repairs.
    #[serde(rename = "repaired")]
    repairs: Tally,
    /// Seconds per stage.
    stages: Vec<StageTime>,
}

/// A number of lobes that was tried.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Candidate {
    /// Contents.
    #[serde(flatten)]
    facts: LobesFacts,
    /// True if it meets the limit.
    meets: bool,
}

impl Candidate {
    fn new(trial: &LobesTrial) -> Self {
        Self { facts: LobesFacts::new(&trial.pack), meets: trial.meets }
    }
}

/// Resolves the recipe and the limits of the fit. With `--max-fetches` alone, the error is as small as possible.
fn request(options: &EncodeOptions) -> Result<(LobesRecipe, FitLimits), Error> {
    let others = EncodeOptions {
        max_delta_e: None,
        max_fetches: None,
        codec: None,
        max_fit_error: None,
        trust_fit: None,
        ..options.clone()
    };
    if let Some(key) = first_key(&others) {
        let text = "does not apply to --codec lobes, which takes --max-delta-e, --max-fetches, --max-fit-error and --trust-fit";
        return Err(Error::usage(format!("{} {text}", flag_of(key))));
    }
    let recipe = brdfc::lobes::recipe(options.max_delta_e, options.max_fetches).map_err(by_flags)?;
    Ok((recipe, options.fit_limits().map_err(by_flags)?))
}

pub(super) fn run(arguments: &Arguments, options: &EncodeOptions, common: Common) -> Result<(), Error> {
    let (recipe, fit) = request(options)?;
    let progress = Materials::new(1, false, common);
    let name = label(&arguments.output);
    let part = progress.part(&name);
    let clock = StageClock::new(part.as_ref());
    clock.stage(Stage::Read, 1)?;
    let material = open_read(&arguments.input, arguments.reading)?;
    let encoded = encode(material.source(), &recipe, &clock).map_err(|error| error.prefixed(&arguments.input))?;
    let reliability = Reliability::measure(material.source(), DirectionRange::ALL, &clock)
        .map_err(|cancelled| Error::from(cancelled).prefixed(&arguments.input))?;
    clock.stage(Stage::Write, 1)?;
    let best = encoded.best();
    let bytes = best.pack.to_bytes(arguments.options.supercompress());
    write_file(&arguments.output, &bytes)?;
    let stages = clock.finish();
    drop(part);
    drop(progress);
    note_repairs(common, &arguments.input, &encoded.tally);
    let tried: Vec<Candidate> = encoded.trials.iter().map(Candidate::new).collect();
    for line in reliability.remarks(best.error.mean) {
        note(common, &arguments.input, &line);
    }
    // The default limit is not a check of the source.
    let errors = ErrorLimits { delta_e: options.max_delta_e, relative: None };
    let gates =
        check(fit, errors, &reliability, Found { delta_e: Some(best.error.mean), relative: None, all_lights: true });
    let missed = missed(&encoded, &recipe).map(|missed| format!("--max-delta-e: {missed}"));
    let missed = missed.into_iter().chain(failed(&gates)).reduce(|all, next| format!("{all}; {next}"));
    let missed = missed.map(|missed| Error::check(missed).prefixed(&arguments.input));
    let report = Report {
        version: 2,
        input: material.facts().clone(),
        pack: Candidate::new(best),
        tried,
        reliability,
        gates,
        bytes_on_disk: bytes.len(),
        repairs: encoded.tally,
        stages,
    };
    print_report(common, &arguments.output, &json_or(common, &report, report.text(arguments)))?;
    missed.map_or(Ok(()), Err)
}

impl Report {
    fn text(&self, arguments: &Arguments) -> String {
        let row = |one: &Candidate| {
            let [normal, mirror, viewer] = one.facts.anchors;
            [
                one.facts.fetches.to_string(),
                normal.to_string(),
                mirror.to_string(),
                viewer.to_string(),
                table::bytes(one.facts.gpu_bytes),
                format!("{:.2}", one.facts.delta_e.mean),
                format!("{:.2}", one.facts.delta_e.p95),
                if one.meets { "yes" } else { "no" }.to_owned(),
            ]
        };
        let header = ["look-ups", "normal", "mirror", "viewer", "on GPU", "ΔE", "ΔE 95 %", "meets the limits"];
        let tried = table::plain(&header, self.tried.iter().map(row));
        let one = &self.pack;
        let seconds: f64 = self.stages.iter().map(|stage| stage.seconds).sum();
        let row = [
            arguments.output.display().to_string(),
            "lobes".to_owned(),
            one.facts.fetches.to_string(),
            table::bytes(self.bytes_on_disk as u64),
            table::bytes(one.facts.gpu_bytes),
            format!("{:.2}", one.facts.delta_e.mean),
            format!("{:.2}", one.facts.delta_e.p95),
            format!("{seconds:.2} s"),
        ];
        let header = ["pack", "codec", "look-ups", "on disk", "on GPU", "ΔE", "ΔE 95 %", "time"];
        format!("{tried}\n{}", table::plain(&header, [row]))
    }
}

/// Lines of `brdfc info`.
pub(super) fn lines(facts: &LobesFacts) -> Vec<(&'static str, String)> {
    let LobesFacts { fetches, anchors: [normal, mirror, viewer], nodes, azimuths, gpu_bytes, delta_e } = facts;
    let views = if *azimuths == 1 { nodes.to_string() } else { format!("{nodes} at each of {azimuths} azimuths") };
    vec![
        ("kind", "lobes of a BRDF".to_owned()),
        ("look-ups", fetches.to_string()),
        ("around", format!("the normal {normal}, the mirror direction {mirror}, the viewer {viewer}")),
        ("view angles", views),
        ("bytes on a GPU", table::bytes(*gpu_bytes)),
        ("ΔE of a ball", format!("mean {:.2}, 95 % below {:.2}", delta_e.mean, delta_e.p95)),
    ]
}
