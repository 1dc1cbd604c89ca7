//! Opens any input: a path or a `synth:` address. [`FORMATS`] is the one table of files that have reflectance.

pub use super::format::{Facts, Format, Opened};

use super::error::InputError;
use super::format::InputFile;
use super::read::{ReadListener, extension_of, found_extension, open_heard};
use super::{address, merl, pack, rgl, scan};
use brdfc_formats::FormatError;
use std::path::Path;

/// Every kind of file that has reflectance.
pub const FORMATS: [Format; 6] =
    [merl::FORMAT, scan::TEXT_FORMAT, scan::CSV_FORMAT, scan::ALTA_FORMAT, rgl::FORMAT, pack::FORMAT];

/// The files that can be opened, for messages: `.binary (MERL), .brdf (scan) ...`.
pub fn known_files() -> String {
    FORMATS.iter().map(|format| format!(".{} ({})", format.extension, format.name)).collect::<Vec<_>>().join(", ")
}

/// Opens `input`. `level` is the level of detail that packs are decoded at; other inputs have none.
///
/// # Errors
/// Files that cannot be read or do not follow their layout, unknown kinds, wrong addresses.
pub fn open(input: &str, level: Option<f32>) -> Result<Opened, InputError> {
    if address::is_synth(input) {
        let model = address::parse_model(&input[address::SYNTH_PREFIX.len()..])
            .map_err(|error| InputError::Address { name: input.to_owned(), error })?;
        let facts = Facts::Synth { address: address::canonical(model.as_ref()) };
        return Ok(Opened { source: model, facts });
    }
    open_file(Path::new(input), level)
}

/// Opens a file.
///
/// # Errors
/// As [`open`].
pub fn open_file(path: &Path, level: Option<f32>) -> Result<Opened, InputError> {
    open_file_heard(path, level, &mut ())
}

/// [`open_file`], with somebody who hears of what is read.
///
/// # Errors
/// As [`open`].
pub fn open_file_heard(path: &Path, level: Option<f32>, listener: &mut dyn ReadListener) -> Result<Opened, InputError> {
    let (file, length) = open_heard(path, listener)?;
    let extension = extension_of(path);
    // Before anything is read.
    let Some(format) = FORMATS.iter().find(|format| format.extension == extension) else {
        let allowed = format!("{}, or synth:MODEL", known_files());
        let error = FormatError::whole("file name", found_extension(&extension), allowed);
        return Err(InputError::format(path, error));
    };
    (format.open)(InputFile { path, file, length, level })
}
