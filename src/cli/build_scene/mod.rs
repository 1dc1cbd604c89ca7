//! `brdfc build`: the main job.

mod arguments;
mod pieces;
mod plan_text;
mod text;

pub use arguments::Arguments;
pub(super) use arguments::BuildArguments;

use super::options::{flag_of, key_and_flag_of};
use super::output::{
    check_folder, json_or, note, print, refuse_dash, refuse_missing_folder, refuse_overwriting, refuse_own,
    refuse_same_outputs, remark, tell, write_file,
};
use super::progress::Materials;
use super::{Common, Error, interrupt};
use brdfc::encode::remarks;
use brdfc::scene::{PackFolder, REPORT, depfile};
use brdfc::{Build, BuildReport, Built, Changes, Plan};
use brdfc_terminal::words::{counted, join_truncated};
use std::path::Path;

/// Maximum number of file names in a line.
const MAX_NAMED_FILES: usize = 5;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let out = arguments.build.out.as_path();
    check_folder(out)?;
    for folder in &arguments.from {
        refuse_dash(folder)?;
        if !PackFolder::is_one(folder) {
            let found = folder.display();
            return Err(Error::io(format!("--from: found {found}, expected a folder that 'brdfc build' filled")));
        }
    }
    let build = arguments.build()?;
    tell_left_out(&build, common);
    let plan = &plan(&build)?;
    if build.ignores_options(plan) {
        let text = "options of encoding and reading, and --environment, apply to materials, and this build has none; other assets have \
                    their options in a manifest, and as flags of 'brdfc pwt' and 'brdfc environment'";
        return Err(Error::usage(text));
    }
    if arguments.dry_run {
        let report = build.predict(plan, arguments.explain);
        return print(&json_or(common, &report, plan_text::text(plan, &report, out)));
    }

    let inputs = build.files_of(plan);
    build.prepare(plan)?;
    check_side_outputs(arguments, &inputs)?;
    interrupt::watch()?;
    if arguments.shard.is_some() || !arguments.only.is_empty() {
        return pieces::run(arguments, &build, plan, common);
    }
    let progress = Materials::of(plan, common);
    let mut built = build.run_with(plan, &progress)?;
    drop(progress);
    print_diagnostics(&build, &built, common, true);
    if let Some(file) = &arguments.depfile {
        write_file(file, &depfile(&out.join(REPORT), &inputs))?;
    }
    if arguments.explain {
        built.report.needs = build.explain(plan, &built.outcomes);
    }
    let text = text::text(plan, &built.outcomes) + &plan_text::needs(&built.report.needs);
    print(&json_or(common, &built.report, text))?;
    if !plan.skipped.is_empty() {
        remark(
            common,
            &format!("not used by the scene and not opened: {}", join_truncated(&plan.skipped, plan_text::MAX_NAMED)),
        );
    }
    match &built.changes {
        Some(changes) => tell_changes(changes, &built.report, common),
        None => tell(&format!("brdfc: {} is unchanged", out.display())),
    }
    built.outcomes.verdict()?;
    arguments.write_stamp()
}

/// Plans a build. Errors name options by their flags; with a manifest, which has the same options, by keys and flags.
pub(super) fn plan(build: &Build) -> Result<Plan, Error> {
    build.plan().map_err(|error| error.name_options(option_names(build)))
}

/// Names of options in messages of a build.
fn option_names(build: &Build) -> fn(&str) -> String {
    if build.manifest().is_some() { key_and_flag_of } else { flag_of }
}

/// Checks that `--depfile` and `--stamp` overwrite no input and no other output.
fn check_side_outputs(arguments: &Arguments, inputs: &[&Path]) -> Result<(), Error> {
    let out = arguments.build.out.as_path();
    let files = [("--depfile", arguments.depfile.as_deref()), ("--stamp", arguments.stamp.as_deref())];
    refuse_same_outputs(&files)?;
    for (option, file) in files.into_iter().filter_map(|(option, file)| Some((option, file?))) {
        if file == Path::new("-") {
            return Err(Error::wrong_usage(option, "-", "a file; write ./- for a file of this name"));
        }
        refuse_overwriting(option, file, inputs)?;
        refuse_own(option, file, out)?;
    }
    arguments.depfile.as_deref().map_or(Ok(()), refuse_missing_folder)
}

/// Prints what the build skips in the given folders.
pub(super) fn tell_left_out(build: &Build, common: Common) {
    let names: Vec<String> = build.left_out().iter().map(|path| path.display().to_string()).collect();
    if !names.is_empty() {
        remark(common, &format!("skipped: {}", join_truncated(&names, MAX_NAMED_FILES)));
    }
}

/// Prints failures, missed limits, and notes on materials of this build. With `count_cached` it also prints how many
/// cached materials have notes.
pub(super) fn print_diagnostics(build: &Build, built: &Built, common: Common, count_cached: bool) {
    let mut cached = 0;
    for (name, made) in built.outcomes.made() {
        let of_map = made.maps.as_ref().and_then(|maps| maps.bandwidth.as_ref()?.facts.remark());
        let lines: Vec<String> = remarks(&made.report).into_iter().chain(of_map).collect();
        if made.times.is_none() {
            cached += usize::from(!lines.is_empty());
        } else {
            lines.iter().for_each(|line| note(common, &name, line));
        }
    }
    for outcome in &built.outcomes.assets {
        let Ok(made) = &outcome.result else { continue };
        if made.times.is_some() {
            made.report.notes.iter().for_each(|line| note(common, &outcome.name, line));
        } else {
            cached += usize::from(!made.report.notes.is_empty());
        }
    }
    if count_cached && cached > 0 {
        let verb = if cached == 1 { "has" } else { "have" };
        let noun = if built.outcomes.assets.is_empty() { "material" } else { "asset" };
        let which = format!("{} from the cache {verb}", counted(cached, noun));
        remark(common, &format!("note: {which} notes; 'brdfc report' lists them"));
    }
    for line in built.outcomes.problems() {
        tell(&format!("brdfc: {}", line.named(option_names(build))));
    }
}

fn tell_changes(changes: &Changes, report: &BuildReport, common: Common) {
    let materials = report.materials.iter().filter(|entry| entry.retained).map(|entry| entry.material.clone());
    let assets = report.assets.iter().filter(|entry| entry.retained).map(|entry| entry.asset.clone());
    let retained = materials.chain(assets).collect();
    for (what, names) in [
        ("retained from earlier builds", &retained),
        ("removed, not part of this build", &changes.removed),
        ("not part of this build, but modified since they were built and therefore retained", &changes.left),
    ] {
        if !names.is_empty() {
            remark(common, &format!("{what}: {}", names.join(", ")));
        }
    }
}
