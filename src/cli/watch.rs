//! `brdfc watch`: builds again when an input changes.

use super::build_scene::{BuildArguments, plan, print_diagnostics, tell_left_out};
use super::interrupt;
use super::output::{print_if_read, remark, tell};
use super::progress::Materials;
use super::{Common, Error};
use brdfc::scene::{Change, FileEvents, Watched, What, manifest_among};
use brdfc::{BuildReport, Changes, EncodeOptions, ErrorKind};
use brdfc_terminal::words::{counted, format_number, join_truncated};
use clap::Args;
use serde::Serialize;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Default seconds between two checks, with --poll.
const POLL_SECONDS: std::ops::RangeInclusive<f64> = 0.1..=3600.0;
/// Maximum number of file names in a line.
const MAX_NAMED: usize = 3;

/// Build, and build again whenever the manifest or one of its files changes.
///
/// Takes the arguments of 'brdfc build'. Until Ctrl-C, the program watches the manifest, the sources of materials that
/// the scene uses, the environment, and the set of files that match a pattern or are in a given folder. Results that a
/// change does not affect come from the store of the output folder (.brdfc-cache). A change during a build cancels it
/// and starts another. A build that fails is reported, and leaves the output folder unchanged, unless it only misses
/// limits or requirements.
///
/// For each build, one line on stderr states what changed, what was built and how long it took; notes concern newly
/// built materials. With --json, a report of each build goes to stdout, on one line (schema: 'brdfc schema watch').
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc watch scene.toml
  brdfc watch scans --out packs --max-delta-e 1
  brdfc watch /mnt/server/scene.toml --poll 5")]
pub struct Arguments {
    #[command(flatten)]
    build: BuildArguments,
    /// Check the files every S seconds, 0.1 to 3600, instead of waiting for notifications of the system. Use it for
    /// network drives, where the system does not notify about changes by other machines.
    #[arg(long, value_name = "S")]
    poll: Option<f64>,
    #[command(flatten, next_help_heading = "Encoding")]
    options: EncodeOptions,
}

/// Report of `--json`, printed for each build.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Files that changed since the previous build; empty for the first one.
    changed: Vec<Change>,
    /// Seconds from the detection of the change to the end of the build.
    seconds: f64,
    /// Files that were written into the output folder.
    written: Vec<String>,
    /// Files that were removed from it.
    removed: Vec<String>,
    /// Failures, in one sentence. The folder is then unchanged, except if the only failure is a missed limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    /// The build; absent if there was nothing to build.
    #[serde(skip_serializing_if = "Option::is_none")]
    build: Option<BuildReport>,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let poll = arguments.poll.map(seconds).transpose()?;
    let BuildArguments { inputs, out, .. } = &arguments.build;
    let mut watched = match manifest_among(inputs)? {
        Some(manifest) => Watched::of_manifest(&manifest, out),
        None => Watched::of_inputs(inputs, out),
    };
    interrupt::watch()?;
    let mut events = FileEvents::new(poll);
    let mut look = watched.look();
    let (mut changed, mut is_first) = (Vec::new(), true);
    // State at the start of the last completed build.
    let mut before = look.clone();
    loop {
        let started = Instant::now();
        interrupt::at_work(true);
        let (built, meanwhile) = watched.during(&mut events, &look, |cancelled| {
            let built = one_build(arguments, common, is_first, cancelled);
            interrupt::at_work(false);
            built
        });
        let is_over = !built.as_ref().is_err_and(|error| error.kind() == ErrorKind::Cancelled);
        if is_over {
            if let (true, Err(error)) = (is_first, &built)
                && matches!(error.kind(), ErrorKind::Usage | ErrorKind::Io | ErrorKind::Internal)
            {
                return built.map(drop);
            }
            let report = report(built, std::mem::take(&mut changed), started.elapsed().as_secs_f64());
            if !tell_build(&report, is_first, common)? {
                return Ok(());
            }
            if is_first {
                remark(common, &format!("watching {}; press Ctrl-C to stop", files(look.count())));
            }
            (before, is_first) = (look.clone(), false);
        }
        if let Some(problem) = events.problem() {
            remark(common, &format!("note: {problem}"));
        }
        look = match meanwhile {
            Some(look) => look,
            None => match watched.next(&mut events, &look, &AtomicBool::new(false)) {
                Some(look) => look,
                None => return Ok(()),
            },
        };
        changed = look.changes_since(&before);
    }
}

