//! Errors of the program as exceptions of Python, in the same words.

use brdfc_formats::FormatError;
use brdfc_source::InputError;
use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyValueError};
use std::io::ErrorKind;

/// An input that cannot be used: OSError or one of its kinds where it cannot be read, else ValueError.
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

/// An argument that is not allowed.
pub fn wrong(argument: impl Into<String>, found: impl Into<String>, allowed: impl Into<String>) -> PyErr {
    PyValueError::new_err(FormatError::whole(argument.into(), found, allowed).to_string())
}
