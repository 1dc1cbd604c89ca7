//! Reads files within limits, which are checked before memory is allocated.

use super::error::InputError;
use brdfc_core::words::bytes;
use brdfc_formats::FormatError;
use brdfc_formats::memory::reserved;
use std::fs::File;
use std::io::{Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// Maximum size of an input file, bytes. Its decoded form takes at most a few times as much memory.
pub const MAX_FILE_BYTES: u64 = 2 << 30;
/// Maximum size of a text file that people write, such as manifests and lists of directions, bytes.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Observer of file reads.
pub trait ReadListener {
    /// Called when a file was opened, before the first call of [`Self::bytes`]. Its length in bytes is 0 for pipes that
    /// are not read ahead.
    ///
    /// # Errors
    /// Returns an error if the file must not be read, for example because it is too large.
    fn opened(&mut self, _file: &File, _length: u64) -> Result<(), FormatError> {
        Ok(())
    }

    /// Called with bytes of the file, in the order of reading: the order is the same for all files of a kind and
    /// length.
    fn bytes(&mut self, _bytes: &[u8]) {}
}

/// Ignores all events.
impl ReadListener for () {}

/// A file whose bytes a listener observes.
pub(crate) struct ObservedFile<'a> {
    file: Opened,
    listener: &'a mut dyn ReadListener,
}

/// A file, or all bytes of a pipe.
enum Opened {
    File(File),
    Pipe(Cursor<Vec<u8>>),
}

impl Read for ObservedFile<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = match &mut self.file {
            Opened::File(file) => file.read(buffer)?,
            Opened::Pipe(bytes) => bytes.read(buffer)?,
        };
        self.listener.bytes(&buffer[..count]);
        Ok(count)
    }
}

impl Seek for ObservedFile<'_> {
    fn seek(&mut self, position: SeekFrom) -> std::io::Result<u64> {
        match &mut self.file {
            Opened::File(file) => file.seek(position),
            Opened::Pipe(bytes) => bytes.seek(position),
        }
    }
}

/// Same as [`open_path`], with an observer. Pipes are read ahead to their end, because they have no length and cannot
/// seek.
pub(crate) fn open_observed<'a>(
    path: &Path,
    listener: &'a mut dyn ReadListener,
) -> Result<(ObservedFile<'a>, u64), InputError> {
    let (file, length) = open_path(path)?;
    let is_file = file.metadata().is_ok_and(|metadata| metadata.is_file());
    let pipe = if is_file { None } else { Some(read_within(path, &file, 0, MAX_FILE_BYTES)?) };
    let length = pipe.as_ref().map_or(length, |bytes| bytes.len() as u64);
    listener.opened(&file, length).map_err(|error| InputError::format(path, error))?;
    let file = pipe.map_or_else(|| Opened::File(file), |bytes| Opened::Pipe(Cursor::new(bytes)));
    Ok((ObservedFile { file, listener }, length))
}

/// Opens a file or a pipe, but no folder and no device. The length is 0 for pipes.
pub(crate) fn open_path(path: &Path) -> Result<(File, u64), InputError> {
    let io = |error: std::io::Error| {
        if error.kind() == ErrorKind::NotFound && path.is_symlink() {
            let text = "the target of this link does not exist";
            return InputError::io(path, std::io::Error::new(error.kind(), text));
        }
        InputError::io(path, error)
    };
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if metadata.is_dir() {
        return Err(InputError::format(path, FormatError::whole("file", "a folder", "a file or a pipe")));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = metadata.file_type();
        if kind.is_char_device() || kind.is_block_device() {
            let error = FormatError::whole("file", "a device", "a file or a pipe");
            return Err(InputError::format(path, error));
        }
    }
    Ok((file, metadata.len()))
}

/// Reads a file or a pipe to its end, at most `limit` bytes.
///
/// # Errors
/// Returns an error for unreadable files, folders, devices, and files with more bytes.
pub fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    read_file_observed(path, limit, &mut ())
}

/// Same as [`read_file`] for files of a build, which are not pipes: a pipe may never have a writer.
///
/// # Errors
/// Returns the errors of [`read_file`], and one for pipes.
pub fn read_regular_file(path: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    let metadata = path.metadata().map_err(|error| InputError::io(path, error))?;
    if !metadata.is_file() && !metadata.is_dir() {
        return Err(InputError::format(path, FormatError::whole("file", "a pipe or a device", "a file")));
    }
    read_file(path, limit)
}

