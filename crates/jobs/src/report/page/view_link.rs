//! Links from a report to the viewer page.

use std::collections::BTreeSet;
use std::fmt::Write as _;

/// A viewer page next to the report, and the materials on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ViewLink {
    file: String,
    names: BTreeSet<String>,
}

impl ViewLink {
    /// The page in `file` that shows materials of these names.
    pub fn new(file: &str, names: impl IntoIterator<Item = String>) -> Self {
        Self { file: file.to_owned(), names: names.into_iter().collect() }
    }

    /// The address of the whole page.
    pub fn whole(&self) -> String {
        escaped(&self.file)
    }

    /// The address at which the page shows a material of a build, next to its source if the page has it. `None` if the page does
    /// not have the material.
    pub fn of_material(&self, material: &str) -> Option<String> {
        let source = source_name(material);
        let right = if self.names.contains(&source) { escaped(&source) } else { String::new() };
        let names = self.names.contains(material).then(|| escaped(material))?;
        Some(format!("{}#left={names}&right={right}", self.whole()))
    }
}

/// Name of the source of a build's material on viewer pages.
pub fn source_name(material: &str) -> String {
    format!("{material}, source")
}

/// Percent-encodes every byte except letters, digits, `-`, `_` and `.`.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => escaped.push(byte.into()),
            _ => {
                let _ = write!(escaped, "%{byte:02X}");
            }
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_escaped() {
        let names = ["red & blue", "red & blue, source", "ünder"].map(str::to_owned);
        let link = ViewLink::new("all packs.html", names);
        let expected = "all%20packs.html#left=red%20%26%20blue&right=red%20%26%20blue%2C%20source";
        assert_eq!(link.of_material("red & blue").unwrap(), expected);
        assert_eq!(link.of_material("ünder").unwrap(), "all%20packs.html#left=%C3%BCnder&right=");
        assert_eq!(link.of_material("green"), None);
    }
}
