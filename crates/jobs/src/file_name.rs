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

/// Folds case and accents. Names with the same result are one file on some systems. Lower, then upper case, in which ß, ẞ, ſ,
/// ς and ligatures become ordinary letters; the dotless ı stays one of its own.
pub fn folded(name: &str) -> String {
    let fold = |letter: char| -> String {
        if letter == 'ı' { letter.to_string() } else { letter.to_lowercase().collect::<String>().to_uppercase() }
    };
    name.nfc().map(fold).collect::<String>().nfc().collect()
}

/// Returns true if a name stands for a device on Windows, with any extensions.
pub fn is_device(name: &str) -> bool {
    let name = name.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let is_number = |text: &str| {
        let mut letters = text.chars();
        matches!((letters.next(), letters.next()), (Some('1'..='9' | '¹' | '²' | '³'), None))
    };
    let numbered = |prefix| name.strip_prefix(prefix).is_some_and(is_number);
    ["CON", "PRN", "AUX", "NUL"].contains(&name.as_str()) || numbered("COM") || numbered("LPT")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_meet() {
        for (a, b) in [
            ("a", "A"),
            ("é", "e\u{301}"),
            ("É", "e\u{301}"),
            ("\u{2126}", "\u{3c9}"),
            ("straße", "STRASSE"),
            ("straße", "STRAẞE"),
            ("ﬁn", "fin"),
            ("λόγος", "ΛΌΓΟΣ"),
            ("ς", "σ"),
        ] {
            assert_eq!(folded(a), folded(b), "{a} {b}");
        }
        for (a, b) in [("e", "é"), ("漢字", "木綿"), ("s", "ß"), ("kırmızı", "kirmizi")] {
            assert_ne!(folded(a), folded(b), "{a} {b}");
        }
        assert_eq!(composed("e\u{301}"), "é");
    }

    #[test]
    fn devices_of_windows() {
        for name in ["con", "Nul.tar.gz", "com1", "COM¹", "lpt².x", "aux .y"] {
            assert!(is_device(name), "{name}");
        }
        for name in ["cone", "com", "com10", "com0", "lpt⁴", "xcon", "a.con", ""] {
            assert!(!is_device(name), "{name}");
        }
    }
}
