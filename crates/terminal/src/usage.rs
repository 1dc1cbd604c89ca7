//! Settings of all flags, and errors of their values in the form of all other errors.

use brdfc_core::words::quoted;
use brdfc_metrics::fraction::Fraction;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::any::TypeId;
use std::error::Error;
use std::num::{ParseFloatError, ParseIntError};

/// Sets what all flags share. Help texts state defaults, so that clap does not repeat them. A numeric flag accepts a value
/// that begins with `-`, such as -1, -.5, -5% or the next flag, so that a check reports what is expected.
pub fn with_common_settings(argument: clap::Arg) -> clap::Arg {
    let argument = argument.hide_default_value(true);
    let numbers = [
        TypeId::of::<f64>(),
        TypeId::of::<f32>(),
        TypeId::of::<usize>(),
        TypeId::of::<u64>(),
        TypeId::of::<u32>(),
        TypeId::of::<Fraction>(),
    ];
    let value_type = argument.get_value_parser().type_id();
    let number = argument.get_action().takes_values() && numbers.iter().any(|number| value_type == *number);
    if number { argument.allow_hyphen_values(true) } else { argument }
}

/// Parses a fraction or a percentage, for flags whose range is checked later.
pub fn share(text: &str) -> Result<f64, String> {
    text.parse::<Fraction>().map(Fraction::value)
}

/// Describes a value that could not be parsed, if the parser states what it expects.
pub fn wrong_value(error: &clap::Error) -> Option<String> {
    match error.kind() {
        ErrorKind::ValueValidation => {}
        ErrorKind::InvalidUtf8 => {
            let wrong = std::env::args_os().find(|argument| argument.to_str().is_none())?;
            return Some(format!("arguments: found {}, expected UTF-8", wrong.display()));
        }
        _ => return None,
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
        "expected a whole number".to_owned()
    } else if cause.is::<ParseFloatError>() {
        "expected a number".to_owned()
    } else {
        cause.to_string()
    };
    let wrong = if found.is_empty() { "empty value;".to_owned() } else { format!("found {},", quoted(found)) };
    allowed.starts_with("expected ").then(|| format!("{flag}: {wrong} {allowed}"))
}
