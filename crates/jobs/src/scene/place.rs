//! Errors of manifests, with their lines and keys.

use std::ops::Range;

/// An error in a manifest.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, {field}: {}{}", problem(found, allowed), hint(suggestion.as_deref()))]
pub struct ManifestError {
    /// Line of the manifest, counted from 1.
    pub line: usize,
    /// Key, with its tables.
    pub field: String,
    /// The value in the manifest; empty if a value is missing or the text cannot be read.
    pub found: String,
    /// The expected values; without a value that was found, the problem and its remedy.
    pub allowed: String,
    /// A known name with a similar spelling.
    pub suggestion: Option<String>,
}

impl ManifestError {
    /// Creates an error at a line and a key.
    pub(super) fn new(line: usize, field: impl Into<String>, found: String, allowed: impl Into<String>) -> Self {
        Self { line, field: field.into(), found, allowed: allowed.into(), suggestion: None }
    }

    /// Creates an error without a value that was found.
    pub(super) fn without_value(line: usize, field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::new(line, field, String::new(), problem)
    }
}

fn problem(found: &str, allowed: &str) -> String {
    if found.is_empty() { allowed.to_owned() } else { format!("found {found}, expected {allowed}") }
}

fn hint(suggestion: Option<&str>) -> String {
    suggestion.map_or(String::new(), |name| format!("; did you mean {name}?"))
}

/// Text and tree of a manifest, to locate keys.
pub(super) struct Place<'a> {
    pub(super) text: &'a str,
    pub(super) tree: &'a toml::de::DeTable<'a>,
}

impl Place<'_> {
    /// Creates an error at the deepest existing key of `path`.
    pub(super) fn error(&self, path: &[&str], found: String, allowed: &str) -> ManifestError {
        ManifestError::new(line_of_key(self.text, self.tree, path), path.join("."), found, allowed)
    }
}

/// Finds the known name with the most similar spelling; `None` if none is similar, or if only one name is known.
pub fn near_miss(name: &str, known: &[&str]) -> Option<String> {
    let choices = if known.len() > 1 { known } else { &[] };
    choices
        .iter()
        .map(|k| (strsim::damerau_levenshtein(name, k), *k))
        .filter(|(distance, k)| *distance <= 1 + k.len() / 4)
        .min()
        .map(|(_, k)| k.to_owned())
}

/// Line of the start of a span, from 1.
pub fn line_of(text: &str, span: Option<Range<usize>>) -> usize {
    let end = span.map_or(0, |s| s.start.min(text.len()));
    1 + text.as_bytes()[..end].iter().filter(|byte| **byte == b'\n').count()
}

/// Line of the deepest existing key of `path`, from 1.
pub(super) fn line_of_key(text: &str, tree: &toml::de::DeTable<'_>, path: &[&str]) -> usize {
    let mut line = 1;
    let mut table = Some(tree);
    for name in path {
        let Some((key, value)) = table.and_then(|t| t.iter().find(|(k, _)| k.get_ref() == name)) else { break };
        line = line_of(text, Some(key.span()));
        table = value.get_ref().as_table();
    }
    line
}

/// The line where a span starts, truncated.
pub(super) fn snippet(text: &str, span: Option<Range<usize>>) -> String {
    const MAX_CHARS: usize = 60;
    let line = text.lines().nth(line_of(text, span) - 1).unwrap_or_default().trim();
    // Control characters are not printed.
    let line: String = line.chars().take(MAX_CHARS + 1).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    let short: String = line.chars().take(MAX_CHARS).collect();
    if short.len() < line.len() { format!("{short}...") } else { short }
}
