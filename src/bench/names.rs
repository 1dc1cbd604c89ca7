//! What inputs are called.

use std::path::Path;

/// What reports call an input: its address, or the name of its file.
pub(super) fn display_name(input: &str) -> &str {
    if input.starts_with("synth:") {
        return input;
    }
    Path::new(input).file_name().and_then(|name| name.to_str()).unwrap_or(input)
}
