//! Reads files, within limits that are checked before memory is asked for.

use super::error::InputError;
use brdfc_formats::FormatError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest file that is read as a whole (everything but MERL tables, whose header is checked first).
pub const MAX_FILE_BYTES: u64 = 2 << 30;
/// Largest file of text that people write: manifests, lists of directions.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Opens what is no folder and no device; its length too, which is 0 for pipes.
pub(crate) fn open_path(path: &Path) -> Result<(File, u64), InputError> {
    let io = |error| InputError::io(path, error);
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if metadata.is_dir() {
        return Err(io(std::io::Error::from(std::io::ErrorKind::IsADirectory)));
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
    let (file, length) = open_path(path)?;
    read_within(path, file, length, limit)
}

/// Reads a file to its end if it is not too large.
pub(crate) fn read_all(path: &Path, file: impl Read, length: u64) -> Result<Vec<u8>, InputError> {
    read_within(path, file, length, MAX_FILE_BYTES)
}

/// Reads to the end of what has at most `limit` bytes, `length` of them as far as is known. Errors name `path`.
pub(crate) fn read_within(path: &Path, file: impl Read, length: u64, limit: u64) -> Result<Vec<u8>, InputError> {
    let name = path.display().to_string();
    let too_long = |found: String| {
        let error = FormatError::whole("file length", found, format!("at most {limit} bytes"));
        InputError::Format { name: path.display().to_string(), error }
    };
    if length > limit {
        return Err(too_long(format!("{length} bytes")));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    // A pipe has no length, and a file may grow meanwhile.
    file.take(limit + 1).read_to_end(&mut bytes).map_err(|error| InputError::Io { name, error })?;
    if bytes.len() as u64 > limit {
        return Err(too_long(format!("more than {limit} bytes")));
    }
    Ok(bytes)
}

/// The extension of a file's name in lower case, or nothing.
pub(crate) fn extension_of(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// An extension as an error says that it was found.
pub(crate) fn found_extension(extension: &str) -> String {
    if extension.is_empty() { "no extension".to_owned() } else { format!("extension .{extension}") }
}
