//! What a user names as an input: an address, a file, or standard input.

use super::address::is_synth;
use super::error::InputError;
use super::read::{MAX_FILE_BYTES, extension_of, read_file, read_within};
use super::recognise::{FileKind, recognise};
use brdfc_formats::FormatError;
use std::borrow::Cow;
use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// What standard input is called in messages.
pub const STANDARD_INPUT: &str = "stdin";

/// An input as it was named. Paths may be any that the system has, UTF-8 or not.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// `synth:NAME?param=value&...`
    Address(String),
    /// A file or a folder.
    File(PathBuf),
    /// Standard input.
    Stdin(StandardInput),
}

/// Standard input, which is read when its bytes are first asked for. Its clones share them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StandardInput(Arc<OnceLock<Vec<u8>>>);

impl StandardInput {
    /// All bytes.
    ///
    /// # Errors
    /// What cannot be read; more than [`MAX_FILE_BYTES`].
    pub fn bytes(&self) -> Result<&[u8], InputError> {
        if let Some(bytes) = self.0.get() {
            return Ok(bytes);
        }
        let bytes = read_within(Path::new(STANDARD_INPUT), std::io::stdin().lock(), 0, MAX_FILE_BYTES)?;
        Ok(self.0.get_or_init(|| bytes))
    }
}

impl Input {
    /// The address, if it is one.
    pub fn address(&self) -> Option<&str> {
        match self {
            Self::Address(address) => Some(address),
            _ => None,
        }
    }

    /// The path, if it is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            _ => None,
        }
    }

    /// Whether it is standard input.
    pub fn is_stdin(&self) -> bool {
        matches!(self, Self::Stdin(_))
    }

    /// As reports name it: an address, or a file's name without its folder.
    pub fn short_name(&self) -> String {
        match self.path().and_then(Path::file_name) {
            Some(name) => name.to_string_lossy().into_owned(),
            None => self.to_string(),
        }
    }

    /// What says which kind of file it is, in lower case: the extension, or for standard input the one of such files as
    /// its bytes are of. Nothing of addresses, and where nothing says.
    ///
    /// # Errors
    /// Standard input that cannot be read.
    pub fn extension(&self) -> Result<String, InputError> {
        Ok(match self {
            Self::Address(_) => String::new(),
            Self::File(path) => extension_of(path),
            Self::Stdin(stdin) => {
                let bytes = stdin.bytes()?;
                let kind = recognise(bytes, bytes.len() as u64);
                kind.and_then(|kind: FileKind| kind.extensions().first()).map_or("", |extension| extension).to_owned()
            }
        })
    }

    /// Reads it whole.
    ///
    /// # Errors
    /// What cannot be read, has more than `limit` bytes, or is an address.
    pub fn read(&self, limit: u64) -> Result<Cow<'_, [u8]>, InputError> {
        match self {
            Self::File(path) => Ok(read_file(path, limit)?.into()),
            Self::Stdin(stdin) => Ok(stdin.bytes()?.into()),
            Self::Address(address) => {
                let error = FormatError::whole("input", "the address of a model", "a file");
                Err(InputError::Format { name: address.clone(), error })
            }
        }
    }

    /// A path that messages name it by.
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

/// As a command line has it: `-` is standard input.
impl From<OsString> for Input {
    fn from(text: OsString) -> Self {
        match text.to_str() {
            Some("-" | "/dev/stdin") => Self::Stdin(StandardInput::default()),
            Some(address) if is_synth(address) => Self::Address(address.to_owned()),
            _ => Self::File(text.into()),
        }
    }
}

/// As a manifest or a program has it: an address or a path.
impl From<&str> for Input {
    fn from(text: &str) -> Self {
        if is_synth(text) { Self::Address(text.to_owned()) } else { Self::File(text.into()) }
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
