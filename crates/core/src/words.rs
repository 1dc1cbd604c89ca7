//! Formatted numbers.

pub use brdfc_formats::memory::summary as bytes;
pub use brdfc_formats::words::one_of;

use std::fmt::{Display, LowerExp};

/// Formats a fraction as per cent with enough digits.
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

/// Formats a number for people: with an exponent instead of many zeros.
pub fn format_number<T: Display + LowerExp + Copy + Into<f64>>(number: T) -> String {
    let size = number.into().abs();
    if size == 0.0 || !size.is_finite() || (1e-6..1e15).contains(&size) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// Formats a count with its noun: `1 file`, `2 files`.
pub fn counted(count: usize, name: &str) -> String {
    format!("{count} {name}{}", if count == 1 { "" } else { "s" })
}

/// Formats a share of counted things: `1 of 2 files`, or `2 files` for all of them.
pub fn counted_of(part: usize, all: usize, name: &str) -> String {
    if part == all { counted(all, name) } else { format!("{part} of {}", counted(all, name)) }
}

/// Formats text that the user wrote, with escaped control characters: in quotes unless it is or begins like a number.
pub fn quoted(text: &str) -> String {
    let digits = text.trim_start_matches(['-', '+', '.']);
    let is_number = text.parse::<f64>().is_ok() || digits.starts_with(|first: char| first.is_ascii_digit());
    let escaped = text.escape_debug();
    if is_number { escaped.to_string() } else { format!("\"{escaped}\"") }
}

/// Formats an error of the system without its number.
pub fn system_error(error: &std::io::Error) -> String {
    error.to_string().split(" (os error ").next().unwrap_or_default().to_owned()
}

/// Formats an error of a decoder, which may have several lines, as one line.
pub fn one_line(error: &impl Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Joins up to `most` names of a list with commas, and counts the rest.
pub fn join_truncated(names: &[impl AsRef<str>], most: usize) -> String {
    let named: Vec<&str> = names.iter().take(most).map(AsRef::as_ref).collect();
    let more = names.len() - named.len();
    if more == 0 { named.join(", ") } else { format!("{} and {more} more", named.join(", ")) }
}

/// Formats a number with two decimals, or with as many as are needed to see on which side of a limit it is.
pub fn apart(found: f64, limit: f64) -> String {
    let text = |decimals: usize| format!("{found:.decimals$}");
    let tells = |text: &String| {
        text.parse::<f64>().is_ok_and(|parsed| (parsed > limit, parsed < limit) == (found > limit, found < limit))
    };
    (2..=12).map(text).find(tells).unwrap_or_else(|| found.to_string())
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
            assert_eq!(format_number(number), text);
        }
        assert_eq!(
            (format_number(0.1f32), format_number(f64::NAN), format_number(f32::INFINITY)),
            ("0.1".into(), "NaN".into(), "inf".into())
        );
    }
}
