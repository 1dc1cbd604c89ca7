//! Opens any input: a path, a `synth:` address or standard input. [`FORMATS`] lists all files with reflectance.

pub use super::format::Format;
pub use brdfc_core::Describe;

use super::error::InputError;
use super::input::{Input, InputFile, Reading};
use super::kind::Kind;
use super::merl::{self, MerlFacts};
use super::read::{ReadListener, extension_of};
use super::rgl::{self, RglFacts};
use super::scan::{self, ScanFacts};
use super::{format, pack};
use brdfc_core::address;
use brdfc_core::words::one_of;
use brdfc_encode::PackFacts;
use brdfc_formats::BrdfPack;
use std::ops::Deref;
use std::path::Path;

/// Generates [`Facts`] and [`FORMATS`] from one line per kind of input: the type of its facts, and the formats of its
/// files.
macro_rules! inputs {
    ($($(#[$meta:meta])* $kind:ident($facts:ty): $($format:expr),*;)*) => {
        /// Kind of an input, with its facts.
        #[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
        #[serde(tag = "kind", rename_all = "kebab-case")]
        pub enum Facts {
            $($(#[$meta])* $kind($facts),)*
        }

        impl Deref for Facts {
            type Target = dyn Describe;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$kind(facts) => facts,)*
                }
            }
        }

        $(impl From<$facts> for Facts {
            fn from(facts: $facts) -> Self {
                Self::$kind(facts)
            }
        })*

        /// All kinds of files with reflectance.
        pub static FORMATS: &[Format<Facts>] = &[$($($format,)*)*];
    };
}

inputs! {
    /// An analytic model.
    Synth(SynthFacts): ;
    /// A MERL table.
    Merl(MerlFacts): merl::format();
    /// A scattered scan.
    Scan(ScanFacts): scan::text_format(), scan::csv_format(), scan::alta_format();
    /// An RGL material.
    Rgl(RglFacts): rgl::format();
    /// A pack of a BRDF.
    #[serde(untagged)]
    Pack(PackFacts): pack::format();
}

/// An input, ready for evaluation.
pub type Opened = format::Opened<Facts>;

/// Facts about an analytic model.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct SynthFacts {
    /// Address with all parameters.
    pub address: String,
}

impl Describe for SynthFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        vec![("kind", "analytic model".to_owned()), ("address", self.address.clone())]
    }

    fn samples(&self) -> u64 {
        0
    }
}

/// Supported files, for messages: `.binary (MERL), .brdf (scan) ...`.
pub fn known_files() -> String {
    files_but_for("")
}

/// Supported files except files with `extension`.
pub fn files_but_for(extension: &str) -> String {
    let others = FORMATS.iter().filter(|format| format.extension() != extension);
    one_of(&others.map(|format| format!(".{} ({})", format.extension(), format.name)).collect::<Vec<_>>())
}

/// Opens `input`. A level of detail alone is a [`Reading`], too.
///
/// # Errors
/// Returns an error for files that cannot be read or violate their layout, unknown kinds, and invalid addresses.
pub fn open(input: impl Into<Input>, reading: impl Into<Reading>) -> Result<Opened, InputError> {
    let (input, reading) = (input.into(), reading.into());
    match &input {
        Input::Address(name) => {
            let model = address::parse_model(name.strip_prefix(address::SYNTH_PREFIX).unwrap_or(name))
                .map_err(|error| InputError::Address { name: name.clone(), error })?;
            let facts = SynthFacts { address: address::canonical(model.as_ref()) };
            Ok(Opened { source: model, facts: facts.into() })
        }
        Input::File(path) => open_file(path, reading),
        Input::Stdin(_) => {
            let Some(format) = format_of(&input.extension()?) else {
                return Err(Kind::of(&input)?.refused(&input, allowed()));
            };
            let mut listener = ();
            (format.open)(InputFile { reading, ..InputFile::of(&input, &mut listener)? })
        }
    }
}

/// Wraps a pack as an input, decoded at a level of detail; `None` is the finest.
pub fn opened(pack: &BrdfPack, level: Option<f32>) -> Opened {
    pack::opened(pack, level)
}

fn format_of(extension: &str) -> Option<&'static Format<Facts>> {
    FORMATS.iter().find(|format| format.kind.extensions.contains(&extension))
}

/// Opens a file.
///
/// # Errors
/// Returns an error for files that cannot be read or violate their layout, and for unknown kinds.
pub fn open_file(path: &Path, reading: impl Into<Reading>) -> Result<Opened, InputError> {
    open_file_observed(path, reading, &mut ())
}

/// Same as [`open_file`], with an observer of the bytes.
///
/// # Errors
/// Returns an error for files that cannot be read or violate their layout, and for unknown kinds.
pub fn open_file_observed(
    path: &Path,
    reading: impl Into<Reading>,
    listener: &mut dyn ReadListener,
) -> Result<Opened, InputError> {
    // The name is checked before more than the start is read.
    let Some(format) = format_of(&extension_of(path)).filter(|_| !path.is_dir()) else {
        let input = Input::from(path);
        return Err(Kind::of(&input)?.refused(&input, allowed()));
    };
    (format.open)(InputFile { reading: reading.into(), ..InputFile::at(path, listener)? })
}

/// Inputs that can be opened, for messages.
fn allowed() -> String {
    format!("{}, or synth:MODEL", known_files())
}
