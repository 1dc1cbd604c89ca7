//! Conversion of errors of the program to Python exceptions with the same message.

use brdfc_formats::FormatError;
use brdfc_source::InputError;
use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyValueError};
use std::io::ErrorKind;

/// Converts the error of an input: OSError or one of its kinds if it cannot be read, otherwise ValueError.
pub fn of_input(error: InputError) -> PyErr {
    let text = error.to_string();
    match error {
        InputError::Io { error, .. } => match error.kind() {
            ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
            ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
            ErrorKind::IsADirectory => PyIsADirectoryError::new_err(text),
            _ => PyOSError::new_err(text),
        },
        _ => PyValueError::new_err(text),
    }
}

/// Makes the error of an argument from a problem and its remedy.
pub fn problem(argument: &str, text: &str) -> PyErr {
    PyValueError::new_err(format!("{argument}: {text}"))
}

/// Makes the error of an invalid argument.
pub fn wrong(argument: impl Into<String>, found: impl Into<String>, allowed: impl Into<String>) -> PyErr {
    PyValueError::new_err(FormatError::whole(argument.into(), found, allowed).to_string())
}
