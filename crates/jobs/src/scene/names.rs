//! Names of materials, which are file names on all systems.

use super::scene_section::ENVIRONMENT;
use crate::file_name::{composed, folded, is_device};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;
use unicode_normalization::char::is_combining_mark;

/// Characters of a name, for messages.
pub const ALLOWED: &str = "letters of any script, digits, - and _ (packs have this file name)";
/// Length of the longest name, bytes of UTF-8. With the endings of files it stays below the 255 bytes of most file
/// systems.
pub const MAX_BYTES: usize = 200;
/// Name of the build report.
const REPORT: &str = "report";

/// Checks the name of a material. `lit` is true if the scene has an environment, whose files reserve another name.
///
/// # Errors
/// Returns the expected names.
pub fn check_name(name: &str, lit: bool) -> Result<(), String> {
    if name.is_empty() || !name.chars().all(is_allowed) {
        return Err(ALLOWED.to_owned());
    }
    if name.len() > MAX_BYTES {
        return Err(format!("at most {MAX_BYTES} bytes of UTF-8 (packs have this file name)"));
    }
    if folded(name) == folded(REPORT) {
        return Err(format!("another name (\"{REPORT}\" is reserved for the build report)"));
    }
    if lit && folded(name) == folded(ENVIRONMENT) {
        return Err("another name (this one is reserved for the maps of the scene's environment)".to_owned());
    }
    if is_device(name) {
        return Err("another name (this one is a device on Windows)".to_owned());
    }
    Ok(())
}

/// Finds two names that are one file on some systems, because they differ only in case or in the encoding of accents.
pub fn same_file<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<(&'a str, &'a str)> {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    names.into_iter().find_map(|name| Some((seen.insert(folded(name), name)?, name)))
}

/// Derives the name of a material from its file: composes accents, replaces other characters with `_`, truncates long
/// names, and appends `_` to reserved names.
pub fn of_file(path: &Path) -> String {
    valid(path.file_stem())
}

/// Derives the name of a folder or, with its extension, of a file in the same way.
pub fn of_whole(path: &Path) -> String {
    // `.` and `..` have the names of the folders that they are.
    let real = if path.file_name().is_none() { path.canonicalize().ok() } else { None };
    valid(real.as_deref().unwrap_or(path).file_name())
}

fn valid(text: Option<&OsStr>) -> String {
    let stem = composed(&text.unwrap_or_default().to_string_lossy());
    let mut name = String::new();
    for c in stem.chars().map(|c| if is_allowed(c) { c } else { '_' }) {
        if name.len() + c.len_utf8() > MAX_BYTES {
            break;
        }
        name.push(c);
    }
    if check_name(&name, true).is_err() {
        name.push('_');
    }
    name
}

fn is_allowed(c: char) -> bool {
    c.is_alphanumeric() || is_combining_mark(c) || "-_".contains(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_files_on_all_systems() {
        for name in ["red", "red-plastic_2", "CONE", "COM10", "com", "environment", "päint", "漢字", "हिन्दी"]
        {
            assert_eq!(check_name(name, false), Ok(()), "{name}");
        }
        for (name, words) in [
            ("", "letters"),
            ("a b", "letters"),
            ("../a", "letters"),
            ("Report", "the build report"),
            ("con", "a device"),
            ("Lpt1", "a device"),
            ("COM¹", "a device"),
            ("lpt²", "a device"),
            ("a:b", "letters"),
            ("a\u{200b}b", "letters"),
            (&"x".repeat(201), "at most 200 bytes"),
        ] {
            assert!(check_name(name, false).unwrap_err().contains(words), "{name}");
        }
        assert!(check_name("Environment", true).is_err());
    }

    #[test]
    fn names_that_differ_only_in_case_are_equal() {
        assert_eq!(same_file(["a", "b", "A"]), Some(("a", "A")));
        assert_eq!(same_file(["é", "e\u{301}"]), Some(("é", "e\u{301}")));
        assert_eq!(same_file(["straße", "STRASSE"]), Some(("straße", "STRASSE")));
        assert_eq!(same_file(["a", "b", "漢字", "木綿"]), None);
    }

    #[test]
    fn names_of_files() {
        assert_eq!(of_file(Path::new("scans/red plastic (2).binary")), "red_plastic__2_");
        assert_eq!(of_file(Path::new("x/y.v2.brdf")), "y_v2");
        assert_eq!(of_file(Path::new("木綿.binary")), "木綿");
        assert_eq!(of_file(Path::new("e\u{301}.binary")), "é");
        assert_eq!(of_file(Path::new(&("漢".repeat(80) + ".brdf"))), "漢".repeat(66));
        for (file, name) in [("con.bsdf", "con_"), ("Report.brdf", "Report_"), ("environment.brdf", "environment_")] {
            assert_eq!(of_file(Path::new(file)), name);
        }
    }
}
