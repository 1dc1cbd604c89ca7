//! Inputs of a user: an address, a file, or standard input.

use super::error::InputError;
use super::misnamed::wrong_contents;
use super::read::{
    MAX_FILE_BYTES, ObservedFile, ReadListener, check_length, extension_of, open_observed, read_all_text, read_file,
    read_text, read_within, up_to_nul,
};
use brdfc_core::Smooth;
use brdfc_core::address::is_synth;
use brdfc_formats::FormatError;
use brdfc_readers::recognise::{START_BYTES, recognise};
use std::borrow::Cow;
use std::ffi::OsString;
use std::fmt;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Name of standard input in messages.
pub const STANDARD_INPUT: &str = "stdin";

/// An input, as the user named it. Paths need not be UTF-8.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// Address of an analytic model or a structure: `synth:NAME?param=value&...`.
    Address(String),
    /// A file or a folder.
    File(PathBuf),
    /// Standard input, given as `-`.
    Stdin(StandardInput),
}

/// Standard input, read at first use. Clones share the bytes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StandardInput(Arc<OnceLock<Vec<u8>>>);

impl StandardInput {
    /// Reads all bytes.
    ///
    /// # Errors
    /// Returns an error if standard input cannot be read or has more than [`MAX_FILE_BYTES`].
    pub fn bytes(&self) -> Result<&[u8], InputError> {
        if let Some(bytes) = self.0.get() {
            return Ok(bytes);
        }
        let bytes = read_within(Path::new(STANDARD_INPUT), std::io::stdin().lock(), 0, MAX_FILE_BYTES)?;
        Ok(self.0.get_or_init(|| bytes))
    }
}

impl Input {
    /// The address, if the input is an address.
    pub fn address(&self) -> Option<&str> {
        match self {
            Self::Address(address) => Some(address),
            _ => None,
        }
    }

    /// The path, if the input is a file or a folder.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            _ => None,
        }
    }

    /// Returns true for standard input.
    pub fn is_stdin(&self) -> bool {
        matches!(self, Self::Stdin(_))
    }

    /// Short name for reports: an address, or a file's name without its folder.
    pub fn short_name(&self) -> String {
        match self.path().and_then(Path::file_name) {
            Some(name) => name.to_string_lossy().into_owned(),
            None => self.to_string(),
        }
    }

    /// Extension that identifies the kind of file, in lower case. For standard input it is derived from the bytes.
    /// Empty for addresses and unknown kinds.
    ///
    /// # Errors
    /// Returns an error if standard input cannot be read.
    pub fn extension(&self) -> Result<String, InputError> {
        Ok(match self {
            Self::Address(_) => String::new(),
            Self::File(path) => extension_of(path),
            Self::Stdin(stdin) => {
                let bytes = stdin.bytes()?;
                let kind = recognise(bytes, bytes.len() as u64);
                kind.and_then(|kind| kind.extensions.first()).map_or("", |extension| extension).to_owned()
            }
        })
    }

    /// Reads the whole input.
    ///
    /// # Errors
    /// Returns an error for an address, and for an input that cannot be read or has more than `limit` bytes.
    pub fn read(&self, limit: u64) -> Result<Cow<'_, [u8]>, InputError> {
        match self {
            Self::File(path) => Ok(read_file(path, limit)?.into()),
            Self::Stdin(stdin) => Ok(within(self.named_path(), stdin.bytes()?, limit)?.into()),
            Self::Address(address) => Err(no_file(address)),
        }
    }

    /// Reads text to its end, or through the first NUL byte.
    ///
    /// # Errors
    /// Same as [`Self::read`], with [`MAX_FILE_BYTES`] as the limit.
    pub fn read_text(&self) -> Result<Cow<'_, [u8]>, InputError> {
        match self {
            Self::File(path) => Ok(read_text(path)?.into()),
            Self::Stdin(stdin) => Ok(up_to_nul(stdin.bytes()?).into()),
            Self::Address(address) => Err(no_file(address)),
        }
    }

    /// Path that names the input in messages.
    pub(crate) fn named_path(&self) -> &Path {
        match self {
            Self::Address(address) => Path::new(address),
            Self::File(path) => path,
            Self::Stdin(_) => Path::new(STANDARD_INPUT),
        }
    }
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.named_path().display().fmt(f)
    }
}

fn no_file(address: &str) -> InputError {
    let error = FormatError::whole("input", "a model is no file", "a file").problem();
    InputError::Format { name: address.to_owned(), error }
}

/// Checks that there are at most `limit` bytes.
fn within<'a>(path: &Path, bytes: &'a [u8], limit: u64) -> Result<&'a [u8], InputError> {
    check_length(bytes.len() as u64, limit).map_err(|error| InputError::format(path, error))?;
    Ok(bytes)
}

