//! `brdfc verify`: checks that packs, folders and reports are intact.

use super::output::{print, print_json, printable, refuse_dash, remark};
use super::steps::Steps;
use super::{Common, Error};
use brdfc::verify::{CheckedFile, Checks};
use brdfc_terminal::words::{counted, counted_of};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Check that packs, folders of builds and reports are intact.
///
/// The program reads packs to their last texel, and compares packs and report.json with their checksums. It compares the files
/// that a report.json lists with their hashes, and the figures in report.json with each MATERIAL.json. It prints every file that
/// is missing, damaged or modified. The exit code is 1 if there are any, if the folder of a build has no report.json, or if a
/// folder contains nothing to verify.
///
/// To check whether errors are small enough, use the requirements of a build or report --against.
///
/// Schema of --json: 'verify'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc verify packs
  brdfc verify paint.ktx2 leather.ktx2
  brdfc verify packs/report.json --json")]
pub struct Arguments {
    /// Packs (.ktx2), folders of builds or of packs, a report.json, or a MATERIAL.json in such a folder.
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Checked files.
    files: Vec<CheckedFile>,
    /// Number of files that are missing, damaged or modified.
    faults: usize,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let mut checks = Checks::default();
    // Check the other paths even if one cannot be checked.
    let mut refused: Option<Error> = None;
    for path in &arguments.paths {
        if let Err(error) = refuse_dash(path).and_then(|()| checks.add(path)) {
            refused = Some(match refused {
                None => error,
                Some(earlier) => {
                    let text = format!("{earlier}\n{error}");
                    if error.kind() > earlier.kind() { error } else { earlier }.with_message(text)
                }
            });
        }
    }
    let cancelled = AtomicBool::new(false);
    let progress = Steps::new(common, &cancelled);
    let files = checks.run(&progress)?;
    drop(progress);
    let count = files.len();
    let faulty = |file: &CheckedFile| Some(format!("{}: {}\n", file.file, file.fault.as_ref()?));
    let lines: Vec<String> = files.iter().filter_map(faulty).collect();
    let faults = lines.len();
    if common.json {
        print_json(&Report { version: 1, files, faults })?;
    } else {
        print(&printable(&lines.concat()))?;
    }
    if let Some(error) = refused {
        return Err(error);
    }
    match faults {
        0 => {
            remark(common, &format!("{}: intact", counted(count, "file")));
            Ok(())
        }
        _ => Err(Error::check(format!("{} not intact", counted_of(faults, count, "file")))),
    }
}
