//! The error type of every reader: the place, what is wrong and what is valid.

use std::borrow::Cow;
use std::fmt;
use std::ops::RangeInclusive;

/// Place of an error in an input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// Byte offset from the start of the file, for binary layouts.
    Byte(u64),
    /// Line number, counted from 1, for text layouts.
    Line(u64),
    /// The input as a whole.
    Whole,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Byte(offset) => write!(f, "byte {offset}, "),
            Place::Line(line) => write!(f, "line {line}, "),
            Place::Whole => Ok(()),
        }
    }
}

/// Meaning of the text [`FormatError::found`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finding {
    /// A value that was read: `found 0, expected 1 to 4096`.
    Value,
    /// A problem: `end of data; expected 8 bytes`.
    Problem,
}

/// An input that does not follow its layout.
///
/// Reads as `byte 4, theta_d count: found 0, expected 1 to 4096`, or after [`FormatError::problem`] as
/// `rows: no measurements; expected at least one row`. It does not name the file; the caller does.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}{field}: {}", reason(*.finding, .found, .allowed))]
pub struct FormatError {
    /// Place of the error.
    pub place: Place,
    /// Field of the layout, named as on its specification page.
    pub field: Cow<'static, str>,
    /// Value in the input, or a problem.
    pub found: String,
    /// Kind of text in `found`: a value or a problem.
    pub finding: Finding,
    /// Values that the layout allows.
    pub allowed: Box<str>,
}

fn reason(finding: Finding, found: &str, allowed: &str) -> String {
    match finding {
        Finding::Value => format!("found {found}, expected {allowed}"),
        Finding::Problem => format!("{found}; expected {allowed}"),
    }
}

/// Truncates text from a file to a length that fits a message.
fn shortened(text: String) -> String {
    const MAX_LENGTH: usize = 200;
    match text.char_indices().nth(MAX_LENGTH) {
        Some((end, _)) => format!("{}... ({} characters)", &text[..end], text.chars().count()),
        None => text,
    }
}

impl FormatError {
    /// Error at a byte offset.
    pub fn at_byte(
        offset: u64,
        field: impl Into<Cow<'static, str>>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self::at(Place::Byte(offset), field, found, allowed)
    }

    /// Error at a line, counted from 1.
    pub fn at_line(
        line: u64,
        field: impl Into<Cow<'static, str>>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self::at(Place::Line(line), field, found, allowed)
    }

    /// Error that concerns the input as a whole.
    pub fn whole(field: impl Into<Cow<'static, str>>, found: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self::at(Place::Whole, field, found, allowed)
    }

    /// Declares that the found text states a problem and is not a value: `PLACE: PROBLEM; expected VALID`.
    #[must_use]
    pub fn problem(self) -> Self {
        Self { finding: Finding::Problem, ..self }
    }

    /// Checks that a number is in a range.
    ///
    /// # Errors
    /// Returns an error with [`Place::Whole`] if it is not.
    pub fn check_range<T: PartialOrd + fmt::Display>(
        field: impl Into<Cow<'static, str>>,
        found: T,
        range: RangeInclusive<T>,
    ) -> Result<(), Self> {
        if range.contains(&found) {
            return Ok(());
        }
        Err(Self::whole(field, found.to_string(), format!("{} to {}", range.start(), range.end())))
    }

    fn at(
        place: Place,
        field: impl Into<Cow<'static, str>>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self {
            place,
            field: shortened(field.into().into_owned()).into(),
            found: shortened(found.into()),
            finding: Finding::Value,
            allowed: allowed.into().into_boxed_str(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_values_are_truncated() {
        let error = FormatError::whole("name", "é".repeat(70_000), "UTF-8").to_string();
        assert!(error.ends_with("é... (70000 characters), expected UTF-8") && error.len() < 500, "{error}");
        assert_eq!(FormatError::whole("name", "short", "x").found, "short");
    }

    #[test]
    fn problems_are_not_found() {
        let error = FormatError::at_line(3, "rows", "no measurements", "at least one row");
        assert_eq!(error.to_string(), "line 3, rows: found no measurements, expected at least one row");
        assert_eq!(error.problem().to_string(), "line 3, rows: no measurements; expected at least one row");
    }
}
