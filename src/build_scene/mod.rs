//! `brdfc build`: the main job.

mod report;

pub use report::Report;

use super::output::{make_folder, print, print_json, refuse_overwriting, remark, tell, to_json, write_file};
use super::progress::Materials;
use super::{CliError, Common, interrupt};
use crate::table;
use brdfc_jobs::encode::recipe::{Budget, PackRecipe};
use brdfc_jobs::report::material::remarks;
use brdfc_jobs::scene::manifest::Manifest;
use brdfc_jobs::scene::run::{Outcomes, Plan, pack_name, plan, run as run_jobs};
use brdfc_jobs::scene::scene_section::ENVIRONMENT;
use brdfc_source::read::{MAX_TEXT_BYTES, read_file};
use brdfc_table::recipe::Size;
use brdfc_wavelet::recipe::Target;
use clap::Args;
use std::path::{Path, PathBuf};

/// Make the packs that a scene needs.
///
/// The manifest names materials and the uses that a scene makes of them; docs/scene.md lists its keys. A material that
/// no use refers to is not even opened. Packs of an earlier build are kept where source, options and program are the
/// same. One material that fails does not stop the others.
///
/// Where the manifest names an environment that lights the scene (the key `environment` of `scene`), the maps of adaptive shading are
/// made too: how fast each material's lobes and the environment vary, and importance samples of the lobes.
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
}

/// What a build says of itself, in the folder of its packs.
const REPORT: &str = "report.json";

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    let path = &arguments.scene;
    let (_, manifest) = read_manifest(path)?;
    let plan = plan(&manifest, path.parent().unwrap_or(Path::new("")));
    let scene = manifest.scene.name.clone().unwrap_or_else(|| "scene".to_owned());
    if arguments.dry_run {
        return dry_run(arguments, common, &plan, &scene);
    }

    let inputs: Vec<&Path> = plan.sources().map(Path::new).chain([path.as_path()]).collect();
    for file in plan.files().chain([REPORT.to_owned()]) {
        refuse_overwriting("--out", &arguments.out.join(file), &inputs)?;
    }
    make_folder(&arguments.out)?;
    let cancelled = interrupt::watch()?;
    let total = plan.jobs.len() + usize::from(plan.environment.is_some());
    let progress = Materials::new(total, plan.environment.is_some(), common, &cancelled);
    let outcomes = run_jobs(&plan, &arguments.out, !arguments.no_cache, &progress);
    drop(progress);

    for outcome in &outcomes.materials {
        match &outcome.result {
            Ok(made) => {
                let of_map = made.maps.as_ref().and_then(|maps| maps.bandwidth.facts.remark());
                for line in remarks(&made.report).into_iter().chain(of_map) {
                    remark(common, &format!("note: {}: {line}", outcome.name));
                }
                if let Some(missed) = &made.report.missed {
                    tell(&format!("brdfc: {}: {missed}", outcome.name));
                }
            }
            Err(error) => tell(&format!("brdfc: {}: {error}", outcome.name)),
        }
    }
    if let Some(Err(error)) = &outcomes.environment {
        tell(&format!("brdfc: {ENVIRONMENT}: {error}"));
    }
    let lasting = to_json(&Report::new(&scene, &plan, &outcomes).lasting(&plan, &arguments.out));
    write_file(&arguments.out.join(REPORT), lasting.as_bytes())?;
    if common.json {
        print_json(&Report::new(&scene, &plan, &outcomes))?;
    } else {
        print(&report::text(&outcomes))?;
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
fn worst(outcomes: Outcomes) -> Result<(), CliError> {
    let count = outcomes.materials.len();
    let missed = outcomes.materials.iter().filter_map(|o| o.result.as_ref().ok()?.report.missed.as_ref()).count();
    let environment = outcomes.environment.and_then(Result::err);
    let failures = outcomes.materials.into_iter().filter_map(|o| o.result.err());
    let mut failures: Vec<CliError> = failures.map(CliError::from).collect();
    let mut failed = Vec::new();
    if !failures.is_empty() {
        failed.push(format!("{} of {count} materials failed", failures.len()));
    }
    if missed > 0 {
        failed.push(format!("{missed} of {count} materials missed their budget"));
        failures.push(CliError::Check(String::new()));
    }
    if let Some(error) = environment {
        failed.push("the environment failed".to_owned());
        failures.push(error.into());
    }
    let Some(first) = failures.into_iter().max_by_key(|error| error.exit_code()) else { return Ok(()) };
    let summary = failed.join(", ");
    Err(match first {
        CliError::Check(_) => CliError::Check(summary),
        CliError::Usage(_) => CliError::Usage(summary),
        CliError::Input(_) => CliError::Input(summary),
        CliError::Io(_) => CliError::Io(summary),
        other => other,
    })
}

fn dry_run(arguments: &Arguments, common: Common, plan: &Plan, scene: &str) -> Result<(), CliError> {
    if common.json {
        return print_json(&Report::planned(scene, plan));
    }
    let rows: Vec<Vec<String>> = plan
        .jobs
        .iter()
        .map(|job| {
            vec![
                job.name.clone(),
                job.uses.to_string(),
                codec(&job.recipe).to_owned(),
                target(&job.recipe),
                job.source.clone(),
                arguments.out.join(pack_name(&job.name)).display().to_string(),
            ]
        })
        .collect();
    let header = ["material", "uses", "codec", "target", "source", "pack"];
    let mut text = table::plain(&header, &rows);
    if let Some(job) = &plan.environment {
        let map = arguments.out.join(report::environment_file()).display().to_string();
        text += &format!("lit by {}: {map}, and a bandwidth map and importance samples of each material\n", job.source);
    }
    if !plan.skipped.is_empty() {
        text += &format!("not used by the scene: {}\n", plan.skipped.join(", "));
    }
    print(&text)
}

fn codec(recipe: &PackRecipe) -> &'static str {
    match recipe {
        PackRecipe::Auto(_) => "auto",
        PackRecipe::Table(_) => "table",
        PackRecipe::Wavelet(_) => "wavelet",
    }
}

/// What a pack is made to, in words.
fn target(recipe: &PackRecipe) -> String {
    match recipe {
        PackRecipe::Auto(recipe) => budget(&recipe.budget),
        PackRecipe::Table(recipe) => match recipe.size {
            Size::Bytes(bytes) => format!("at most {}", table::bytes(bytes)),
            Size::Nodes(axes) => format!("{} x {} x {} x {}", axes.half, axes.difference, axes.azimuth, axes.layers),
        },
        PackRecipe::Wavelet(recipe) => {
            let target = match recipe.target {
                Target::Ratio(ratio) => format!("{ratio}:1"),
                Target::MaxError(error) => format!("ε_r at most {}", table::percent(error)),
                Target::MaxBytes(bytes) => format!("at most {}", table::bytes(bytes)),
            };
            let (grid, stored, levels) = (1u32 << recipe.levels, recipe.stored_levels, recipe.levels);
            format!("{target}, {grid} x {grid}, {stored} of {levels} levels, {} bits", recipe.bits)
        }
    }
}

fn budget(budget: &Budget) -> String {
    let limits = [
        budget.delta_e.map(|limit| format!("ΔE at most {limit}")),
        budget.error.map(|limit| format!("ε_r at most {}", table::percent(limit))),
        budget.bytes.map(|limit| format!("at most {}", table::bytes(limit))),
        budget.fetches.map(|limit| format!("at most {limit} fetches")),
    ];
    limits.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
