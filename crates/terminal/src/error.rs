//! Errors with the exit codes that scripts rely on.

use brdfc_core::address::SYNTH_PREFIX;
use brdfc_core::progress::Cancelled;
use brdfc_flat_btf::structures::Structure;
use brdfc_formats::FormatError;
use brdfc_jobs::encode::PackError;
use brdfc_jobs::encode::options::OptionError;
use brdfc_jobs::flatten::{FlattenError, MesoInputError};
use brdfc_jobs::output_folder::FolderError;
use brdfc_jobs::pwt::PwtError;
use brdfc_jobs::report::page::GatherError;
use brdfc_jobs::scene::batch::BatchError;
use brdfc_jobs::scene::build::BuildError;
use brdfc_jobs::scene::patterns::PatternError;
use brdfc_jobs::scene::plan::PlanError;
use brdfc_jobs::scene::run::JobError;
use brdfc_jobs::view::ViewError;
use brdfc_source::InputError;
use brdfc_wavelet::encode::EncodeError;
use std::path::Path;

/// Why the program did not do what it was asked.
#[derive(Debug)]
pub enum CliError {
    /// A check failed: exit code 1.
    Check(String),
    /// Wrong arguments: 2.
    Usage(String),
    /// Invalid input: 3.
    Input(String),
    /// Cannot read or write: 4.
    Io(String),
    /// No graphics adapter that can be used: 5.
    NoAdapter(String),
    /// A fault of the program: 6.
    Internal(String),
    /// Stopped by the user: 130.
    Interrupted,
    /// Nobody reads our output any more, which is no error: 0.
    PipeClosed,
}

impl CliError {
    /// The exit code that `docs/command-line.md` promises.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::PipeClosed => 0,
            Self::Check(_) => 1,
            Self::Usage(_) => 2,
            Self::Input(_) => 3,
            Self::Io(_) => 4,
            Self::NoAdapter(_) => 5,
            Self::Internal(_) => 6,
            Self::Interrupted => 130,
        }
    }

    /// The same kind of failure, told otherwise.
    pub fn with_message(self, message: String) -> Self {
        match self {
            Self::Check(_) => Self::Check(message),
            Self::Usage(_) => Self::Usage(message),
            Self::Input(_) => Self::Input(message),
            Self::Io(_) => Self::Io(message),
            other => other,
        }
    }

    /// What to tell, if anything.
    pub fn message(&self) -> Option<&str> {
        match self {
            Self::Check(m) | Self::Usage(m) | Self::Input(m) | Self::Io(m) | Self::NoAdapter(m) | Self::Internal(m) => {
                Some(m)
            }
            Self::Interrupted => Some("interrupted; the output folder is as it was"),
            Self::PipeClosed => None,
        }
    }

    /// What a program without the renderer says.
    pub fn without_renderer() -> Self {
        Self::NoAdapter("no usable graphics adapter: this program was built without its feature 'render'".to_owned())
    }

    /// What the program made breaks the rules of its own layout.
    pub fn own_layout(error: FormatError) -> Self {
        Self::Internal(format!("a pack that its own layout refuses: {error}"))
    }

    /// A file that cannot be written.
    pub fn write(path: &Path, error: &std::io::Error) -> Self {
        Self::Io(format!("{}: cannot write: {error}", path.display()))
    }

    /// A file that cannot be read.
    pub fn read(path: &Path, error: &std::io::Error) -> Self {
        Self::Io(format!("{}: cannot read: {error}", path.display()))
    }
}

impl From<InputError> for CliError {
    fn from(error: InputError) -> Self {
        let message = error.to_string();
        match error {
            InputError::Io { .. } => Self::Io(message),
            InputError::Format { .. } | InputError::Misnamed { .. } => Self::Input(message),
            InputError::Address { name, .. } => {
                let structure = name.strip_prefix(SYNTH_PREFIX).is_some_and(|text| Structure::parse(text).is_ok());
                let hint = if structure { "; this is a structure, for 'brdfc flatten'" } else { "" };
                Self::Input(message + hint)
            }
        }
    }
}

impl From<Cancelled> for CliError {
    fn from(_: Cancelled) -> Self {
        Self::Interrupted
    }
}

impl From<EncodeError> for CliError {
    fn from(error: EncodeError) -> Self {
        match error {
            EncodeError::BudgetMissed { .. } | EncodeError::NothingMeasured | EncodeError::TooFewBytes { .. } => {
                Self::Check(error.to_string())
            }
            EncodeError::TooManySlices { .. } => Self::Usage(error.to_string()),
            EncodeError::Cancelled(_) => Self::Interrupted,
        }
    }
}

