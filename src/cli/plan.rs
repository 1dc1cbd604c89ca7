//! `brdfc plan`: prints a build as a graph of jobs.

use super::build_scene::tell_left_out;
use super::output::{check_folder, print, print_json};
use super::{Common, Error};
use brdfc::Build;
use brdfc::scene::{Graph, Places};
use clap::{Args, ValueEnum};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Print a build as a graph of jobs, for engines that run such graphs on many machines.
///
/// The graph has a job for each material and part, which writes its result to the store of the output folder
/// (.brdfc-cache), and a final job that moves all results into place. A single 'brdfc build' gives the same result,
/// byte for byte. Paths are relative to the current folder and must be UTF-8.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc plan scene.toml --format ninja > build.ninja && ninja
  brdfc plan scene.toml --format json")]
pub struct Arguments {
    /// Inputs of 'brdfc build', without its options: a manifest, or files, folders and patterns of measured materials,
    /// and synth: addresses.
    #[arg(value_name = "SCENE.toml|DIR|FILE", required = true)]
    inputs: Vec<OsString>,
    /// Folder for packs and reports (default: packs).
    #[arg(long, short, value_name = "DIR", default_value = Build::DEFAULT_FOLDER)]
    out: PathBuf,
    /// Format of the output; --json requires json.
    #[arg(long, value_enum)]
    format: Format,
    /// Path with which jobs call this program, if it is not in the PATH (default: brdfc).
    #[arg(long, value_name = "PATH", default_value = "brdfc")]
    program: OsString,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A file for ninja.
    Ninja,
    /// JSON (schema: 'brdfc schema plan').
    Json,
}

/// Returns a name for use in the commands of jobs.
fn in_commands(what: &str, name: &OsStr) -> Result<String, Error> {
    name.to_str().map(str::to_owned).ok_or_else(|| {
        let found = name.display();
        Error::wrong_usage(what, found, "UTF-8, because the name is part of commands ('brdfc build' accepts any name)")
    })
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    check_folder(&arguments.out)?;
    let inputs = arguments.inputs.iter().map(|input| in_commands("inputs", input)).collect::<Result<Vec<_>, _>>()?;
    let program = in_commands("--program", &arguments.program)?;
    in_commands("--out", arguments.out.as_os_str())?;
    let build = Build::from_inputs(&arguments.inputs)?;
    tell_left_out(&build, common);
    let plan = super::build_scene::plan(&build)?;
    let places = Places { program, inputs, manifest: build.manifest().map(Path::to_owned), out: arguments.out.clone() };
    let graph = Graph::new(&plan, &places);
    match arguments.format {
        Format::Json => print_json(&graph),
        Format::Ninja if common.json => {
            Err(Error::usage("--json does not apply to --format ninja, only to --format json"))
        }
        Format::Ninja => print(&graph.ninja()),
    }
}
