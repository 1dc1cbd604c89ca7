//! `brdfc build`: the main job.

use super::output::{make_folder, print, print_json, remark, tell, to_json, write_file};
use super::progress::Progress;
use super::{CliError, Common};
use crate::brdf::encode::Target;
use crate::build::manifest::Manifest;
use crate::build::run::{Made, Outcome, Plan, pack_name, plan, run as run_jobs};
use crate::report::material::{MaterialReport, StageTime, remarks};
use crate::report::table;
use crate::source::open::{MAX_TEXT_BYTES, read_file};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Make the packs that a scene needs.
///
/// The manifest names materials and the uses that a scene makes of them; docs/scene.md lists its keys. A material that
/// no use refers to is not even opened. Packs of an earlier build are kept where source, options and program are the
/// same. One material that fails does not stop the others.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc build scene.toml
  brdfc build scene.toml --out assets/packs --jobs 4 --json > report.json
  brdfc build scene.toml --dry-run")]
pub struct Arguments {
    /// The scene manifest.
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Folder for packs and reports.
    #[arg(long, short, value_name = "DIR", default_value = "packs")]
    out: PathBuf,
    /// Say what would be done, and do nothing.
    #[arg(long)]
    dry_run: bool,
    /// Make every pack again.
    #[arg(long)]
    no_cache: bool,
    /// Print the report as JSON (schema: 'brdfc schema build').
    #[arg(long)]
    json: bool,
}

/// What `--json` prints, and without times what `report.json` in the output folder holds.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// The scene's name.
    scene: String,
    /// Materials that the scene uses, by name.
    materials: Vec<Entry>,
    /// Materials that no use refers to.
    skipped: Vec<String>,
}

/// One material of a build.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Entry {
    /// Its name.
    material: String,
    /// The pack, relative to the output folder; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pack: Option<String>,
    /// What was measured; absent if it failed, or was only planned.
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<MaterialReport>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    /// Whether the pack of an earlier build was kept. Only in what is printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    cached: Option<bool>,
    /// Seconds per stage. Only in what is printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    stages: Option<Vec<StageTime>>,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    let path = &arguments.scene;
    let (_, manifest) = read_manifest(path)?;
    let plan = plan(&manifest, path.parent().unwrap_or(Path::new("")));
    let scene = manifest.scene.name.clone().unwrap_or_else(|| "scene".to_owned());
    if arguments.dry_run {
        return dry_run(arguments, &plan, scene);
    }

    make_folder(&arguments.out)?;
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancelled);
    // The second interrupt ends the process at once; packs are renamed into place, so none is ever half written.
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .map_err(|error| CliError::Internal(format!("cannot watch for interrupts: {error}")))?;

    let progress = Progress::new(plan.jobs.len(), common);
    let outcomes = run_jobs(&plan, &arguments.out, !arguments.no_cache, &cancelled, &progress);
    drop(progress);

    let report =
        Report { version: 1, scene, materials: outcomes.iter().map(entry).collect(), skipped: plan.skipped.clone() };
    let lasting = to_json(&lasting(&report, &plan, &arguments.out));
    write_file(&arguments.out.join("report.json"), lasting.as_bytes())?;
    for outcome in &outcomes {
        match &outcome.result {
            Ok(made) => {
                for line in remarks(&made.report) {
                    remark(common, &format!("note: {}: {line}", outcome.name));
                }
            }
            Err(error) => tell(&format!("brdfc: {}: {error}", outcome.name)),
        }
    }
    if arguments.json {
        print_json(&report)?;
    } else {
        print(&build_table(&outcomes))?;
    }
    if !plan.skipped.is_empty() {
        remark(common, &format!("not used by the scene, not opened: {}", plan.skipped.join(", ")));
    }
    worst(outcomes)
}

/// A manifest with its text.
pub(super) fn read_manifest(path: &Path) -> Result<(String, Manifest), CliError> {
    let bytes = read_file(path, MAX_TEXT_BYTES)?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let byte = bytes[error.valid_up_to()];
        CliError::Input(format!("{}: line {line}, text: found byte {byte:#04x}; allowed UTF-8", path.display()))
    })?;
    let manifest = Manifest::parse(text).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))?;
    Ok((text.to_owned(), manifest))
}