/// Settings of reading an input. All but the level are keys of a manifest.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reading {
    /// Level of detail of packs; `None` is the finest. Other inputs have none.
    #[serde(skip)]
    pub level: Option<f32>,
    /// Scans: number of neighbours of a fit, 1 to the number of distinct direction pairs; `None` chooses it by left-out
    /// rows.
    pub neighbours: Option<usize>,
    /// Smoothing of dense tables and scans; `None` smooths scans of 5 % noise or more.
    pub smooth: Option<Smooth>,
}

impl Reading {
    /// Description of valid numbers of neighbours, for messages.
    pub const NEIGHBOURS: &str = "1 to the number of distinct direction pairs of the scan";

    /// Fills open settings from `defaults`.
    #[must_use]
    pub fn over(self, defaults: Self) -> Self {
        Self {
            level: self.level.or(defaults.level),
            neighbours: self.neighbours.or(defaults.neighbours),
            smooth: self.smooth.or(defaults.smooth),
        }
    }

    /// Checks the number of neighbours and the radius.
    ///
    /// # Errors
    /// Returns an error for values that are out of range for any input. Scans also limit the number of neighbours.
    pub fn check(self) -> Result<(), FormatError> {
        match self {
            Self { neighbours: Some(0), .. } => Err(FormatError::whole("neighbours", "0", Self::NEIGHBOURS)),
            Self { smooth: Some(Smooth::Radius(radius)), .. } if !Smooth::RADII.contains(&radius) => {
                Err(FormatError::whole("smooth", radius.to_string(), Smooth::ALLOWED))
            }
            _ => Ok(()),
        }
    }

    /// Smoothing of a dense table, if it is requested, with its radius, if any.
    ///
    /// # Errors
    /// Returns the errors of [`Self::check`].
    pub(crate) fn smoothing(self) -> Result<Option<Option<usize>>, FormatError> {
        self.check()?;
        Ok(self.smooth.and_then(Smooth::strength))
    }
}

impl From<Option<f32>> for Reading {
    fn from(level: Option<f32>) -> Self {
        Self { level, ..Self::default() }
    }
}

/// An open input, not read yet or in memory.
pub(crate) struct InputFile<'a> {
    pub(crate) path: &'a Path,
    pub(crate) file: Contents<'a>,
    /// Length in bytes.
    pub(crate) length: u64,
    pub(crate) reading: Reading,
}

impl<'a> InputFile<'a> {
    /// Opens a file or standard input. `listener` observes files.
    pub(crate) fn of(input: &'a Input, listener: &'a mut dyn ReadListener) -> Result<Self, InputError> {
        match input {
            Input::File(path) => Self::at(path, listener),
            Input::Stdin(stdin) => {
                let (path, bytes) = (input.named_path(), stdin.bytes()?);
                let file = Contents::Memory(Cursor::new(bytes));
                Ok(Self { path, file, length: bytes.len() as u64, reading: Reading::default() })
            }
            Input::Address(address) => Err(no_file(address)),
        }
    }

    /// Opens a file.
    pub(crate) fn at(path: &'a Path, listener: &'a mut dyn ReadListener) -> Result<Self, InputError> {
        let (file, length) = open_observed(path, listener)?;
        Ok(Self { path, file: Contents::File(file), length, reading: Reading::default() })
    }

    /// Reads and parses the whole file.
    pub(crate) fn parse<T>(self, parse: impl FnOnce(&[u8]) -> Result<T, FormatError>) -> Result<T, InputError> {
        self.parse_within(MAX_FILE_BYTES, parse)
    }

    /// Same as [`Self::parse`], for at most `limit` bytes.
    pub(crate) fn parse_within<T>(
        self,
        limit: u64,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, InputError> {
        let bytes: Cow<'_, [u8]> = match self.file {
            Contents::File(file) => read_within(self.path, file, self.length, limit)?.into(),
            Contents::Memory(bytes) => within(self.path, bytes.into_inner(), limit)?.into(),
        };
        parse(&bytes).map_err(|error| wrong_contents(self.path, &bytes, bytes.len() as u64, error))
    }

