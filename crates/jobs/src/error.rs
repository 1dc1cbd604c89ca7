//! The one error of the library. Parts of it have errors of their own, which become this one here.

use crate::convert::ConvertError;
use crate::encode::{EncodeError, OptionError};
use crate::flatten::{FlattenError, MesoInputError};
use crate::output_folder::FolderError;
use crate::pwt::PwtError;
use crate::report::page::GatherError;
use crate::scene::batch::BatchError;
use crate::scene::build::BuildError;
use crate::scene::patterns::PatternError;
use crate::scene::plan::PlanError;
use crate::scene::run::JobError;
use crate::view::ViewError;
use brdfc_core::address::SYNTH_PREFIX;
use brdfc_core::progress::Cancelled;
use brdfc_flat_btf::structures::Structure;
use brdfc_formats::FormatError;
use brdfc_source::InputError;
use std::convert::Infallible;
use std::path::Path;

/// What kind of failure an error is: what a caller does about it, and the exit code of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A check failed: a budget is missed, a gate is closed, there is nothing to measure.
    Check,
    /// Wrong options or arguments.
    Usage,
    /// Invalid input.
    Input,
    /// Cannot read or write.
    Io,
    /// No graphics adapter that can be used.
    NoAdapter,
    /// A fault of this library.
    Internal,
    /// The caller asked to stop.
    Cancelled,
}

impl ErrorKind {
    /// The exit code that `docs/command-line.md` promises; of several failures the largest counts.
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

/// Why something was not done: a kind, and a sentence with the file, the field or the line, what was found and what is allowed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    kind: ErrorKind,
    message: String,
}

impl Error {
    /// An error of a kind.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self { kind, message: message.into() }
    }

    /// A check that failed.
    pub fn check(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Check, message)
    }

    /// Wrong options or arguments.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Usage, message)
    }

    /// Invalid input.
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Input, message)
    }

    /// What cannot be read or written.
    pub fn io(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Io, message)
    }

    /// No graphics adapter that can be used.
    pub fn no_adapter(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::NoAdapter, message)
    }

    /// A fault of this library.
    pub fn internal(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Internal, message)
    }

    /// The caller asked to stop.
    pub fn cancelled() -> Self {
        Self::new(ErrorKind::Cancelled, "cancelled")
    }

    /// What kind of failure it is.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// The sentence.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The same kind of failure, told otherwise.
    #[must_use]
    pub fn with_message(self, message: impl Into<String>) -> Self {
        Self { message: message.into(), ..self }
    }

    /// What the program made breaks the rules of its own layout.
    pub fn own_layout(error: FormatError) -> Self {
        Self::internal(format!("a pack that its own layout refuses: {error}"))
    }

    /// A file or a stream that cannot be written.
    pub fn write(path: impl AsRef<Path>, error: &std::io::Error) -> Self {
        Self::io(format!("{}: cannot write: {error}", path.as_ref().display()))
    }

    /// A file that cannot be read.
    pub fn read(path: &Path, error: &std::io::Error) -> Self {
        Self::io(format!("{}: cannot read: {error}", path.display()))
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
            | EncodeError::OtherDirections { .. } => Self::check(error.to_string()),
            EncodeError::Size { .. } => Self::usage(error.to_string()),
            EncodeError::Format(error) => Self::own_layout(error),
            EncodeError::Cancelled(_) => Self::cancelled(),
        }
    }
}

impl From<JobError> for Error {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Input(error) => error.into(),
            JobError::Encode(error) => error.into(),
            JobError::Cancelled(_) => Self::cancelled(),
            JobError::Map(error) => Self::own_layout(error),
            JobError::Store(error) => Self::io(error.to_string()),
        }
    }
}

impl From<BuildError> for Error {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Folder(error @ FolderError::Input { .. }) => Self::usage(error.to_string()),
            BuildError::Folder(error) => Self::io(error.to_string()),
            BuildError::Cancelled(_) => Self::cancelled(),
        }
    }
}

impl From<MesoInputError> for Error {
    fn from(error: MesoInputError) -> Self {
        let message = error.to_string();
        match error {
            MesoInputError::Input(error) => error.into(),
            MesoInputError::Tabulate { error, .. } => error.into(),
            MesoInputError::Address { .. } | MesoInputError::Geometry { .. } => Self::input(message),
            MesoInputError::Options(_) => Self::usage(message),
        }
    }
}

impl From<FlattenError> for Error {
    fn from(error: FlattenError) -> Self {
        let message = error.to_string();
        match error {
            FlattenError::Input(error) => error.into(),
            FlattenError::Parameterise(_) | FlattenError::Pack(_) => Self::input(message),
            FlattenError::Write { .. } => Self::io(message),
            FlattenError::Cancelled(_) => Self::cancelled(),
        }
    }
}

impl From<PwtError> for Error {
    fn from(error: PwtError) -> Self {
        match error {
            PwtError::Input(error) => error.into(),
            PwtError::Format(error) => Self::input(error.to_string()),
            PwtError::Usage(text) => Self::usage(text),
            PwtError::Flatten(error) => error.into(),
        }
    }
}

impl From<ConvertError> for Error {
    fn from(error: ConvertError) -> Self {
        match error {
            ConvertError::Anisotropic => Self::input(error.to_string()),
            ConvertError::Format(error) => Self::own_layout(error),
        }
    }
}

impl From<OptionError> for Error {
    fn from(error: OptionError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<ViewError> for Error {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::Input(error) => error.into(),
            ViewError::Folder(error) => error.into(),
            ViewError::Table { .. } => Self::input(error.to_string()),
            ViewError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

impl From<GatherError> for Error {
    fn from(error: GatherError) -> Self {
        match error {
            GatherError::Input(error) => error.into(),
            GatherError::Folder { .. } => Self::input(error.to_string()),
            GatherError::Cancelled(_) => Self::cancelled(),
        }
    }
}

impl From<BatchError> for Error {
    fn from(error: BatchError) -> Self {
        let message = error.to_string();
        match error {
            BatchError::Io { .. } | BatchError::Pattern(PatternError::Io { .. }) => Self::io(message),
            BatchError::Nothing { .. } => Self::check(message),
            BatchError::Pattern(_) => Self::usage(message),
            BatchError::SameName { .. } | BatchError::Name { .. } => Self::input(message),
        }
    }
}

impl From<PlanError> for Error {
    fn from(error: PlanError) -> Self {
        Self::usage(error.to_string())
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
            GpuError::Failed(_) => Self::no_adapter(error.to_string()),
        }
    }
}
