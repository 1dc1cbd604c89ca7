//! The layers of DESIGN section 2: which part may use which.

use std::path::{Path, PathBuf};

/// Each folder of `src/`, with the folders that it may use besides itself. A new folder needs a line here.
const MAY_USE: &[(&str, &[&str])] = &[
    ("source", &[]),
    ("metrics", &["source"]),
    ("brdf", &["source", "metrics"]),
    ("btf", &["source", "metrics"]),
    ("bandwidth", &["source", "metrics"]),
    ("render", &["source", "metrics", "brdf", "btf", "bandwidth"]),
    ("report", &["source", "metrics", "brdf", "btf", "bandwidth", "render"]),
    ("build", &["source", "metrics", "brdf", "btf", "bandwidth", "render", "report"]),
    ("cli", &["source", "metrics", "brdf", "btf", "bandwidth", "render", "report", "build"]),
];

const STAGES: [&str; 4] = ["metrics", "brdf", "btf", "bandwidth"];
/// What a pure function has no need of.
const IMPURE: [&str; 7] = ["std::fs", "std::env", "std::time", "std::process", "std::net", "clap", "ctrlc"];

/// The text without comments and without what stands in string literals.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '/' if chars.peek() == Some(&'/') => {
                while chars.peek().is_some_and(|c| *c != '\n') {
                    chars.next();
                }
            }
            '"' => {
                while let Some(inside) = chars.next() {
                    match inside {
                        '\\' => drop(chars.next()),
                        '"' => break,
                        _ => {}
                    }
                }
                code += "\"\"";
            }
            '\'' => {
                // A character literal; a lifetime has no quote two characters on.
                code.push(c);
                let mut ahead = chars.clone();
                let first = ahead.next();
                if first == Some('\\') || ahead.next() == Some('\'') {
                    while chars.next().is_some_and(|inside| inside != '\'') {}
                    code.push(c);
                }
            }
            _ => code.push(c),
        }
    }
    code
}

/// Every path in the code, `use` trees spelled out: `use a::{b, c::d}` is `a::b` and `a::c::d`.
fn paths(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    let bytes = code.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        if is_word(bytes[at]) {
            at = path(code, at, "", &mut found);
        } else {
            at += 1;
        }
    }
    found
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Reads the path that starts at `at`, puts it behind `prefix`, and returns where it ends.
fn path(code: &str, mut at: usize, prefix: &str, found: &mut Vec<String>) -> usize {
    let bytes = code.as_bytes();
    let start = at;
    while at < bytes.len() && is_word(bytes[at]) {
        at += 1;
    }
    let mut so_far = format!("{prefix}{}", &code[start..at]);
    while code[at..].starts_with("::") {
        at += 2;
        if code[at..].starts_with('{') {
            at += 1;
            let inner = format!("{so_far}::");
            while at < bytes.len() && bytes[at] != b'}' {
                at = if is_word(bytes[at]) { path(code, at, &inner, found) } else { at + 1 };
            }
            return at + 1;
        }
        let word = at;
        while at < bytes.len() && is_word(bytes[at]) {
            at += 1;
        }
        if word == at {
            break;
        }
        so_far = format!("{so_far}::{}", &code[word..at]);
    }
    found.push(so_far);
    at
}

