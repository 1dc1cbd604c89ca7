//! Keys of a manifest and the kinds of their values. This module checks kinds; the sections check ranges.

use super::place::{ManifestError, line_of, near_miss};
use brdfc_core::byte_count;
use brdfc_core::words::{one_of, quoted};
use brdfc_metrics::fraction::{self, Fraction};
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A key of a table.
#[derive(Debug, Clone)]
pub(super) struct Key {
    pub(super) name: &'static str,
    pub(super) shape: Shape,
    /// Description of the range, for messages; empty without a limit.
    pub(super) range: &'static str,
    pub(super) is_required: bool,
}

/// A kind of value.
#[derive(Debug, Clone)]
pub(super) enum Shape {
    Text,
    Truth,
    Number,
    /// An integer, 0 or more.
    WholeNumber,
    /// A boolean, or an integer of 0 or more.
    TruthOrWholeNumber,
    /// A list of this many numbers.
    Numbers(usize),
    /// One number, or a list of three.
    NumberOrThree,
    Texts,
    /// A fraction or a percentage.
    Share,
    /// A number of bytes, or a text such as 16KiB.
    Bytes,
    /// A table with these keys.
    Table(Cow<'static, [Key]>),
    /// A list of tables with these keys.
    Tables(&'static [Key]),
    /// Tables with these keys, by name.
    NamedTables(Cow<'static, [Key]>),
    /// Strings by name.
    NamedTexts,
}

/// Endings of the descriptions of ranges without an upper bound.
const OPEN: [&str; 2] = ["or more", "above 0"];

/// Creates an optional key.
pub(super) const fn key(name: &'static str, shape: Shape, range: &'static str) -> Key {
    Key { name, shape, range, is_required: false }
}

/// Creates a required key.
pub(super) const fn required(name: &'static str, shape: Shape, range: &'static str) -> Key {
    Key { name, shape, range, is_required: true }
}

/// Checks the keys of a manifest and the kinds of their values.
///
/// # Errors
/// Returns an error at the first unknown key or wrong kind of value.
pub(super) fn check(text: &str, tree: &DeTable<'_>, keys: &[Key]) -> Result<(), ManifestError> {
    Checked { text }.table(tree, keys, "", "")
}

struct Checked<'a> {
    text: &'a str,
}

impl Checked<'_> {
    /// Checks a table. `heading` is its header in the file, `field` its path in messages.
    fn table(&self, table: &DeTable<'_>, keys: &[Key], field: &str, heading: &str) -> Result<(), ManifestError> {
        let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
        if let Some(unknown) = table.keys().find(|key| !names.contains(&key.get_ref().as_ref())) {
            return Err(ManifestError {
                line: line_of(self.text, Some(unknown.span())),
                field: if heading.is_empty() { "key".to_owned() } else { format!("key in {heading}") },
                found: quoted(unknown.get_ref()),
                allowed: one_of(&names),
                suggestion: near_miss(unknown.get_ref(), &names),
            });
        }
        for (name, value) in table.iter() {
            let key = keys.iter().find(|key| key.name == name.get_ref()).expect("unknown keys are rejected above");
            self.value(value, &key.shape, key.range, &joined(field, name.get_ref()), name.span())?;
        }
        Ok(())
    }

    fn value(
        &self,
        value: &Spanned<DeValue<'_>>,
        shape: &Shape,
        range: &str,
        field: &str,
        key: Range<usize>,
    ) -> Result<(), ManifestError> {
        // Counting lines takes a pass over the text, so only errors do it.
        let wrong = |allowed: String| {
            Err(ManifestError::new(line_of(self.text, Some(key.clone())), field, self.format_value(value), allowed))
        };
        let heading = field;
        match (shape, value.get_ref()) {
            (Shape::Table(keys), DeValue::Table(table)) => self.table(table, keys, field, &format!("[{heading}]")),
            (Shape::Tables(keys), DeValue::Array(array)) if array.iter().all(|entry| entry.get_ref().is_table()) => {
                for (number, entry) in array.iter().enumerate() {
                    let table = entry.get_ref().as_table().expect("all are tables");
                    let field = format!("{field}[{number}]");
                    self.table(table, keys, &field, &format!("[[{heading}]]"))?;
                    if let Some(key) = keys.iter().find(|key| key.is_required && !table.contains_key(key.name)) {
                        let line = line_of(self.text, Some(entry.span()));
                        let (name, value) = (key.name, expected_value(&key.shape, key.range, key.name));
                        let wrong = format!("no {name}; expected {name} = {value}");
                        return Err(ManifestError::without_value(line, field, wrong));
                    }
                }
                Ok(())
            }
            (Shape::NamedTables(_) | Shape::NamedTexts, DeValue::Table(table)) => {
                let each = match shape {
                    Shape::NamedTables(keys) => Shape::Table(keys.clone()),
                    _ => Shape::Text,
                };
                table.iter().try_for_each(|(name, value)| {
                    self.value(value, &each, "", &joined(field, name.get_ref()), name.span())
                })
            }
            (shape, value) => match fits(shape, value) {
                Fit::Fits => Ok(()),
                Fit::Other => wrong(expected_value(shape, range, field)),
                // The range of other keys already has an upper bound.
                Fit::TooLarge(most) if range.is_empty() || OPEN.iter().any(|end| range.ends_with(end)) => {
                    wrong(format!("{} (up to {most})", expected_value(shape, range, field)))
                }
                Fit::TooLarge(_) => wrong(expected_value(shape, range, field)),
            },
        }
    }

    /// Formats a value as written in the file, truncated.
    fn format_value(&self, value: &Spanned<DeValue<'_>>) -> String {
        const MAX_CHARS: usize = 40;
        match value.get_ref() {
            DeValue::Table(_) => "a table".to_owned(),
            DeValue::Array(array) if array.iter().any(|entry| entry.get_ref().is_table()) => {
                "a list with tables".to_owned()
            }
            _ => {
                let written = self.text.get(value.span()).unwrap_or_default().split_whitespace();
                let written = written.collect::<Vec<_>>().join(" ");
                let short: String = written.chars().take(MAX_CHARS).collect();
                if short.len() < written.len() { format!("{short}...") } else { short }
            }
        }
    }
}

fn joined(field: &str, name: &str) -> String {
    if field.is_empty() { name.to_owned() } else { format!("{field}.{name}") }
}

/// Result of the check of a kind.
enum Fit {
    Fits,
    /// Another kind.
    Other,
    /// The right kind, but above this bound.
    TooLarge(String),
}

impl From<bool> for Fit {
    fn from(fits: bool) -> Self {
        if fits { Self::Fits } else { Self::Other }
    }
}

fn fits(shape: &Shape, value: &DeValue<'_>) -> Fit {
    let are_numbers = |value: &DeValue<'_>, count: usize| {
        let array = value.as_array().filter(|array| array.len() == count);
        array.is_some_and(|array| array.iter().all(|entry| matches!(number(entry.get_ref()), Fit::Fits)))
    };
    match shape {
        Shape::Text => value.is_str().into(),
        Shape::Truth => value.is_bool().into(),
        Shape::Number => number(value),
        Shape::TruthOrWholeNumber if value.is_bool() => Fit::Fits,
        Shape::WholeNumber | Shape::TruthOrWholeNumber => match whole(value) {
            Some(whole) if whole > u32::MAX.into() => Fit::TooLarge(u32::MAX.to_string()),
            whole => whole.is_some_and(|whole| whole >= 0).into(),
        },
        Shape::Numbers(count) => are_numbers(value, *count).into(),
        Shape::NumberOrThree if value.is_array() => are_numbers(value, 3).into(),
        Shape::NumberOrThree => number(value),
        Shape::Texts => value.as_array().is_some_and(|array| array.iter().all(|entry| entry.get_ref().is_str())).into(),
        Shape::Share => match value.as_str() {
            Some(text) => text.parse::<Fraction>().is_ok().into(),
            None => number(value),
        },
        Shape::Bytes => match (value.as_str(), whole(value)) {
            (Some(text), _) => byte_count::bytes_from_text(text).is_ok().into(),
            (None, Some(whole)) if whole > i64::MAX.into() => Fit::TooLarge(i64::MAX.to_string()),
            (None, whole) => whole.is_some_and(|whole| whole >= 0).into(),
        },
        Shape::Table(_) | Shape::Tables(_) | Shape::NamedTables(_) | Shape::NamedTexts => Fit::Other,
    }
}

