//! `brdfc verify`: whether packs, folders and reports are whole.

use super::output::{print, print_json, printable, refuse_dash, remark};
use super::steps::Steps;
use super::{Common, Error};
use brdfc::verify::{CheckedFile, Checks};
use brdfc_terminal::words::counted;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Check that packs, folders of builds and reports are whole.
///
/// Packs are read to their last texel and held against their checksum, and so is a report.json. The files that it lists are held
/// against their hashes, and its figures against those of each MATERIAL.json. A file that is missing, damaged or changed is printed,
/// and is exit code 1; so are a folder of a build without its report.json and a folder with nothing to check.
///
/// Whether errors are small enough is what the gates of a build, and report --against, are for.
///
/// Schema of --json: 'verify'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc verify packs
  brdfc verify paint.ktx2 leather.ktx2
  brdfc verify packs/report.json --json")]
pub struct Arguments {
    /// Packs (.ktx2), folders of builds or of packs, a report.json or MATERIAL.json in such a folder.
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
}

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Every file that was checked.
    files: Vec<CheckedFile>,
    /// How many of them are missing, damaged or changed.
    faults: usize,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let mut checks = Checks::default();
    // A path that cannot be checked is no reason to leave out the others.
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
            remark(common, &format!("{}: whole", counted(count, "file")));
            Ok(())
        }
        _ => Err(Error::check(format!("{faults} of {} not whole", counted(count, "file")))),
    }
}
