//! Metal's language.

use crate::interface::Interface;
use crate::parsed::{Parsed, signatures};
use naga::back::msl::{Options, PipelineOptions, write_string};

/// Declarations and functions, and the signatures of those to call.
///
/// # Errors
/// What the writer says.
pub(crate) fn piece(parsed: &Parsed, interface: &Interface) -> Result<(String, Vec<String>), String> {
    let options = Options { lang_version: (2, 0), fake_missing_bindings: true, ..Options::default() };
    let (text, _) = write_string(&parsed.module, &parsed.info, &options, &PipelineOptions::default())
        .map_err(|error| error.to_string())?;
    let signatures = signatures(&text, interface)?;
    Ok((text, signatures))
}