/// Checks that a value is a number within the range of `i64` or `f64`.
fn number(value: &DeValue<'_>) -> Fit {
    match value {
        DeValue::Integer(_) if whole(value).is_none_or(|whole| i64::try_from(whole).is_err()) => {
            Fit::TooLarge(format!("{}; larger ones have an exponent, such as 1e20", i64::MAX))
        }
        DeValue::Float(float) => {
            let is_cut = float.as_str().parse::<f64>().is_ok_and(f64::is_infinite) && !float.as_str().contains("inf");
            if is_cut { Fit::TooLarge(format!("{:e}", f64::MAX)) } else { Fit::Fits }
        }
        other => other.is_integer().into(),
    }
}

/// The value of an integer, clamped to the range of `i128`.
fn whole(value: &DeValue<'_>) -> Option<i128> {
    let integer = value.as_integer()?;
    let longest = if integer.as_str().starts_with('-') { i128::MIN } else { i128::MAX };
    Some(i128::from_str_radix(integer.as_str(), integer.radix()).unwrap_or(longest))
}

/// Describes the expected values of a key.
fn expected_value(shape: &Shape, range: &str, field: &str) -> String {
    let kind = match shape {
        Shape::Text => "a string".to_owned(),
        Shape::Truth => "true or false".to_owned(),
        Shape::Number => "a number".to_owned(),
        Shape::WholeNumber => "a whole number".to_owned(),
        Shape::TruthOrWholeNumber => return range.to_owned(),
        Shape::Numbers(2) => "two numbers".to_owned(),
        Shape::Numbers(3) => "three numbers".to_owned(),
        Shape::Numbers(count) => format!("{count} numbers"),
        Shape::NumberOrThree => "a number or three".to_owned(),
        Shape::Texts => "a list of strings".to_owned(),
        Shape::Share => fraction::ALLOWED.to_owned(),
        Shape::Bytes => byte_count::ALLOWED.to_owned(),
        Shape::Table(_) | Shape::NamedTexts => format!("a table, [{field}]"),
        Shape::Tables(_) => format!("tables, each [[{field}]]"),
        Shape::NamedTables(_) => format!("tables, each [{field}.NAME]"),
    };
    if range.is_empty() { kind } else { format!("{kind}: {range}") }
}
