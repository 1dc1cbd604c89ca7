//! File names that are portable between systems.

use std::path::{Component, Path};
use unicode_normalization::UnicodeNormalization as _;

/// Returns true for a plain file name, without a path to another folder.
pub fn is_plain(name: &str) -> bool {
    let mut components = Path::new(name).components();
    matches!((components.next(), components.next()), (Some(Component::Normal(_)), None))
}

/// Composes accents (Unicode normalization form C), because macOS returns file names in other forms.
pub fn composed(name: &str) -> String {
    name.nfc().collect()
}

/// Folds case and accents. Names with the same result are one file on some systems.
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
