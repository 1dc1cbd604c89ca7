//! `brdfc build`: the main job.

mod arguments;
mod inputs;
mod pieces;
mod plan_text;
mod text;

pub use arguments::Arguments;
pub(super) use arguments::DEFAULT_FOLDER;
pub(super) use inputs::asked;
#[cfg(feature = "render")]
pub(super) use inputs::read_manifest;

use super::output::{
    make_folder, note, print, print_json, refuse_overwriting, refuse_overwriting_any, remark, tell, write_file,
};
use super::progress::Materials;
use super::{CliError, Common, interrupt};
use brdfc_jobs::depfile::depfile;
use brdfc_jobs::output_folder::Changes;
use brdfc_jobs::report::build::BuildReport;
use brdfc_jobs::report::material::remarks;
use brdfc_jobs::scene::build::{Built, build};
use brdfc_jobs::scene::current::PackFolder;
use brdfc_jobs::scene::explain::explain;
use brdfc_jobs::scene::memory;
use brdfc_jobs::scene::plan::{Job, Plan, REPORT};
use brdfc_jobs::scene::run::Made;
use brdfc_jobs::scene::scene_section::ENVIRONMENT;
use std::collections::BTreeMap;
use std::path::Path;

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
    let asked = asked(&arguments.inputs, &arguments.options, common)?;
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
        return dry_run(arguments, plan, common);
    }

    let inputs: Vec<&Path> = plan.sources().map(Path::new).chain(asked.manifest.as_deref()).collect();
    refuse_overwriting_any("--out", plan.files().map(|file| out.join(file)), &inputs)?;
    if let Some(file) = &arguments.depfile {
        refuse_overwriting("--depfile", file, &inputs)?;
    }
    make_folder(out)?;
    let interrupt = interrupt::watch()?;
    if arguments.shard.is_some() || !arguments.only.is_empty() {
        return pieces::run(arguments, plan, memory, common, &interrupt);
    }
    let total = plan.jobs.len() + usize::from(plan.environment.is_some());
    let progress = Materials::new(total, plan.environment.is_some(), common, interrupt.flag());
    let settings = arguments.settings(memory, &interrupt);
    let mut built = build(plan, &settings, &progress)?;
    drop(progress);
    tell_what_matters(&built, common);
    if let Some(file) = &arguments.depfile {
        write_file(file, depfile(&out.join(REPORT), &inputs).as_bytes())?;
    }
    if arguments.explain {
        built.report.needs = explain(plan, &built.outcomes.made().collect());
    }
    if common.json {
        print_json(&built.report)?;
    } else {
        print(&(text::text(&built.outcomes) + &plan_text::needs(&built.report.needs)))?;
    }
    if !plan.skipped.is_empty() {
        remark(common, &format!("not used by the scene, not opened: {}", plan.skipped.join(", ")));
    }
    match &built.changes {
        Some(changes) => tell_changes(changes, common),
        None => tell(&format!("brdfc: {} is as it was before", out.display())),
    }
    text::verdict(built.outcomes)?;
    arguments.write_stamp()
}

/// Says what would be done.
fn dry_run(arguments: &Arguments, plan: &Plan, common: Common) -> Result<(), CliError> {
    let folder = PackFolder::looked_at(&arguments.out).filter(|_| !arguments.no_cache);
    let known = |job: &Job| folder.as_ref()?.known(job);
    let known: BTreeMap<&str, Made> =
        plan.jobs.iter().filter_map(|job| Some((job.name.as_str(), known(job)?))).collect();
    let mut report = BuildReport::planned(plan, &known);
    if arguments.explain {
        report.needs = explain(plan, &known.iter().map(|(name, made)| (*name, made)).collect());
    }
    if common.json {
        return print_json(&report);
    }
    print(&plan_text::text(plan, &report, &arguments.out))
}

/// Failures and misses, and notes on what was made.
fn tell_what_matters(built: &Built, common: Common) {
    for outcome in &built.outcomes.materials {
        match &outcome.result {
            Ok(made) => {
                let of_map = made.maps.as_ref().and_then(|maps| maps.bandwidth.as_ref()?.facts.remark());
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
