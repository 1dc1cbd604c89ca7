//! Output files and folders, which never overwrite inputs.

use crate::error::Error;
use crate::write::write_atomic;
use brdfc_source::input_files::files_behind;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Writes a file atomically. A closed pipe is no error.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    match write_atomic(path, bytes) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|error| Error::write(path, &error)),
    }
}

/// Returns an error if the output is one of the input files, including files that inputs refer to. `option` names the output.
pub fn refuse_overwriting(option: &str, output: &Path, inputs: &[&Path]) -> Result<(), Error> {
    let Ok(target) = output.canonicalize() else { return Ok(()) };
    let is_it = |file: &PathBuf| file.canonicalize().is_ok_and(|path| path == target);
    if is_standard_input(&target) {
        let found = output.display();
        return Err(Error::usage(format!(
            "{option}: would overwrite {found}, which is read from stdin; choose another file"
        )));
    }
    if target.is_file() && inputs.iter().any(|input| files_behind(input).iter().any(is_it)) {
        let found = output.display();
        return Err(Error::usage(format!("{option}: would overwrite the input {found}; choose another file")));
    }
    Ok(())
}

/// True if standard input is redirected from this file.
#[cfg(unix)]
fn is_standard_input(path: &Path) -> bool {
    use std::os::fd::AsFd as _;
    use std::os::unix::fs::MetadataExt as _;
    let stdin = std::io::stdin().as_fd().try_clone_to_owned().map(std::fs::File::from);
    let same = |stdin: std::fs::Metadata, file: std::fs::Metadata| {
        stdin.is_file() && (stdin.dev(), stdin.ino()) == (file.dev(), file.ino())
    };
    stdin.and_then(|stdin| Ok(same(stdin.metadata()?, path.metadata()?))).unwrap_or(false)
}

/// Returns false: the standard library has no file identity on other systems.
#[cfg(not(unix))]
fn is_standard_input(_: &Path) -> bool {
    false
}

/// Applies [`refuse_overwriting`] to many outputs.
pub fn refuse_overwriting_any(
    option: &str,
    outputs: impl IntoIterator<Item = PathBuf>,
    inputs: &[&Path],
) -> Result<(), Error> {
    let targets: BTreeSet<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
    let over = |output: &PathBuf| output.canonicalize().is_ok_and(|path| targets.contains(&path));
    match outputs.into_iter().find(over) {
        Some(output) => refuse_overwriting(option, &output, inputs),
        None => Ok(()),
    }
}

/// Returns an error if an output folder is a file or a stream.
pub fn check_folder(path: &Path) -> Result<(), Error> {
    refuse_dash(path)?;
    if path.exists() && !path.is_dir() {
        return Err(Error::io(format!("{}: cannot write: not a folder; choose another name", path.display())));
    }
    Ok(())
}

/// Returns an error if a folder is `-`, which stands for a stream.
pub fn refuse_dash(path: &Path) -> Result<(), Error> {
    if path != Path::new("-") {
        return Ok(());
    }
    let text = "-: not a folder; for a folder of this name, write ./-";
    Err(Error::usage(text))
}

/// Creates an output folder if it is missing.
pub fn make_folder(path: &Path) -> Result<(), Error> {
    check_folder(path)?;
    std::fs::create_dir_all(path).map_err(|error| Error::write(path, &error))
}
