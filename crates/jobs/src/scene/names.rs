//! Names of materials. Files are called after them, on whatever system the packs travel to.

use super::scene_section::ENVIRONMENT;
use std::collections::BTreeMap;
use std::path::Path;

/// What a name may be.
pub const ALLOWED: &str = "letters, digits, - and _, as packs are files of that name";
/// The file of the whole build.
const REPORT: &str = "report";

/// Whether files can be called so, or what is allowed instead. `lit` scenes have files of their own.
pub fn check_name(name: &str, lit: bool) -> Result<(), String> {
    if name.is_empty() || !name.chars().all(is_allowed) {
        return Err(ALLOWED.to_owned());
    }
    if name.eq_ignore_ascii_case(REPORT) {
        return Err(format!("{ALLOWED}; not \"{REPORT}\", the file of the whole build"));
    }
    if lit && name.eq_ignore_ascii_case(ENVIRONMENT) {
        return Err("another name: the maps of the scene's environment have this one".to_owned());
    }
    if is_device(name) {
        return Err("another name: Windows takes files that are called so for devices".to_owned());
    }
    Ok(())
}

/// The first two names that differ in the case of letters alone: some systems have one file for both.
pub fn same_but_for_case<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<(&'a str, &'a str)> {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    names.into_iter().find_map(|name| Some((seen.insert(name.to_ascii_lowercase(), name)?, name)))
}

/// The name of a material from that of its file: what no name may hold becomes `_`, and a name that none may be ends in one.
pub fn of_file(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut name: String = stem.chars().map(|c| if is_allowed(c) { c } else { '_' }).collect();
    if check_name(&name, true).is_err() {
        name.push('_');
    }
    name
}

fn is_allowed(c: char) -> bool {
    c.is_ascii_alphanumeric() || "-_".contains(c)
}

/// Names that stand for devices on Windows, with any extension.
fn is_device(name: &str) -> bool {
    let name = name.to_ascii_uppercase();
    let numbered = |prefix| name.strip_prefix(prefix).is_some_and(|n| n.len() == 1 && ("1"..="9").contains(&n));
    ["CON", "PRN", "AUX", "NUL"].contains(&name.as_str()) || numbered("COM") || numbered("LPT")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_files_everywhere() {
        for name in ["red", "red-plastic_2", "CONE", "COM10", "com", "environment"] {
            assert_eq!(check_name(name, false), Ok(()), "{name}");
        }
        for (name, words) in [
            ("", "letters"),
            ("a b", "letters"),
            ("../a", "letters"),
            ("Report", "the whole build"),
            ("con", "devices"),
            ("Lpt1", "devices"),
        ] {
            assert!(check_name(name, false).unwrap_err().contains(words), "{name}");
        }
        assert!(check_name("Environment", true).is_err());
    }

    #[test]
    fn case_alone_is_no_difference() {
        assert_eq!(same_but_for_case(["a", "b", "A"]), Some(("a", "A")));
        assert_eq!(same_but_for_case(["a", "b"]), None);
    }

    #[test]
    fn names_of_files() {
        assert_eq!(of_file(Path::new("scans/red plastic (2).binary")), "red_plastic__2_");
        assert_eq!(of_file(Path::new("x/y.v2.brdf")), "y_v2");
        for (file, name) in [("con.bsdf", "con_"), ("Report.brdf", "Report_"), ("environment.brdf", "environment_")] {
            assert_eq!(of_file(Path::new(file)), name);
        }
    }
}
