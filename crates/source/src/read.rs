//! Reads files, within limits that are checked before memory is asked for.

use super::error::InputError;
use brdfc_core::words::bytes;
use brdfc_formats::FormatError;
use brdfc_formats::memory::reserved;
use std::fs::File;
use std::io::{Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// Largest file that is read. What is made of it in memory is at most a few times as large.
pub const MAX_FILE_BYTES: u64 = 2 << 30;
/// Largest file of text that people write: manifests, lists of directions.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Hears of a file that is read.
pub trait ReadListener {
    /// A file was opened, and none of [`Self::bytes`] were heard yet. Its length in bytes is 0 for pipes that are read as they come.
    ///
    /// # Errors
    /// A file that is not to be read, such as one that is too large.
    fn opened(&mut self, _file: &File, _length: u64) -> Result<(), FormatError> {
        Ok(())
    }

    /// Bytes of the file, in the order in which they are read: the same for each file of one kind and length.
    fn bytes(&mut self, _bytes: &[u8]) {}
}

/// Ignores everything.
impl ReadListener for () {}

/// A file whose bytes a listener hears.
pub(crate) struct HeardFile<'a> {
    file: Opened,
    listener: &'a mut dyn ReadListener,
}

/// A file, or all bytes of a pipe.
enum Opened {
    File(File),
    Pipe(Cursor<Vec<u8>>),
}

impl Read for HeardFile<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = match &mut self.file {
            Opened::File(file) => file.read(buffer)?,
            Opened::Pipe(bytes) => bytes.read(buffer)?,
        };
        self.listener.bytes(&buffer[..count]);
        Ok(count)
    }
}

impl Seek for HeardFile<'_> {
    fn seek(&mut self, position: SeekFrom) -> std::io::Result<u64> {
        match &mut self.file {
            Opened::File(file) => file.seek(position),
            Opened::Pipe(bytes) => bytes.seek(position),
        }
    }
}

/// [`open_path`], with somebody who hears of it. Pipes are read to their end before, as they have no length and do not go back.
pub(crate) fn open_heard<'a>(
    path: &Path,
    listener: &'a mut dyn ReadListener,
) -> Result<(HeardFile<'a>, u64), InputError> {
    let (file, length) = open_path(path)?;
    let is_file = file.metadata().is_ok_and(|metadata| metadata.is_file());
    let pipe = if is_file { None } else { Some(read_within(path, &file, 0, MAX_FILE_BYTES)?) };
    let length = pipe.as_ref().map_or(length, |bytes| bytes.len() as u64);
    listener.opened(&file, length).map_err(|error| InputError::format(path, error))?;
    let file = pipe.map_or_else(|| Opened::File(file), |bytes| Opened::Pipe(Cursor::new(bytes)));
    Ok((HeardFile { file, listener }, length))
}

/// Opens what is no folder and no device; its length too, which is 0 for pipes.
pub(crate) fn open_path(path: &Path) -> Result<(File, u64), InputError> {
    let io = |error: std::io::Error| {
        if error.kind() == ErrorKind::NotFound && path.is_symlink() {
            let text = "it is a link, and there is nothing where it leads to";
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

/// Reads a file or a pipe to its end if it has at most `limit` bytes.
///
/// # Errors
/// What cannot be read; folders and devices; more bytes.
pub fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    read_heard(path, limit, &mut ())
}

/// [`read_file`], with somebody who hears of it.
///
/// # Errors
/// As [`read_file`].
pub fn read_heard(path: &Path, limit: u64, listener: &mut dyn ReadListener) -> Result<Vec<u8>, InputError> {
    let (file, length) = open_path(path)?;
    listener.opened(&file, length).map_err(|error| InputError::format(path, error))?;
    read_within(path, HeardFile { file: Opened::File(file), listener }, length, limit)
}

/// Reads a file or a pipe of text to its end, or to the first NUL byte, which is the last one of what is returned: text has
/// none, so that whoever parses it refuses it there.
///
/// # Errors
/// As [`read_file`], of more than [`MAX_FILE_BYTES`].
pub fn read_text(path: &Path) -> Result<Vec<u8>, InputError> {
    let (file, length) = open_path(path)?;
    read_all_text(path, file, length)
}

/// [`read_text`] of a file that is open.
pub(crate) fn read_all_text(path: &Path, file: impl Read, length: u64) -> Result<Vec<u8>, InputError> {
    read_within(path, UpToNul { file, found: false }, length, MAX_FILE_BYTES)
}

/// Ends behind the first NUL byte.
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

/// What [`read_text`] reads of a file with these bytes.
pub(crate) fn up_to_nul(bytes: &[u8]) -> &[u8] {
    let nul = bytes.iter().position(|byte| *byte == 0);
    &bytes[..nul.map_or(bytes.len(), |at| at + 1)]
}

/// Refuses files of more than `limit` bytes.
pub(crate) fn check_length(length: u64, limit: u64) -> Result<(), FormatError> {
    if length <= limit {
        return Ok(());
    }
    Err(FormatError::whole("file length", bytes(length), format!("at most {}", bytes(limit))))
}

/// Reads to the end of what has at most `limit` bytes, `length` of them as far as is known. Errors name `path`.
pub(crate) fn read_within(path: &Path, file: impl Read, length: u64, limit: u64) -> Result<Vec<u8>, InputError> {
    let wrong = |error| InputError::format(path, error);
    check_length(length, limit).map_err(wrong)?;
    let mut contents = reserved("file length", length as usize).map_err(wrong)?;
    // A pipe has no length, and a file may grow meanwhile.
    file.take(limit + 1).read_to_end(&mut contents).map_err(|error| InputError::io(path, error))?;
    check_length(contents.len() as u64, limit).map_err(wrong)?;
    Ok(contents)
}

/// The extension of a file's name in lower case, or nothing.
pub(crate) fn extension_of(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// An extension as an error says that it was found.
pub(crate) fn found_extension(extension: &str) -> String {
    if extension.is_empty() { "no extension".to_owned() } else { format!("extension .{extension}") }
}
