//! Parts of a build, for builds on several machines.

use super::arguments::Arguments;
use super::option_names;
use crate::output::{print, tell};
use crate::progress::Materials;
use crate::{Common, Error};
use brdfc::scene::Work;
use brdfc::{Build, Plan};
use brdfc_terminal::words::{counted_of, one_of, quoted};

pub(super) fn run(arguments: &Arguments, build: &Build, plan: &Plan, common: Common) -> Result<(), Error> {
    if common.json {
        return Err(Error::usage("--json does not apply to --shard and --only, which print no report"));
    }
    let works = selected(arguments, plan)?;
    let progress = Materials::new(works.len(), plan.environment.is_some(), common);
    let results = build.run_works(&works, &progress)?;
    drop(progress);
    let count = works.len();
    let mut text = String::new();
    let mut failures = Vec::new();
    for (work, result) in works.iter().zip(results) {
        match result {
            Ok(made) => text += &format!("{}: {}\n", work.name(), if made { "built" } else { "cached" }),
            Err(error) => {
                let error = error.name_options(option_names(build));
                tell(&format!("brdfc: {}: {error}", work.name()));
                failures.push(error);
            }
        }
    }
    print(&text)?;
    let failed = format!("{} failed", counted_of(failures.len(), count, "part"));
    match failures.into_iter().max_by_key(Error::kind) {
        None => arguments.write_stamp(),
        Some(worst) => Err(worst.with_message(failed)),
    }
}

/// Selects the parts of the shard, or the named parts.
fn selected<'a>(arguments: &Arguments, plan: &'a Plan) -> Result<Vec<Work<'a>>, Error> {
    let works = plan.works();
    if let Some(shard) = arguments.shard {
        return Ok(shard.of(works));
    }
    let named = |name: &String| {
        let found = works.iter().find(|work| work.name() == *name).copied();
        found.ok_or_else(|| {
            let names: Vec<String> = works.iter().map(Work::name).collect();
            Error::wrong_usage("--only", quoted(name), one_of(&names))
        })
    };
    arguments.only.iter().map(named).collect()
}
