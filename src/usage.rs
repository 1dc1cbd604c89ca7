//! Wrong values of flags in the words of all other errors: found, allowed.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error;
use std::num::{ParseFloatError, ParseIntError};

/// What is wrong with a value that could not be parsed, where the parser says what is allowed.
pub fn wrong_value(error: &clap::Error) -> Option<String> {
    if error.kind() != ErrorKind::ValueValidation {
        return None;
    }
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    // `--grid <N>`
    let flag = context(ContextKind::InvalidArg)?.split(' ').next()?;
    let found = context(ContextKind::InvalidValue)?;
    let cause = error.source()?;
    let allowed = if cause.is::<ParseIntError>() {
        "allowed a whole number".to_owned()
    } else if cause.is::<ParseFloatError>() {
        "allowed a number".to_owned()
    } else {
        cause.to_string()
    };
    let found = if found.is_empty() { "nothing" } else { found };
    allowed.starts_with("allowed ").then(|| format!("{flag}: found {found}; {allowed}"))
}
