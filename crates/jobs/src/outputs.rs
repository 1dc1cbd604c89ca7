//! Output files and folders, which never overwrite inputs.

use crate::error::Error;
use crate::store::{Staging, placing};
use crate::write::write_atomic;
use brdfc_readers::btf_stack::is_image;
use brdfc_source::btf_stack::images_of;
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

/// Returns an error if the output is one of the input files, including files that inputs refer to, or would become an image of
/// a BTF, whose folder is read whole. `option` names the output.
pub fn refuse_overwriting(option: &str, output: &Path, inputs: &[&Path]) -> Result<(), Error> {
    refuse_new_images(option, output, inputs)?;
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

/// Returns an error if the output, an image or a folder, is inside a BTF.
fn refuse_new_images(option: &str, output: &Path, inputs: &[&Path]) -> Result<(), Error> {
    if output.extension().is_some() && !is_image(&output.to_string_lossy()) {
        return Ok(());
    }
    let folder =
        std::path::absolute(output).ok().and_then(|path| path.ancestors().find_map(|at| at.canonicalize().ok()));
    let holds = |input: &&&Path| {
        let inside = |btf: PathBuf| folder.as_ref().is_some_and(|folder| folder.starts_with(btf));
        input.is_dir() && input.canonicalize().is_ok_and(inside) && !images_of(input).is_empty()
    };
    match inputs.iter().find(holds) {
        Some(btf) => Err(Error::usage(format!(
            "{option}: {} would be read as an image of {}; choose another folder",
            output.display(),
            btf.display()
        ))),
        None => Ok(()),
    }
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

/// Names the output folder in an error of writing.
pub type Failed<'a> = &'a (dyn Fn(std::io::Error) -> Error + Sync);

/// Fills a folder that exists: `write` fills another one, whose entries then move into it together. If it fails, or the process
/// ends before, the folder stays as it is.
pub fn fill_folder(path: &Path, write: impl FnOnce(&Path, Failed<'_>) -> Result<(), Error>) -> Result<(), Error> {
    let io = |error: std::io::Error| Error::write(path, &error);
    let staging = Staging::new(path).map_err(io)?;
    let whole = staging.path().join("whole");
    std::fs::create_dir(&whole).map_err(io)?;
    write(&whole, &io)?;
    let entries = std::fs::read_dir(&whole).and_then(Iterator::collect::<std::io::Result<Vec<_>>>).map_err(io)?;
    let _placing = placing();
    entries.iter().try_for_each(|entry| std::fs::rename(entry.path(), path.join(entry.file_name()))).map_err(io)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_filled_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let names = || std::fs::read_dir(out).unwrap().flatten().map(|entry| entry.file_name()).collect::<Vec<_>>();
        let failed = fill_folder(out, |whole, failed| {
            std::fs::write(whole.join("one.png"), "1").map_err(failed)?;
            Err(failed(std::io::Error::other("no space")))
        });
        assert!(failed.unwrap_err().to_string().contains("no space") && names().is_empty());
        fill_folder(out, |whole, failed| std::fs::write(whole.join("one.png"), "1").map_err(failed)).unwrap();
        assert_eq!(names(), ["one.png"]);
    }
}
