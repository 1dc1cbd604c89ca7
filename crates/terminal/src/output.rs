//! Results on stdout, notes on stderr.

use super::{Common, Error};
use brdfc_core::words::one_of;
use brdfc_core::{Source, Tally};
use brdfc_jobs::ErrorKind;
use brdfc_jobs::output_folder::is_own;
pub use brdfc_jobs::outputs::{
    check_folder, make_folder, refuse_dash, refuse_overwriting, refuse_overwriting_any, write_file,
};
use brdfc_jobs::report::material::repairs_summary;
pub use brdfc_jobs::write::folder_of;
use brdfc_jobs::write::is_standard_output;
use brdfc_metrics::fit_error::undetermined;
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;
use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Prints text to stdout. A pipe that is closed early is not an error and does not end the program, because a later check
/// may still fail.
pub fn print(text: &str) -> Result<(), Error> {
    print_if_read(text).map(drop)
}

/// Prints text to stdout. Returns false if the reader has closed the pipe.
pub fn print_if_read(text: &str) -> Result<bool, Error> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(Error::write("stdout", &error)),
    }
}

/// Prints JSON to stdout.
pub fn print_json(value: &impl Serialize) -> Result<(), Error> {
    print(&to_json(value))
}

/// Formats JSON with a final newline.
pub fn to_json(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).expect("results are plain data") + "\n"
}

/// Returns the report as JSON if requested, otherwise this text.
pub fn json_or(common: Common, report: &impl Serialize, text: String) -> String {
    if common.json { to_json(report) } else { text }
}

/// Parses the single output file of a command; `-` is standard output.
pub fn output_parser() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|path| if path == Path::new("-") { PathBuf::from(STANDARD_OUTPUT) } else { path })
}

/// Returns true if the path is `-`.
const STANDARD_OUTPUT: &str = "/dev/stdout";

/// Returns true if a path is a device, a pipe or standard output, which have no extension. Folders fail when they are written.
pub fn is_stream(path: &Path) -> bool {
    is_standard_output(path) || path.metadata().is_ok_and(|m| !m.is_file())
}

/// Rejects an output that is also an input, cannot be written, or has the extension of another kind, before it is made.
pub fn refuse_unfit_output(path: &Path, allowed: &[&str], inputs: &[&Path]) -> Result<(), Error> {
    refuse_overwriting("--output", path, inputs)?;
    if is_stream(path) {
        return Ok(());
    }
    refuse_other_extension("--output", path, allowed).map_err(|error| {
        let text = format!("{error}, or - for stdout");
        error.with_message(text)
    })?;
    refuse_missing_folder(path)
}

/// Rejects a file whose name has none of the extensions.
pub fn refuse_other_extension(option: &str, path: &Path, allowed: &[&str]) -> Result<(), Error> {
    let is_one = |extension: &OsStr| allowed.iter().any(|allowed| extension.eq_ignore_ascii_case(allowed));
    if path.extension().is_some_and(is_one) {
        return Ok(());
    }
    let (found, allowed) = (path.display(), one_of(&allowed.iter().map(|name| format!(".{name}")).collect::<Vec<_>>()));
    Err(Error::usage(format!("{option}: found {found}, expected a name that ends in {allowed}")))
}

/// Rejects the first given flag that does not apply to `found`. Each flag has: whether it is given, its name, and what it
/// applies to.
pub fn refuse_flags(found: impl std::fmt::Display, flags: &[(bool, &str, &str)]) -> Result<(), Error> {
    match flags.iter().find(|(given, ..)| *given) {
        Some((_, flag, allowed)) => Err(Error::usage(format!("{flag} does not apply to {found}, only to {allowed}"))),
        None => Ok(()),
    }
}

/// Returns an error if the folder of a file does not exist.
pub fn refuse_missing_folder(path: &Path) -> Result<(), Error> {
    let folder = folder_of(path);
    if folder.exists() {
        return Ok(());
    }
    Err(Error::write(path, &std::io::Error::other(format!("there is no folder {}", folder.display()))))
}

/// Rejects outputs that are the same file, because the later one would overwrite the earlier one.
pub fn refuse_same_outputs(outputs: &[(&str, Option<&Path>)]) -> Result<(), Error> {
    let given: Vec<(&str, &Path)> = outputs.iter().filter_map(|(option, path)| Some((*option, (*path)?))).collect();
    for (at, (option, path)) in given.iter().enumerate() {
        if let Some((first, _)) = given[..at].iter().find(|(_, earlier)| place(earlier) == place(path)) {
            return Err(Error::usage(format!(
                "{first} and {option}: both are {}; choose different paths",
                path.display()
            )));
        }
    }
    Ok(())
}

/// Rejects a file with the path of one of the build's own files.
pub fn refuse_own(option: &str, file: &Path, out: &Path) -> Result<(), Error> {
    if is_own(&place(file), &place(out)) {
        let found = file.display();
        return Err(Error::usage(format!(
            "{option}: {found} is reserved for the build; choose another name or folder"
        )));
    }
    Ok(())
}

/// Canonical path, whether or not the file exists.
fn place(path: &Path) -> PathBuf {
    let parent = || Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?));
    let there = path.canonicalize().ok().or_else(parent);
    there.or_else(|| std::path::absolute(path).ok()).unwrap_or_else(|| path.to_owned())
}

/// Prints a line on stderr. Errors are ignored: a closed or full stderr does not end the program.
pub fn tell(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", printable(text));
}

/// Escapes control characters other than line ends, so that the contents of a file cannot control a terminal.
pub fn printable(text: &str) -> String {
    let escape = |c: char| if c.is_control() && c != '\n' { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(escape).collect()
}

/// Prints a line on stderr, unless quiet.
pub fn remark(common: Common, text: &str) {
    if !common.quiet {
        tell(text);
    }
}

/// Prints a note about an input: a repair, or a limitation of its figures.
pub fn note(common: Common, about: &impl std::fmt::Display, line: &str) {
    remark(common, &format!("note: {about}: {line}"));
}

/// Prints why the samples of a scan or a table do not determine its material.
pub fn note_gaps(common: Common, input: &impl std::fmt::Display, source: &dyn Source) {
    if let Some(why) = undetermined(source, source.directions()) {
        note(common, input, &format!("the samples do not determine the material: {why}"));
    }
}

/// Prints the directions of a source that does not cover all directions, and the gaps of a scan.
pub fn note_coverage(common: Common, input: &impl std::fmt::Display, source: &dyn Source) {
    note_gaps(common, input, source);
    let directions = source.directions();
    if !directions.is_all() {
        note(common, input, &format!("the pack covers {directions}; other directions use the nearest covered one"));
    }
}

/// Prints repairs of an input's values.
pub fn note_repairs(common: Common, input: &impl std::fmt::Display, repairs: &Tally) {
    repairs_summary(repairs).iter().for_each(|line| note(common, input, line));
}

/// Prints a report: to stdout, or to stderr if the output file goes to stdout.
pub fn print_report(common: Common, output: &Path, text: &str) -> Result<(), Error> {
    if is_standard_output(output) {
        remark(common, text.trim_end());
        return Ok(());
    }
    print(text)
}

/// Prefixes a usage error of the library with `--`, because settings have the names of flags.
pub fn as_flag(error: Error) -> Error {
    if error.kind() != ErrorKind::Usage {
        return error;
    }
    let text = format!("--{error}");
    error.with_message(text)
}
