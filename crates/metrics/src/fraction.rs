//! Fractions and percentages of options.

use brdfc_core::words::format_number;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::str::FromStr;

/// A share: `0.03` or `3%`. A bare number above 1 is ambiguous; [`Fraction::checked`] rejects it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fraction {
    value: f64,
    is_percentage: bool,
}

/// Description of valid fractions, for messages.
pub const ALLOWED: &str = "a fraction, such as 0.03, or a percentage, such as 3%";

impl Fraction {
    /// Creates a fraction from a bare number.
    pub fn bare(value: f64) -> Self {
        Self { value, is_percentage: false }
    }

    /// The share as a number, for callers that check its range.
    pub fn value(self) -> f64 {
        self.value
    }

    /// The share as a number, 0 or more.
    ///
    /// # Errors
    /// Returns a description of valid values for a negative number, for text that is no number, and for a bare number
    /// above 1.
    pub fn checked(self) -> Result<f64, String> {
        let Self { value, is_percentage } = self;
        // No error is that large, and such numbers are unreadable.
        if !(0.0..=1e6).contains(&value) {
            return Err(ALLOWED.to_owned());
        }
        if value > 1.0 && !is_percentage {
            return Err(format!(
                "a fraction or a percentage; write {} or {}%",
                format_number(value / 100.0),
                format_number(value)
            ));
        }
        Ok(value)
    }
}

/// Writes the fraction as the user wrote it.
impl fmt::Display for Fraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_percentage {
            write!(f, "{}%", format_number(100.0 * self.value))
        } else {
            f.write_str(&format_number(self.value))
        }
    }
}

impl FromStr for Fraction {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, is_percentage) = match text.strip_suffix('%') {
            Some(number) => (number.trim_end(), true),
            None => (text, false),
        };
        let number: f64 = number.trim_start().parse().map_err(|_| format!("expected {ALLOWED}"))?;
        Ok(Self { value: if is_percentage { number / 100.0 } else { number }, is_percentage })
    }
}

impl<'de> Deserialize<'de> for Fraction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a fraction, such as 0.03, or a percentage, such as 3%")]
        enum NumberOrText {
            Number(f64),
            Text(String),
        }
        match NumberOrText::deserialize(deserializer)? {
            NumberOrText::Number(value) => Ok(Self::bare(value)),
            NumberOrText::Text(text) => text.parse().map_err(D::Error::custom),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str) -> Result<f64, String> {
        text.parse::<Fraction>().and_then(Fraction::checked)
    }

    #[test]
    fn numbers_and_percentages() {
        for (text, value) in [("0.03", 0.03), ("3%", 0.03), ("3 %", 0.03), ("150%", 1.5), ("1", 1.0), ("0", 0.0)] {
            assert!((checked(text).unwrap() - value).abs() < 1e-15, "{text}");
        }
        assert_eq!("2.5%".parse::<Fraction>().unwrap().to_string(), "2.5%");
    }

    #[test]
    fn ambiguous_numbers_are_rejected() {
        assert_eq!(checked("3").unwrap_err(), "a fraction or a percentage; write 0.03 or 3%");
        for text in ["-1", "-1%", "NaN", "inf", "x", "%", ""] {
            assert!(checked(text).unwrap_err().contains("such as 0.03"), "{text}");
        }
    }

    #[test]
    fn of_files() {
        let read = |text: &str| serde_json::from_str::<Fraction>(text).map(Fraction::checked);
        assert_eq!(read("0.03").unwrap(), Ok(0.03));
        assert_eq!(read("\"3%\"").unwrap(), Ok(0.03));
        assert!(read("3").unwrap().is_err());
        assert!(read("\"three\"").unwrap_err().to_string().contains("or a percentage, such as 3%"));
    }
}