/// The failure with the highest exit code decides.
fn worst(outcomes: Vec<Outcome>) -> Result<(), CliError> {
    let count = outcomes.len();
    let failures: Vec<CliError> = outcomes.into_iter().filter_map(|o| o.result.err()).map(CliError::from).collect();
    let failed = failures.len();
    let Some(first) = failures.into_iter().max_by_key(|error| (error.exit_code(), 0)) else { return Ok(()) };
    let summary = format!("{failed} of {count} materials failed");
    Err(match first {
        CliError::Check(_) => CliError::Check(summary),
        CliError::Usage(_) => CliError::Usage(summary),
        CliError::Input(_) => CliError::Input(summary),
        CliError::Io(_) => CliError::Io(summary),
        other => other,
    })
}

fn entry(outcome: &Outcome) -> Entry {
    let (report, error, cached, stages) = match &outcome.result {
        Ok(Made { report, times }) => (Some(report.clone()), None, Some(times.is_none()), times.clone()),
        Err(error) => (None, Some(error.to_string()), None, None),
    };
    let pack = report.is_some().then(|| pack_name(&outcome.name));
    Entry { material: outcome.name.clone(), pack, report, error, cached, stages }
}

/// The report without what differs between runs: times, and where manifest and packs are.
fn lasting(report: &Report, plan: &Plan, out: &Path) -> Report {
    let out = format!("{}/", out.display());
    let materials = report.materials.iter().zip(&plan.jobs).map(|(entry, job)| Entry {
        material: entry.material.clone(),
        pack: entry.pack.clone(),
        report: entry.report.clone(),
        error: entry.error.as_ref().map(|text| text.replace(&job.source, &job.declared).replace(&out, "")),
        cached: None,
        stages: None,
    });
    Report {
        version: report.version,
        scene: report.scene.clone(),
        materials: materials.collect(),
        skipped: report.skipped.clone(),
    }
}

fn build_table(outcomes: &[Outcome]) -> String {
    let rows: Vec<Vec<String>> = outcomes
        .iter()
        .filter_map(|outcome| {
            let made = outcome.result.as_ref().ok()?;
            let seconds = made.times.as_ref().map(|times| times.iter().map(|t| t.seconds).sum());
            let mut row = vec![outcome.name.clone()];
            row.extend(table::material_row(&made.report, seconds));
            Some(row)
        })
        .collect();
    table::plain(&table::MATERIAL_HEADER, &rows)
}

fn dry_run(arguments: &Arguments, plan: &Plan, scene: String) -> Result<(), CliError> {
    if arguments.json {
        let materials = plan.jobs.iter().map(|job| Entry {
            material: job.name.clone(),
            pack: Some(pack_name(&job.name)),
            report: None,
            error: None,
            cached: None,
            stages: None,
        });
        let report = Report { version: 1, scene, materials: materials.collect(), skipped: plan.skipped.clone() };
        return print_json(&report);
    }
    let rows: Vec<Vec<String>> = plan
        .jobs
        .iter()
        .map(|job| {
            let r = &job.recipe;
            vec![
                job.name.clone(),
                job.uses.to_string(),
                format!("{0} x {0}", 1u32 << r.levels),
                format!("{} of {}", r.stored_levels, r.levels),
                r.bits.to_string(),
                match r.target {
                    Target::Ratio(ratio) => format!("{ratio}:1"),
                    Target::MaxError(error) => format!("ε_r at most {}", table::percent(error)),
                    Target::MaxBytes(bytes) => format!("at most {}", table::bytes(bytes)),
                },
                job.source.clone(),
                arguments.out.join(pack_name(&job.name)).display().to_string(),
            ]
        })
        .collect();
    let header = ["material", "uses", "grid", "levels", "bits", "target", "source", "pack"];
    let mut text = table::plain(&header, &rows);
    if !plan.skipped.is_empty() {
        text += &format!("not used by the scene: {}\n", plan.skipped.join(", "));
    }
    print(&text)
}
