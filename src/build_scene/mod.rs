//! `brdfc build`: the main job.

mod arguments;
mod inputs;
mod pieces;
mod plan_text;
mod text;

pub use arguments::Arguments;
pub(super) use arguments::{BuildArguments, DEFAULT_FOLDER};
#[cfg(feature = "render")]
pub(super) use inputs::read_manifest;
pub(super) use inputs::{Asked, asked, listed, manifest_among};
pub(super) use text::verdict;

use super::output::{
    check_folder, make_folder, note, print, print_json, refuse_dash, refuse_overwriting, refuse_overwriting_any,
    remark, tell, write_file,
};
use super::progress::Materials;
use super::{CliError, Common, interrupt};
use brdfc_jobs::depfile::depfile;
use brdfc_jobs::encode::options::EncodeOptions;
use brdfc_jobs::output_folder::Changes;
use brdfc_jobs::report::build::BuildReport;
use brdfc_jobs::report::material::remarks;
use brdfc_jobs::scene::build::{Built, build};
use brdfc_jobs::scene::current::PackFolder;
use brdfc_jobs::scene::explain::explain;
use brdfc_jobs::scene::plan::{Job, Plan, REPORT};
use brdfc_jobs::scene::run::Made;
use brdfc_jobs::scene::scene_section::ENVIRONMENT;
use std::collections::BTreeMap;
use std::path::Path;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    let out = arguments.build.out.as_path();
    arguments.build.memory()?;
    check_folder(out)?;
    arguments.from.iter().try_for_each(|folder| refuse_dash(folder))?;
    let asked = asked_to_build(&arguments.build, &arguments.options, common)?;
    let plan = &asked.plan;
    if arguments.dry_run {
        return dry_run(arguments, plan, common);
    }

    let inputs = asked.files();
    if let Some(file) = &arguments.depfile {
        refuse_overwriting("--depfile", file, &inputs)?;
    }
    prepare(&asked, out)?;
    let interrupt = interrupt::watch()?;
    if arguments.shard.is_some() || !arguments.only.is_empty() {
        return pieces::run(arguments, plan, common, &interrupt);
    }
    let progress = Materials::of(plan, common, interrupt.flag());
    let mut built = build(plan, &arguments.settings(&interrupt)?, &progress)?;
    drop(progress);
    tell_what_matters(&built, common);
    if let Some(file) = &arguments.depfile {
        write_file(file, &depfile(&out.join(REPORT), &inputs))?;
    }
    if arguments.explain {
        let folder = PackFolder::looked_at(out);
        let kept = |job: &Job| folder.as_ref()?.known(job);
        built.report.needs = explain(plan, &built.outcomes.made().collect(), &kept);
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
    verdict(built.outcomes)?;
    arguments.write_stamp()
}

/// Says what would be done.
fn dry_run(arguments: &Arguments, plan: &Plan, common: Common) -> Result<(), CliError> {
    let folder = PackFolder::looked_at(&arguments.build.out).filter(|_| !arguments.no_cache);
    let known = |job: &Job| folder.as_ref()?.known(job);
    let known: BTreeMap<&str, Made> =
        plan.jobs.iter().filter_map(|job| Some((job.name.as_str(), known(job)?))).collect();
    let mut report = BuildReport::planned(plan, &known);
    if arguments.explain {
        let made = known.iter().map(|(name, made)| (*name, made)).collect();
        report.needs = explain(plan, &made, &|job| folder.as_ref()?.known(job));
    }
    if common.json {
        return print_json(&report);
    }
    print(&plan_text::text(plan, &report, &arguments.build.out))
}

/// What is asked for, which is something.
pub(super) fn asked_to_build(
    arguments: &BuildArguments,
    options: &EncodeOptions,
    common: Common,
) -> Result<Asked, CliError> {
    let asked = asked(&arguments.inputs, options, common)?;
    if asked.plan.is_empty() {
        return Err(CliError::Check(format!(
            "nothing to build: found {}, and no use of any, in {}; allowed one or more ([[uses]], material = \"...\")",
            match asked.plan.skipped.len() {
                1 => "one material".to_owned(),
                count => format!("{count} materials"),
            },
            listed(&arguments.inputs),
        )));
    }
    Ok(asked)
}

/// Makes the output folder, unless what goes there would be written over what is read.
pub(super) fn prepare(asked: &Asked, out: &Path) -> Result<(), CliError> {
    refuse_overwriting_any("--out", asked.plan.files().map(|file| out.join(file)), &asked.files())?;
    make_folder(out)
}

/// Failures and misses, and notes on what was made.
pub(super) fn tell_what_matters(built: &Built, common: Common) {
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