/// Reads a file or a pipe to its end, at most `limit` bytes, and passes the bytes to an observer.
///
/// # Errors
/// Returns an error for unreadable files, folders, devices, and files with more bytes.
pub fn read_file_observed(path: &Path, limit: u64, listener: &mut dyn ReadListener) -> Result<Vec<u8>, InputError> {
    let (file, length) = open_path(path)?;
    listener.opened(&file, length).map_err(|error| InputError::format(path, error))?;
    read_within(path, ObservedFile { file: Opened::File(file), listener }, length, limit)
}

/// Reads a text file or a pipe to its end, or through the first NUL byte. Parsers reject the NUL byte.
///
/// # Errors
/// Same as [`read_file`], with [`MAX_FILE_BYTES`] as the limit.
pub fn read_text(path: &Path) -> Result<Vec<u8>, InputError> {
    let (file, length) = open_path(path)?;
    read_all_text(path, file, length)
}

/// Same as [`read_text`], for an open file.
pub(crate) fn read_all_text(path: &Path, file: impl Read, length: u64) -> Result<Vec<u8>, InputError> {
    read_within(path, UpToNul { file, found: false }, length, MAX_FILE_BYTES)
}

/// Reader that ends after the first NUL byte.
struct UpToNul<R> {
    file: R,
    found: bool,
}

impl<R: Read> Read for UpToNul<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.found {
            return Ok(0);
        }
        let count = self.file.read(buffer)?;
        let text = up_to_nul(&buffer[..count]);
        self.found = text.ends_with(&[0]);
        Ok(text.len())
    }
}

/// The part of these bytes that [`read_text`] returns.
pub(crate) fn up_to_nul(bytes: &[u8]) -> &[u8] {
    let nul = bytes.iter().position(|byte| *byte == 0);
    &bytes[..nul.map_or(bytes.len(), |at| at + 1)]
}

/// Returns an error for files of more than `limit` bytes.
pub(crate) fn check_length(length: u64, limit: u64) -> Result<(), FormatError> {
    if length <= limit {
        return Ok(());
    }
    Err(FormatError::whole("file length", bytes(length), format!("at most {}", bytes(limit))))
}

/// Reads at most `limit` bytes to the end. `length` is the expected length, and errors name `path`.
pub(crate) fn read_within(path: &Path, file: impl Read, length: u64, limit: u64) -> Result<Vec<u8>, InputError> {
    let wrong = |error| InputError::format(path, error);
    check_length(length, limit).map_err(wrong)?;
    let mut contents = reserved("file length", length as usize).map_err(wrong)?;
    // A pipe has no length, and a file may grow while it is read.
    file.take(limit + 1).read_to_end(&mut contents).map_err(|error| InputError::io(path, error))?;
    check_length(contents.len() as u64, limit).map_err(wrong)?;
    Ok(contents)
}

/// The first `most` bytes of a regular file; `None` for pipes, whose bytes can be read only once, and for files that cannot be read.
pub(crate) fn start_of(path: &Path, most: usize) -> Option<Vec<u8>> {
    if !path.is_file() {
        return None;
    }
    let (file, _) = open_path(path).ok()?;
    let mut start = Vec::with_capacity(most);
    file.take(most as u64).read_to_end(&mut start).ok()?;
    Some(start)
}

/// Extension of a file's name in lower case; empty without one.
pub(crate) fn extension_of(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// Formats an extension for [`unknown_kind`].
pub(crate) fn found_extension(extension: &str) -> Result<String, &'static str> {
    if extension.is_empty() { Err("no extension") } else { Ok(format!("extension .{extension}")) }
}

/// Error of a file of an unknown kind, from the value that states its kind or from a problem.
pub(crate) fn unknown_kind(
    field: &'static str,
    found: Result<String, &'static str>,
    allowed: impl Into<String>,
) -> FormatError {
    match found {
        Ok(value) => FormatError::whole(field, value, allowed),
        Err(problem) => FormatError::whole(field, problem, allowed).problem(),
    }
}
