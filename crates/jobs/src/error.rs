//! The library's error type, and conversions from the errors of its stages.

use crate::encode::{EncodeError, Message, OptionError};
use brdfc_core::address::SYNTH_PREFIX;
use brdfc_core::progress::Cancelled;
use brdfc_core::words::system_error;
use brdfc_flat_btf::structures::Structure;
use brdfc_formats::FormatError;
use brdfc_source::InputError;
use std::convert::Infallible;
use std::fmt::Display;
use std::path::Path;

/// Kind of an error, which determines the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A check failed: a limit is missed, a gate failed, or there is nothing to measure.
    Check,
    /// Wrong options or arguments.
    Usage,
    /// A file or an address does not follow its layout, or is of an unknown kind.
    Input,
    /// A file cannot be read or written.
    Io,
    /// No usable graphics adapter.
    NoAdapter,
    /// A bug in this library.
    Internal,
    /// The caller cancelled the work.
    Cancelled,
}

impl ErrorKind {
    /// The exit code, as in `docs/command-line.md`. Of several failures the largest counts.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Check => 1,
            Self::Usage => 2,
            Self::Input => 3,
            Self::Io => 4,
            Self::NoAdapter => 5,
            Self::Internal => 6,
            Self::Cancelled => 130,
        }
    }
}

/// An error: a kind, and a message that names the file, field or line, what was found and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    kind: ErrorKind,
    message: Message,
}

impl Error {
    /// Creates an error of this kind; the message should name the file, field or line.
    pub fn new(kind: ErrorKind, message: impl ToString) -> Self {
        Self::with_keys(kind, message.to_string().into())
    }

    /// Creates an error of this kind whose message names options by the keys of a manifest; see
    /// [`Self::name_options`].
    pub fn with_keys(kind: ErrorKind, message: Message) -> Self {
        Self { kind, message }
    }

    /// Replaces the keys of options in the message by their names.
    #[must_use]
    pub fn name_options(self, name: impl Fn(&str) -> String) -> Self {
        Self { message: self.message.named(name), ..self }
    }

    /// Creates an error about a failed check.
    pub fn check(message: impl ToString) -> Self {
        Self::new(ErrorKind::Check, message)
    }

    /// Creates an error about wrong options or arguments.
    pub fn usage(message: impl ToString) -> Self {
        Self::new(ErrorKind::Usage, message)
    }

    /// Creates an error about invalid input.
    pub fn input(message: impl ToString) -> Self {
        Self::new(ErrorKind::Input, message)
    }

    /// Creates an error about a file that cannot be read or written.
    pub fn io(message: impl ToString) -> Self {
        Self::new(ErrorKind::Io, message)
    }

    /// Creates an error about a missing graphics adapter.
    pub fn no_adapter(message: impl ToString) -> Self {
        Self::new(ErrorKind::NoAdapter, message)
    }

    /// Creates an error about a bug in this library.
    pub fn internal(message: impl ToString) -> Self {
        Self::new(ErrorKind::Internal, message)
    }

    /// Creates an error about cancelled work.
    pub fn cancelled() -> Self {
        Self::new(ErrorKind::Cancelled, "cancelled")
    }

    /// The kind of the error.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// Text of the error, which names the file, field or line.
    pub fn message(&self) -> &str {
        self.message.as_str()
    }

    /// Replaces the message and keeps the kind.
    #[must_use]
    pub fn with_message(self, message: impl ToString) -> Self {
        Self { message: message.to_string().into(), ..self }
    }

    /// Prefixes the message with `name`.
    #[must_use]
    pub fn prefixed(self, name: impl Display) -> Self {
        let message = Message::default().with_text(format!("{name}: ")).with_message(&self.message);
        Self { message, ..self }
    }

    /// Creates an error about an invalid option or argument.
    pub fn wrong_usage(option: impl Display, found: impl Display, allowed: impl Display) -> Self {
        Self::usage(format!("{option}: found {found}, expected {allowed}"))
    }

    /// Creates an error about an invalid input.
    pub fn wrong_input(input: impl Display, found: impl Display, allowed: impl Display) -> Self {
        Self::input(format!("{input}: found {found}, expected {allowed}"))
    }

    /// Creates an error about an invalid pack that this library made.
    pub fn own_layout(error: FormatError) -> Self {
        Self::internal(format!("bug: made an invalid pack: {error}"))
    }

    /// Creates an error about a file or a stream that cannot be written.
    pub fn write(path: impl AsRef<Path>, error: &std::io::Error) -> Self {
        Self::io(format!("{}: cannot write: {}", path.as_ref().display(), system_error(error)))
    }

    /// Creates an error about a file that cannot be read.
    pub fn read(path: &Path, error: &std::io::Error) -> Self {
        Self::io(format!("{}: cannot read: {}", path.display(), system_error(error)))
    }
}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        let message = error.to_string();
        match error {
            InputError::Io { .. } => Self::io(message),
            InputError::Format { .. } | InputError::Misnamed { .. } => Self::input(message),
            InputError::Address { name, .. } => {
                let structure = name.strip_prefix(SYNTH_PREFIX).is_some_and(|text| Structure::parse(text).is_ok());
                let hint = if structure { "; this is a structure, for 'brdfc flatten'" } else { "" };
                Self::input(message + hint)
            }
        }
    }
}

impl From<Infallible> for Error {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Self {
        Self::cancelled()
    }
}

impl From<EncodeError> for Error {
    fn from(error: EncodeError) -> Self {
        match error {
            EncodeError::BudgetMissed { .. }
            | EncodeError::NothingMeasured
            | EncodeError::TooFewBytes { .. }
            | EncodeError::TooFewFetches { .. }
            | EncodeError::OtherDirections { .. } => Self::with_keys(ErrorKind::Check, error.message()),
            EncodeError::Size { .. } => Self::with_keys(ErrorKind::Usage, error.message()),
            EncodeError::Format(error) => Self::own_layout(error),
            EncodeError::Cancelled(_) => Self::cancelled(),
        }
    }
}

impl From<OptionError> for Error {
    fn from(error: OptionError) -> Self {
        Self::with_keys(ErrorKind::Usage, error.message())
    }
}

#[cfg(feature = "render")]
impl From<brdfc_gpu::GpuError> for Error {
    fn from(error: brdfc_gpu::GpuError) -> Self {
        use brdfc_gpu::GpuError;
        match error {
            GpuError::NoAdapter(_) => Self::no_adapter(format!(
                "{error}\n\
                 A Vulkan driver is needed; a graphics card is not. Mesa's software driver is enough:\n  \
                 Debian, Ubuntu   sudo apt-get install mesa-vulkan-drivers libvulkan1\n  \
                 Fedora           sudo dnf install mesa-vulkan-drivers vulkan-loader\n  \
                 Arch             sudo pacman -S vulkan-swrast vulkan-icd-loader"
            )),
            GpuError::TooLarge(text) => Self::usage(text),
            GpuError::NoSuchAdapter { .. } | GpuError::Failed(_) => Self::no_adapter(error),
        }
    }
}
