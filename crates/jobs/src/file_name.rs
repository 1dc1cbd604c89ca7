//! Names of files, on whatever system they travel to.

use std::path::{Component, Path};
use unicode_normalization::UnicodeNormalization as _;

/// Whether it is the name of a file in a folder, and of nothing elsewhere.
pub fn is_plain(name: &str) -> bool {
    let mut components = Path::new(name).components();
    matches!((components.next(), components.next()), (Some(Component::Normal(_)), None))
}

/// A name with its accents composed (Unicode's form C), as people type it: macOS tells names of files in other forms.
pub fn composed(name: &str) -> String {
    name.nfc().collect()
}

/// What two names have in common that are one file on some system: they differ in case or in how accents are written.
pub fn folded(name: &str) -> String {
    name.nfc().flat_map(char::to_lowercase).nfc().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_meet() {
        for (a, b) in [("a", "A"), ("é", "e\u{301}"), ("É", "e\u{301}"), ("\u{2126}", "\u{3c9}")] {
            assert_eq!(folded(a), folded(b), "{a} {b}");
        }
        for (a, b) in [("e", "é"), ("漢字", "木綿"), ("ss", "ß")] {
            assert_ne!(folded(a), folded(b), "{a} {b}");
        }
        assert_eq!(composed("e\u{301}"), "é");
    }
}