/// What breaks the rule in a file of `src/`, whose modules are `modules`: `["brdf", "haar"]` for `src/brdf/haar.rs`.
fn complaints(modules: &[&str], text: &str) -> Vec<String> {
    let Some((layer, allowed)) = MAY_USE.iter().find(|(layer, _)| modules.first() == Some(layer)) else {
        return vec![format!("{modules:?} is in no layer: add it to MAY_USE")];
    };
    let mut wrong = Vec::new();
    for path in paths(&code_of(text)) {
        let segments: Vec<&str> = path.split("::").collect();
        let up = segments.iter().take_while(|segment| **segment == "super").count();
        let used = match segments[0] {
            "crate" => segments.get(1),
            "brdfc" if segments.len() > 1 => segments.get(1),
            // As many steps up as there are modules end at the crate itself, or, from an inner module, below it.
            "super" if up >= modules.len() => segments.get(up).filter(|name| MAY_USE.iter().any(|(l, _)| l == *name)),
            _ => None,
        };
        if let Some(used) = used
            && used != layer
            && !allowed.contains(used)
        {
            wrong.push(format!("{layer} uses {path}"));
        }
        if STAGES.contains(layer) && IMPURE.iter().any(|name| path == *name || path.starts_with(&format!("{name}::"))) {
            wrong.push(format!("the stage {layer} uses {path}"));
        }
    }
    wrong
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn arrows_point_one_way() {
    let src = root().join("src");
    let mut checked = 0;
    let mut wrong = Vec::new();
    for file in rust_files(&src) {
        let relative = file.strip_prefix(&src).unwrap().with_extension("");
        let mut modules: Vec<&str> = relative.iter().map(|part| part.to_str().unwrap()).collect();
        if modules.len() == 1 && ["lib", "main"].contains(&modules[0]) {
            continue;
        }
        modules.retain(|module| *module != "mod");
        let text = std::fs::read_to_string(&file).unwrap();
        wrong.extend(complaints(&modules, &text).into_iter().map(|line| format!("{}: {line}", relative.display())));
        checked += 1;
    }
    assert!(checked > 40, "{checked} files");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn formats_stand_alone() {
    for file in rust_files(&root().join("formats")) {
        let text = std::fs::read_to_string(&file).unwrap();
        let wrong: Vec<_> = paths(&code_of(&text)).into_iter().filter(|path| path.starts_with("brdfc::")).collect();
        assert!(wrong.is_empty(), "{}: {wrong:?}", file.display());
    }
    let manifest: toml::Table = std::fs::read_to_string(root().join("formats/Cargo.toml")).unwrap().parse().unwrap();
    for section in ["dependencies", "dev-dependencies", "build-dependencies"] {
        let names = manifest.get(section).and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::keys);
        assert!(names.into_iter().all(|name| name != "brdfc"), "{section}");
    }
}

#[test]
fn wrong_arrows_are_seen() {
    for (modules, text, expected) in [
        (["brdf", "haar"], "use crate::build::run;", "brdf uses crate::build::run"),
        (["brdf", "haar"], "use crate::{source::Source, cli::CliError};", "brdf uses crate::cli::CliError"),
        (["metrics", "norms"], "fn f() -> crate::brdf::table::Table { g() }", "metrics uses crate::brdf::table::Table"),
        (["source", "merl"], "use super::super::metrics::norms;", "source uses super::super::metrics::norms"),
        (["source", "merl"], "use brdfc::table;", "source uses brdfc::table"),
        (["report", "table"], "pub use crate::build::{self, cache::{Key, Entry}};", "report uses crate::build::self"),
        (["report", "table"], "pub use crate::build::{cache::{Key, Entry}};", "report uses crate::build::cache::Entry"),
        (["brdf", "haar"], "use std::{fmt, fs::File};", "the stage brdf uses std::fs::File"),
        (["brdf", "haar"], "let t = std::time::Instant::now();", "the stage brdf uses std::time::Instant::now"),
        (["metrics", "norms"], "#[derive(clap::Args)]", "the stage metrics uses clap::Args"),
        (["textures", "x"], "", "[\"textures\", \"x\"] is in no layer: add it to MAY_USE"),
    ] {
        let found = complaints(&modules, text);
        assert!(found.contains(&expected.to_owned()), "{text}: {found:?}");
    }
    for (modules, text) in [
        (["brdf", "haar"], "use super::table::Table; use crate::{metrics::norms, source::Source};"),
        (["brdf", "haar"], "// use crate::cli;\nlet s = \"crate::cli \\\" crate::build\"; let c = '\"'; f::<'a>();"),
        (
            ["source", "open"],
            "use std::fs::File; use brdfc_formats::FormatError; mod tests { use super::super::Tally; }",
        ),
        (["cli", "build"], "use crate::report::table; use crate::build::run; use clap::Args; use std::time::Instant;"),
    ] {
        assert_eq!(complaints(&modules, text), [""; 0], "{text}");
    }
}
