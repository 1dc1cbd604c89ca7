//! Numbers of bytes with units, as users write them.

use serde::de::{Deserializer, Error, Unexpected, Visitor};
use std::fmt;

/// Description of valid numbers of bytes, for messages.
pub const ALLOWED: &str = "a whole number of bytes, such as 16384, 16KiB or 1MiB";

/// Parses a whole number, alone or with the unit KiB, MiB or GiB (or their first letters).
///
/// # Errors
/// Returns a description of valid values.
pub fn bytes_from_text(text: &str) -> Result<u64, String> {
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match text[number.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => Some(1),
        "k" | "kib" => Some(1 << 10),
        "m" | "mib" => Some(1 << 20),
        "g" | "gib" => Some(1 << 30),
        _ => None,
    };
    let bytes = unit.and_then(|unit: u64| number.trim_end().parse::<u64>().ok()?.checked_mul(unit));
    bytes.ok_or_else(|| format!("expected {ALLOWED}"))
}

/// Deserialises a key of a manifest: a number or a text.
///
/// # Errors
/// Returns an error for values that are no number of bytes.
pub fn bytes_from_manifest<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
    struct NumberOrText;
    impl Visitor<'_> for NumberOrText {
        type Value = u64;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(ALLOWED)
        }

        fn visit_u64<E: Error>(self, value: u64) -> Result<u64, E> {
            Ok(value)
        }

        fn visit_i64<E: Error>(self, value: i64) -> Result<u64, E> {
            u64::try_from(value).map_err(|_| E::invalid_value(Unexpected::Signed(value), &self))
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<u64, E> {
            bytes_from_text(text).map_err(|_| E::invalid_value(Unexpected::Str(text), &self))
        }
    }
    deserializer.deserialize_any(NumberOrText).map(Some)
}

#[cfg(test)]
mod tests {
    use super::bytes_from_text;

    #[test]
    fn units_are_known() {
        for (text, bytes) in [
            ("0", 0),
            ("16384", 16384),
            ("16KiB", 16384),
            ("16 kib", 16384),
            ("2M", 2 << 20),
            ("3GiB", 3 << 30),
            ("7b", 7),
        ] {
            assert_eq!(bytes_from_text(text), Ok(bytes), "{text}");
        }
        for text in ["", "KiB", "-1", "1.5KiB", "16XB", "99999999999999999999", "99999999999999999MiB", "1 2"] {
            assert!(bytes_from_text(text).is_err(), "{text}");
        }
    }
}
