//! `brdfc build`: the main job.

mod inputs;
mod plan_text;
mod text;

pub(super) use inputs::read_manifest;

use super::output::{
    make_folder, note, print, print_json, refuse_overwriting, refuse_overwriting_any, remark, tell, write_file,
};
use super::progress::Materials;
use super::{CliError, Common, interrupt};
use brdfc_jobs::depfile::depfile;
use brdfc_jobs::encode::bytes_from_text;
use brdfc_jobs::encode::options::EncodeOptions;
use brdfc_jobs::output_folder::Changes;
use brdfc_jobs::report::build::BuildReport;
use brdfc_jobs::report::material::remarks;
use brdfc_jobs::scene::build::{BuildSettings, Built, build};
use brdfc_jobs::scene::memory;
use brdfc_jobs::scene::plan::REPORT;
use brdfc_jobs::scene::scene_section::ENVIRONMENT;
use clap::Args;
use std::path::{Path, PathBuf};

/// Make the packs that a scene needs, or those of a folder of measured materials.
///
/// A manifest names materials and the uses that a scene makes of them; docs/scene.md lists its keys. A material that no
/// use refers to is not even opened. Of folders, files and patterns each material is made, named after its file.
///
/// What was made before of the same source by the same options is kept. One material that fails does not stop the
/// others. The output folder changes at the end, all at once, and then holds what report.json says, besides what
/// others put there. An encoding option wins over the defaults of a manifest, not over what a material says of itself.
///
/// Where the manifest names an environment that lights the scene (the key `environment` of `scene`), the maps of adaptive shading are
/// made too: how fast each material's lobes and the environment vary, and importance samples of the lobes.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc build scene.toml
  brdfc build scans --out packs
  brdfc build scans/*.binary paint.brdf --max-delta-e 1
  brdfc build scene.toml --out assets/packs --jobs 4 --json > report.json
  brdfc build scene.toml --dry-run")]
pub struct Arguments {
    /// A scene manifest; or files, folders and patterns of measured materials, and synth: addresses.
    #[arg(value_name = "SCENE.toml|DIR|FILE", required = true)]
    inputs: Vec<String>,
    /// Folder for packs and reports.
    #[arg(long, short, value_name = "DIR", default_value = DEFAULT_FOLDER)]
    out: PathBuf,
    /// Say what would be done, and do nothing.
    #[arg(long)]
    dry_run: bool,
    /// Make every pack again.
    #[arg(long)]
    no_cache: bool,
    /// Leave files of earlier builds in the folder that this one does not need.
    #[arg(long)]
    keep: bool,
    /// Replace files that no build wrote where packs have their names.
    #[arg(long)]
    force: bool,
    /// Stop at the first material that fails or misses a limit, and leave the folder as it was.
    #[arg(long)]
    fail_fast: bool,
    /// Memory that the materials which are worked on may take together, such as 2GiB (default: 300 MiB for each thread).
    /// Fewer are worked on at a time where that is needed.
    #[arg(long, value_name = "B", value_parser = bytes_from_text)]
    memory: Option<u64>,
    /// Write the files that the report depends on, as a rule for make or ninja.
    #[arg(long, value_name = "FILE")]
    depfile: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Encoding")]
    options: EncodeOptions,
}

/// Where packs go if nothing is said.
pub(super) const DEFAULT_FOLDER: &str = "packs";
/// Less is not enough for one material.
const LEAST_MEMORY: u64 = 64 << 20;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    let out = arguments.out.as_path();
    let memory = match arguments.memory {
        Some(bytes) if bytes < LEAST_MEMORY => {
            return Err(CliError::Usage(format!("--memory: found {bytes} bytes; allowed 64MiB or more")));
        }
        Some(bytes) => bytes,
        None => memory::PER_THREAD * rayon::current_num_threads() as u64,
    };
    let asked = inputs::asked(&arguments.inputs, &arguments.options, common)?;
    let plan = &asked.plan;
    if plan.is_empty() {
        return Err(CliError::Check(format!(
            "nothing to build: found {}, and no use of any, in {}; allowed one or more ([[uses]], material = \"...\")",
            match plan.skipped.len() {
                1 => "one material".to_owned(),
                count => format!("{count} materials"),
            },
            arguments.inputs.join(", "),
        )));
    }
    if arguments.dry_run {
        if common.json {
            return print_json(&BuildReport::planned(plan));
        }
        return print(&plan_text::text(plan, out));
    }

    let inputs: Vec<&Path> = plan.sources().map(Path::new).chain(asked.manifest.as_deref()).collect();
    refuse_overwriting_any("--out", plan.files().map(|file| out.join(file)), &inputs)?;
    if let Some(file) = &arguments.depfile {
        refuse_overwriting("--depfile", file, &inputs)?;
    }
    make_folder(out)?;
    let interrupt = interrupt::watch()?;
    let total = plan.jobs.len() + usize::from(plan.environment.is_some());
    let progress = Materials::new(total, plan.environment.is_some(), common, interrupt.flag());
    let settings = BuildSettings {
        out,
        looks_up: !arguments.no_cache,
        keep: arguments.keep,
        force: arguments.force,
        fail_fast: arguments.fail_fast,
        memory,
        placing: interrupt.placing(),
    };
    let built = build(plan, &settings, &progress)?;
    drop(progress);
    tell_what_matters(&built, common);
    if let Some(file) = &arguments.depfile {
        write_file(file, depfile(&out.join(REPORT), &inputs).as_bytes())?;
    }
    if common.json {
        print_json(&built.report)?;
    } else {
        print(&text::text(&built.outcomes))?;
    }
    if !plan.skipped.is_empty() {
        remark(common, &format!("not used by the scene, not opened: {}", plan.skipped.join(", ")));
    }
    match &built.changes {
        Some(changes) => tell_changes(changes, common),
        None => tell(&format!("brdfc: {} is as it was before", out.display())),
    }
    text::verdict(built.outcomes)
}

/// Failures and misses, and notes on what was made.
fn tell_what_matters(built: &Built, common: Common) {
    for outcome in &built.outcomes.materials {
        match &outcome.result {
            Ok(made) => {
                let of_map = made.maps.as_ref().and_then(|maps| maps.bandwidth.facts.remark());
                for line in remarks(&made.report).into_iter().chain(of_map) {
                    note(common, &outcome.name, &line);
                }
                let closed = made.gates.iter().filter(|gate| !gate.passed).map(ToString::to_string);
                for line in made.report.missed.iter().cloned().chain(closed) {
                    tell(&format!("brdfc: {}: {line}", outcome.name));
                }
            }
            Err(error) if text::is_cancelled(error) => {}
            Err(error) => tell(&format!("brdfc: {}: {error}", outcome.name)),
        }
    }
    if let Some(Err(error)) = &built.outcomes.environment {
        tell(&format!("brdfc: {ENVIRONMENT}: {error}"));
    }
}

fn tell_changes(changes: &Changes, common: Common) {
    for (what, names) in [
        ("removed, as this build does not need them", &changes.removed),
        ("not needed, but changed by somebody since they were built, and left", &changes.left),
    ] {
        if !names.is_empty() {
            remark(common, &format!("{what}: {}", names.join(", ")));
        }
    }
}
