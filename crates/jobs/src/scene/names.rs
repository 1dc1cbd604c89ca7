//! Names of materials. Files are called after them, on whatever system the packs travel to.

use super::scene_section::ENVIRONMENT;
use crate::file_name::{composed, folded, is_device};
use std::collections::BTreeMap;
use std::path::Path;
use unicode_normalization::char::is_combining_mark;

/// What a name may be.
pub const ALLOWED: &str = "letters of any script, digits, - and _, as packs are files of that name";
/// Most bytes (of UTF-8) of a name: with what follows in names of files they are within the 255 of most file systems.
pub const MOST_BYTES: usize = 200;
/// The file of the whole build.
const REPORT: &str = "report";

/// Whether files can be called so, or what is allowed instead. `lit` scenes have files of their own.
pub fn check_name(name: &str, lit: bool) -> Result<(), String> {
    if name.is_empty() || !name.chars().all(is_allowed) {
        return Err(ALLOWED.to_owned());
    }
    if name.len() > MOST_BYTES {
        return Err(format!("at most {MOST_BYTES} bytes, as packs are files of that name"));
    }
    if folded(name) == folded(REPORT) {
        return Err(format!("{ALLOWED}; not \"{REPORT}\", the file of the whole build"));
    }
    if lit && folded(name) == folded(ENVIRONMENT) {
        return Err("another name: the maps of the scene's environment have this one".to_owned());
    }
    if is_device(name) {
        return Err("another name: Windows takes files that are called so for devices".to_owned());
    }
    Ok(())
}

/// The first two names that are one file on some system, as they differ in case alone, or in how accents are written.
pub fn same_file<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<(&'a str, &'a str)> {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    names.into_iter().find_map(|name| Some((seen.insert(folded(name), name)?, name)))
}

/// The name of a material from that of its file: accents are composed, what no name may hold becomes `_`, what is too long is cut,
/// and a name that none may be ends in `_`.
pub fn of_file(path: &Path) -> String {
    let stem = composed(&path.file_stem().unwrap_or_default().to_string_lossy());
    let mut name = String::new();
    for c in stem.chars().map(|c| if is_allowed(c) { c } else { '_' }) {
        if name.len() + c.len_utf8() > MOST_BYTES {
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
    fn names_that_are_files_everywhere() {
        for name in ["red", "red-plastic_2", "CONE", "COM10", "com", "environment", "päint", "漢字", "हिन्दी"]
        {
            assert_eq!(check_name(name, false), Ok(()), "{name}");
        }
        for (name, words) in [
            ("", "letters"),
            ("a b", "letters"),
            ("../a", "letters"),
            ("Report", "the whole build"),
            ("con", "devices"),
            ("Lpt1", "devices"),
            ("COM¹", "devices"),
            ("lpt²", "devices"),
            ("a:b", "letters"),
            ("a\u{200b}b", "letters"),
            (&"x".repeat(201), "at most 200 bytes"),
        ] {
            assert!(check_name(name, false).unwrap_err().contains(words), "{name}");
        }
        assert!(check_name("Environment", true).is_err());
    }

    #[test]
    fn case_alone_is_no_difference() {
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
