//! Atomic writes of files.

use crate::store::{PREFIX, SUFFIX};
use brdfc_source::kind::BUILD_REPORT;
use std::io::Write;
use std::path::Path;

/// Returns true if a path is a name of standard output.
pub fn is_standard_output(path: &Path) -> bool {
    ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].into_iter().any(|name| path == Path::new(name))
}

/// Returns the folder, or `.` for an empty path.
pub fn or_here(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// The folder that contains a file.
pub fn folder_of(file: &Path) -> &Path {
    or_here(file.parent().unwrap_or(Path::new("")))
}

/// The folder of a build that is named by its report; any other path itself.
pub fn build_folder(path: &Path) -> &Path {
    if path.file_name().is_some_and(|name| name == BUILD_REPORT) { folder_of(path) } else { path }
}

/// Writes `bytes` to a temporary file next to `path`, then renames it. Devices and pipes are written to directly. A
/// link stays, and its target is replaced.
///
/// # Errors
/// Returns an error if the folder does not exist, the path is a folder, or the file cannot be written.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if is_standard_output(path) {
        // Standard output may be a file that other programs also write to: it is neither replaced nor truncated.
        let mut stdout = std::io::stdout().lock();
        return stdout.write_all(bytes).and_then(|()| stdout.flush());
    }
    let is_device = path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir());
    if is_device || path.starts_with("/dev/fd") || path.starts_with("/proc") || path == Path::new("/dev/stderr") {
        return std::fs::OpenOptions::new().write(true).open(path)?.write_all(bytes);
    }
    let target = if path.is_symlink() { std::fs::canonicalize(path)? } else { path.to_owned() };
    let path = target.as_path();
    if path.is_dir() {
        return Err(std::io::Error::from(std::io::ErrorKind::IsADirectory));
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        let text = format!("there is no folder {}", folder.display());
        return Err(std::io::Error::new(std::io::ErrorKind::NotFound, text));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder).map_err(of_target)?;
    // A locked file is in use: other processes do not remove it as abandoned.
    let _ = file.as_file().try_lock();
    file.write_all(bytes).map_err(of_target)?;
    file.flush().map_err(of_target)?;
    file.persist(path).map_err(|error| of_target(error.error))?;
    Ok(())
}

/// Removes the name of the temporary file from an error, which would not help the user.
fn of_target(error: std::io::Error) -> std::io::Error {
    if error.raw_os_error().is_some() {
        return error;
    }
    // The library has no other access to the system's message, which precedes the name.
    let text = error.to_string();
    std::io::Error::new(error.kind(), text.split(" at path ").next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_and_no_temporary_file_remains() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pack.ktx2");
        write_atomic(&path, b"first").unwrap();
        write_atomic(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert!(write_atomic(&folder.path().join("no/such/folder"), b"x").is_err());
        assert!(write_atomic(folder.path(), b"x").is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn errors_name_no_temporary_file() {
        let error = std::io::Error::new(std::io::ErrorKind::StorageFull, "full at path \"/x/.brdfc-1.tmp\"");
        assert!(!of_target(error).to_string().contains(".tmp"));
    }

    /// `/dev/full` through a temporary file that names itself in its errors.
    #[test]
    #[cfg(target_os = "linux")]
    fn errors_have_the_message_of_the_system() {
        let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let plain = full().write_all(b"x").unwrap_err();
        let mut named =
            tempfile::NamedTempFile::from_parts(full(), tempfile::TempPath::try_from_path("/nowhere/x.tmp").unwrap());
        let named = named.write_all(b"x").unwrap_err();
        assert!(named.to_string().contains("x.tmp"), "{named}");
        assert_eq!(of_target(named).to_string(), plain.to_string());
    }

    #[test]
    #[cfg(unix)]
    fn links_remain_links() {
        let folder = tempfile::tempdir().unwrap();
        let (link, target) = (folder.path().join("link"), folder.path().join("target"));
        std::os::unix::fs::symlink(&target, &link).unwrap();
        assert!(write_atomic(&link, b"x").is_err(), "a link to nothing");
        std::fs::write(&target, b"old").unwrap();
        write_atomic(&link, b"new").unwrap();
        assert!(link.is_symlink() && !target.is_symlink());
        assert_eq!(std::fs::read(&target).unwrap(), b"new");
    }
}