impl From<PackError> for CliError {
    fn from(error: PackError) -> Self {
        use brdfc_table::encode::EncodeError as TableError;
        match error {
            PackError::Wavelet(error) => error.into(),
            PackError::Table(TableError::TooFewBytes { .. })
            | PackError::NothingMeasured
            | PackError::OtherDirections { .. }
            | PackError::TooFewFetches { .. } => Self::Check(error.to_string()),
            PackError::Table(TableError::Format(error)) => Self::own_layout(error),
            PackError::Table(TableError::Cancelled(_)) | PackError::Cancelled(_) => Self::Interrupted,
        }
    }
}

impl From<JobError> for CliError {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Input(error) => error.into(),
            JobError::Encode(error) => error.into(),
            JobError::Cancelled(_) => Self::Interrupted,
            JobError::Map(error) => Self::own_layout(error),
            JobError::Store(error) => Self::Io(error.to_string()),
        }
    }
}

impl From<BuildError> for CliError {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Folder(error @ FolderError::Input { .. }) => Self::Usage(error.to_string()),
            BuildError::Folder(error) => Self::Io(error.to_string()),
            BuildError::Cancelled(_) => Self::Interrupted,
        }
    }
}

impl From<MesoInputError> for CliError {
    fn from(error: MesoInputError) -> Self {
        let message = error.to_string();
        match error {
            MesoInputError::Input(error) => error.into(),
            MesoInputError::Tabulate { error, .. } => error.into(),
            MesoInputError::Address { .. } | MesoInputError::Geometry { .. } => Self::Input(message),
            MesoInputError::Options(_) => Self::Usage(message),
        }
    }
}

impl From<FlattenError> for CliError {
    fn from(error: FlattenError) -> Self {
        let message = error.to_string();
        match error {
            FlattenError::Input(error) => error.into(),
            FlattenError::Parameterise(_) | FlattenError::Pack(_) => Self::Input(message),
            FlattenError::Write { .. } => Self::Io(message),
            FlattenError::Cancelled(_) => Self::Interrupted,
        }
    }
}

impl From<PwtError> for CliError {
    fn from(error: PwtError) -> Self {
        match error {
            PwtError::Input(error) => error.into(),
            PwtError::Format(error) => Self::Input(error.to_string()),
            PwtError::Usage(text) => Self::Usage(text),
            PwtError::Flatten(error) => error.into(),
        }
    }
}

impl From<OptionError> for CliError {
    fn from(error: OptionError) -> Self {
        Self::Usage(format!("--{}: found {}; allowed {}", error.field.replace('_', "-"), error.found, error.allowed))
    }
}

impl From<ViewError> for CliError {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::Input(error) => error.into(),
            ViewError::Folder(error) => error.into(),
            ViewError::Table { .. } => Self::Input(error.to_string()),
            ViewError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

impl From<GatherError> for CliError {
    fn from(error: GatherError) -> Self {
        match error {
            GatherError::Input(error) => error.into(),
            GatherError::Folder { .. } => Self::Input(error.to_string()),
            GatherError::Cancelled(_) => Self::Interrupted,
        }
    }
}

impl From<BatchError> for CliError {
    fn from(error: BatchError) -> Self {
        let message = error.to_string();
        match error {
            BatchError::Io { .. } | BatchError::Pattern(PatternError::Io { .. }) => Self::Io(message),
            BatchError::Nothing { .. } => Self::Check(message),
            BatchError::Pattern(_) => Self::Usage(message),
            BatchError::SameName { .. } | BatchError::Name { .. } => Self::Input(message),
        }
    }
}

impl From<PlanError> for CliError {
    fn from(error: PlanError) -> Self {
        Self::Usage(error.to_string())
    }
}

#[cfg(feature = "render")]
impl From<brdfc_gpu::GpuError> for CliError {
    fn from(error: brdfc_gpu::GpuError) -> Self {
        use brdfc_gpu::GpuError;
        match error {
            GpuError::NoAdapter(_) => Self::NoAdapter(format!(
                "{error}\n\
                 A Vulkan driver is needed; a graphics card is not. Mesa's software driver is enough:\n  \
                 Debian, Ubuntu   sudo apt-get install mesa-vulkan-drivers libvulkan1\n  \
                 Fedora           sudo dnf install mesa-vulkan-drivers vulkan-loader\n  \
                 Arch             sudo pacman -S vulkan-swrast vulkan-icd-loader"
            )),
            GpuError::TooLarge(text) => Self::Usage(text),
            GpuError::Failed(_) => Self::NoAdapter(error.to_string()),
        }
    }
}
