//! `brdfc plan`: a build as a graph of jobs.

use super::build_scene::{DEFAULT_FOLDER, asked};
use super::output::{check_folder, print, print_json};
use super::{CliError, Common};
use brdfc_jobs::encode::options::EncodeOptions;
use brdfc_jobs::scene::graph::{Graph, Places};
use clap::{Args, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;

/// Print a build as a graph of jobs, for engines that run such graphs on many machines.
///
/// One job per material and part, which keeps what it makes in the store of the output folder, and one at the end that puts
/// all in place. The result has the bytes of one 'brdfc build'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc plan scene.toml --format ninja > build.ninja && ninja
  brdfc plan scene.toml --format json")]
pub struct Arguments {
    /// What 'brdfc build' takes: a manifest, or files, folders and patterns.
    #[arg(value_name = "SCENE.toml|DIR|FILE", required = true)]
    inputs: Vec<String>,
    /// Folder for packs and reports.
    #[arg(long, short, value_name = "DIR", default_value = DEFAULT_FOLDER)]
    out: PathBuf,
    /// What is printed.
    #[arg(long, value_enum)]
    format: Format,
    /// The program that jobs call.
    #[arg(long, value_name = "PATH", default_value = "brdfc")]
    program: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A file for ninja.
    Ninja,
    /// JSON (schema: 'brdfc schema plan').
    Json,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    check_folder(&arguments.out)?;
    if arguments.out.to_str().is_none() {
        let found = arguments.out.display();
        return Err(CliError::Usage(format!("--out: found {found}; allowed UTF-8: the name is a part of commands")));
    }
    let inputs: Vec<OsString> = arguments.inputs.iter().map(OsString::from).collect();
    let asked = asked(&inputs, &EncodeOptions::default(), common)?;
    if asked.plan.is_empty() {
        return Err(CliError::Check(format!(
            "nothing to build: found no use of any material in {}",
            arguments.inputs.join(", ")
        )));
    }
    let places = Places {
        program: arguments.program.clone(),
        inputs: arguments.inputs.clone(),
        manifest: asked.manifest,
        options: Vec::new(),
        out: arguments.out.clone(),
    };
    let graph = Graph::new(&asked.plan, &places);
    match arguments.format {
        Format::Json => print_json(&graph),
        Format::Ninja if common.json => {
            Err(CliError::Usage("--json: found with --format ninja; allowed with --format json".to_owned()))
        }
        Format::Ninja => print(&graph.ninja()),
    }
}
