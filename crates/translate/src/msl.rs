//! Metal Shading Language.

use crate::parsed::Parsed;
use naga::back::msl::{Options, PipelineOptions, write_string};

/// Translates the declarations and functions.
///
/// # Errors
/// Returns the writer's error.
pub(crate) fn piece(parsed: &Parsed) -> Result<String, String> {
    let options = Options { lang_version: (2, 0), fake_missing_bindings: true, ..Options::default() };
    let (text, _) = write_string(&parsed.module, &parsed.info, &options, &PipelineOptions::default())
        .map_err(|error| error.to_string())?;
    Ok(text)
}
