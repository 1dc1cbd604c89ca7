//! Numbers as people read them.

pub use brdfc_formats::memory::in_words as bytes;

use serde_json::error::Category;
use std::fmt::{Display, LowerExp};

/// A fraction as per cent with enough digits.
pub fn percent(fraction: f64) -> String {
    let value = 100.0 * fraction;
    if value >= 1e5 {
        format!("{value:.2e} %")
    } else if value >= 0.01 || value == 0.0 {
        format!("{value:.3} %")
    } else {
        format!("{value:.1e} %")
    }
}

/// A number as people write it: with an exponent where there would be many zeros.
pub fn shown<T: Display + LowerExp + Copy + Into<f64>>(number: T) -> String {
    let size = number.into().abs();
    if size == 0.0 || !size.is_finite() || (1e-6..1e15).contains(&size) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// So many of what has this name: `1 file`, `2 files`.
pub fn counted(count: usize, name: &str) -> String {
    format!("{count} {name}{}", if count == 1 { "" } else { "s" })
}

/// The first names of a list, so many at most, and how many more there are.
pub fn few(names: &[impl AsRef<str>], most: usize) -> String {
    let named: Vec<&str> = names.iter().take(most).map(AsRef::as_ref).collect();
    let more = names.len() - named.len();
    if more == 0 { named.join(", ") } else { format!("{} and {more} more", named.join(", ")) }
}

/// What stands in a file of JSON that is not what it should be.
pub fn json_problem(error: &serde_json::Error) -> String {
    let place = format!("line {}, column {}", error.line(), error.column());
    match error.classify() {
        Category::Eof if error.column() == 0 && error.line() == 1 => "an empty file".to_owned(),
        Category::Eof => format!("JSON that ends too early, in {place}"),
        Category::Syntax | Category::Io => format!("text that is no JSON, in {place}"),
        Category::Data => {
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or_default();
            // What is expected may be named as the program names it.
            let message = message.split(", expected struct ").next().unwrap_or_default();
            format!("JSON of another layout, in {place}: {message}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_long() {
        for (number, text) in [
            (0.5, "0.5"),
            (-3.0, "-3"),
            (0.0, "0"),
            (1e-6, "0.000001"),
            (1e99, "1e99"),
            (-2e-99, "-2e-99"),
            (1e15, "1e15"),
        ] {
            assert_eq!(shown(number), text);
        }
        assert_eq!((shown(0.1f32), shown(f64::NAN), shown(f32::INFINITY)), ("0.1".into(), "NaN".into(), "inf".into()));
    }

    #[test]
    fn problems_of_json_name_no_types() {
        #[derive(Debug, serde::Deserialize)]
        struct Inner {
            _name: String,
        }
        for (text, problem) in [
            ("", "an empty file"),
            ("{\"_name\": \"x", "JSON that ends too early, in line 1, column 12"),
            ("\0\0", "text that is no JSON, in line 1, column 1"),
            ("3", "JSON of another layout, in line 1, column 1: invalid type: integer `3`"),
            ("{}", "JSON of another layout, in line 1, column 2: missing field `_name`"),
        ] {
            assert_eq!(json_problem(&serde_json::from_str::<Inner>(text).unwrap_err()), problem);
        }
    }
}
