//! Where something stands in a manifest, and what is wrong there.

use std::ops::Range;

/// A manifest that is wrong.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, {field}: found {found}, expected {allowed}{}", suggestion.as_ref().map_or(String::new(), |s| format!(" (did you mean {s}?)")))]
pub struct ManifestError {
    /// Line, from 1.
    pub line: usize,
    /// Key, with the tables it is in.
    pub field: String,
    /// What stands there.
    pub found: String,
    /// What may stand there.
    pub allowed: String,
    /// A near miss.
    pub suggestion: Option<String>,
}

impl ManifestError {
    /// On a line, of a key.
    pub(super) fn new(line: usize, field: impl Into<String>, found: String, allowed: impl Into<String>) -> Self {
        Self { line, field: field.into(), found, allowed: allowed.into(), suggestion: None }
    }
}

/// Where keys of a manifest stand.
pub(super) struct Place<'a> {
    pub(super) text: &'a str,
    pub(super) tree: &'a toml::de::DeTable<'a>,
}

impl Place<'_> {
    /// An error at the deepest key of `path` that is there.
    pub(super) fn error(&self, path: &[&str], found: String, allowed: &str) -> ManifestError {
        ManifestError::new(line_of_key(self.text, self.tree, path), path.join("."), found, allowed)
    }
}

/// The known name that is most like `name`, if any is.
pub fn near_miss(name: &str, known: &[&str]) -> Option<String> {
    known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(name, k), *k))
        .filter(|(distance, k)| *distance <= 1 + k.len() / 4)
        .min()
        .map(|(_, k)| k.to_owned())
}

/// The line, from 1, where a span of a manifest starts.
pub fn line_of(text: &str, span: Option<Range<usize>>) -> usize {
    let end = span.map_or(0, |s| s.start.min(text.len()));
    1 + text.as_bytes()[..end].iter().filter(|byte| **byte == b'\n').count()
}

/// Line of the deepest key of `path` that is there.
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

/// The line on which a span starts, shortened.
pub(super) fn snippet(text: &str, span: Option<Range<usize>>) -> String {
    const LONGEST: usize = 60;
    let line = text.lines().nth(line_of(text, span) - 1).unwrap_or_default().trim();
    // As it will be told.
    let line: String = line.chars().take(LONGEST + 1).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    let short: String = line.chars().take(LONGEST).collect();
    if short.len() < line.len() { format!("{short}...") } else { short }
}