fn seconds(seconds: f64) -> Result<Duration, Error> {
    if POLL_SECONDS.contains(&seconds) {
        return Ok(Duration::from_secs_f64(seconds));
    }
    let (least, most) = (POLL_SECONDS.start(), POLL_SECONDS.end());
    Err(Error::usage(format!("--poll: found {}, expected {least} to {most} seconds", format_number(seconds))))
}

/// A completed build, successful or not.
struct Ended {
    report: BuildReport,
    changes: Option<Changes>,
    verdict: Result<(), Error>,
}

fn one_build(arguments: &Arguments, common: Common, is_first: bool, cancelled: &AtomicBool) -> Result<Ended, Error> {
    // Remarks that never change are printed once.
    let once = Common { quiet: common.quiet || !is_first, ..common };
    let build = arguments.build.build(&arguments.options)?.whole(true);
    tell_left_out(&build, once);
    let plan = &plan(&build)?;
    let progress = Materials::of(plan, once).without_lines_until(cancelled);
    let built = build.run_with(plan, &progress)?;
    drop(progress);
    print_diagnostics(&build, &built, common, is_first);
    Ok(Ended { report: built.report, changes: built.changes, verdict: built.outcomes.verdict() })
}

fn report(built: Result<Ended, Error>, changed: Vec<Change>, seconds: f64) -> Report {
    let (build, changes, verdict) = match built {
        Ok(built) => (Some(built.report), built.changes.unwrap_or_default(), built.verdict),
        Err(error) => (None, Changes::default(), Err(error)),
    };
    let error = verdict.err().map(|error| error.message().to_owned());
    Report { version: 1, changed, seconds, written: changes.written, removed: changes.removed, error, build }
}

/// Prints the result of a build. Returns false if the reader of the reports closed the pipe.
fn tell_build(report: &Report, is_first: bool, common: Common) -> Result<bool, Error> {
    if let Some(error) = &report.error {
        tell(&format!("brdfc: {error}"));
    }
    let why = if is_first { "first build".to_owned() } else { changes(&report.changed) };
    remark(common, &format!("{why}: {} ({:.1} s)", result(report), report.seconds));
    if !common.json {
        return Ok(true);
    }
    print_if_read(&(serde_json::to_string(report).expect("reports are plain data") + "\n"))
}

/// Summarises the result.
fn result(report: &Report) -> String {
    let Some(build) = &report.build else { return "failed, the output folder is unchanged".to_owned() };
    let of_materials = build.materials.iter().map(|entry| entry.cached);
    let of_assets = build.assets.iter().map(|entry| entry.cached);
    let of_all = of_materials.chain(of_assets).chain(build.environment.iter().map(|entry| entry.cached));
    let count = |target| of_all.clone().filter(|cached| *cached == target).count();
    let mut text = format!("{} built, {} cached", count(Some(false)), count(Some(true)));
    if count(None) > 0 {
        text += &format!(", {} failed", count(None));
    }
    for (what, names) in [("written", &report.written), ("removed", &report.removed)] {
        if !names.is_empty() {
            text += &format!(", {} {what}", files(names.len()));
        }
    }
    if report.written.is_empty() && report.removed.is_empty() {
        text += ", the output folder is unchanged";
    }
    text
}

fn files(count: usize) -> String {
    counted(count, "file")
}

/// Summarises the changes.
fn changes(changed: &[Change]) -> String {
    let word = |what| match what {
        What::Changed => "changed",
        What::New => "new",
        What::Gone => "gone",
    };
    // Escape line ends, so that the summary stays on one line.
    let named = changed.iter().map(|change| format!("{} {}", change.file.replace('\n', "\\n"), word(change.what)));
    let text = join_truncated(&named.collect::<Vec<_>>(), MAX_NAMED);
    if text.is_empty() { "changed and reverted".to_owned() } else { text }
}