    /// Same as [`Self::parse`], for text, which ends at a NUL byte.
    pub(crate) fn parse_text<T>(
        mut self,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, InputError> {
        let bytes = read_all_text(self.path, &mut self.file, self.length)?;
        parse(&bytes).map_err(|error| {
            // The bytes after a NUL byte are needed to recognise the kind of file.
            if bytes.ends_with(&[0]) {
                return self.wrong(error);
            }
            wrong_contents(self.path, &bytes, bytes.len() as u64, error)
        })
    }

    /// Creates the error of a violated layout, with a hint if the contents do not match the extension.
    pub(crate) fn wrong(mut self, error: FormatError) -> InputError {
        let mut start = Vec::new();
        let found = self.file.seek(SeekFrom::Start(0)).and_then(|_| {
            let start_bytes = START_BYTES as u64;
            self.file.take(start_bytes).read_to_end(&mut start)
        });
        if found.is_err() {
            start.clear();
        }
        wrong_contents(self.path, &start, self.length, error)
    }
}

/// Bytes of an input: a file or a pipe, or bytes in memory.
pub(crate) enum Contents<'a> {
    File(ObservedFile<'a>),
    Memory(Cursor<&'a [u8]>),
}

impl Read for Contents<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self {
            Self::File(file) => file.read(buffer),
            Self::Memory(bytes) => bytes.read(buffer),
        }
    }
}

impl Seek for Contents<'_> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        match self {
            Self::File(file) => file.seek(to),
            Self::Memory(bytes) => bytes.seek(to),
        }
    }
}

/// Argument of a command line: `-` is standard input.
impl From<OsString> for Input {
    fn from(text: OsString) -> Self {
        match text.to_str() {
            Some("-" | "/dev/stdin") => Self::Stdin(StandardInput::default()),
            Some(address) if is_synth(address) => Self::Address(address.to_owned()),
            _ => Self::File(text.into()),
        }
    }
}

/// Value of a manifest or a program: an address or a path.
impl From<&str> for Input {
    fn from(text: &str) -> Self {
        if is_synth(text) { Self::Address(text.to_owned()) } else { Self::File(text.into()) }
    }
}

impl From<String> for Input {
    fn from(text: String) -> Self {
        text.as_str().into()
    }
}

impl From<&String> for Input {
    fn from(text: &String) -> Self {
        text.as_str().into()
    }
}

impl From<&Path> for Input {
    fn from(path: &Path) -> Self {
        Self::File(path.to_owned())
    }
}

impl From<PathBuf> for Input {
    fn from(path: PathBuf) -> Self {
        Self::File(path)
    }
}

impl From<&PathBuf> for Input {
    fn from(path: &PathBuf) -> Self {
        Self::File(path.clone())
    }
}

impl From<&Input> for Input {
    fn from(input: &Input) -> Self {
        input.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dash_is_standard_input_on_command_lines_alone() {
        let of_command_line = |text: &str| Input::from(OsString::from(text));
        assert!(of_command_line("-").is_stdin() && of_command_line("/dev/stdin").is_stdin());
        assert!(!of_command_line("./-").is_stdin());
        assert_eq!(Input::from("-").path(), Some(Path::new("-")));
        assert_eq!(of_command_line("synth:lewis").address(), Some("synth:lewis"));
        assert_eq!(of_command_line("-").to_string(), "stdin");
    }

    #[test]
    fn limits_hold_for_standard_input_too() {
        let input = |bytes: &[u8]| Input::Stdin(StandardInput(Arc::new(OnceLock::from(bytes.to_vec()))));
        let five = input(b"a\0b\0c");
        assert_eq!(five.read(5).unwrap(), &b"a\0b\0c"[..]);
        let message = five.read(4).unwrap_err().to_string();
        assert_eq!(message, "stdin: file length: found 5 B, expected at most 4 B");
        assert_eq!(five.read_text().unwrap(), &b"a\0"[..]);
        assert_eq!(input(b"abc").read_text().unwrap(), &b"abc"[..]);
        let opened = |limit| {
            let mut listener = ();
            InputFile::of(&five, &mut listener).unwrap().parse_within(limit, |bytes| Ok(bytes.len()))
        };
        assert_eq!(opened(5).unwrap(), 5);
        assert_eq!(opened(4).unwrap_err().to_string(), message);
        let text = InputFile::of(&five, &mut ()).unwrap().parse_text(|bytes| Ok(bytes.to_vec()));
        assert_eq!(text.unwrap(), b"a\0");
    }

    #[test]
    fn names_without_folders() {
        for (text, expected) in [("a/b.brdf", "b.brdf"), ("synth:ggx?alpha=0.1", "synth:ggx?alpha=0.1"), ("..", "..")] {
            assert_eq!(Input::from(text).short_name(), expected);
        }
    }

    #[test]
    #[cfg(unix)]
    fn paths_need_not_be_utf_8() {
        use std::os::unix::ffi::OsStringExt;
        let input = Input::from(OsString::from_vec(b"m\xe9tal.BINARY".to_vec()));
        assert_eq!(input.to_string(), "m\u{fffd}tal.BINARY");
        assert_eq!(input.extension().unwrap(), "binary");
    }
}
