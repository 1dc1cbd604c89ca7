//! Packages are complete: everything that a published crate compiles is in its own folder.

use crate::layers::code::rust_files;
use crate::layers::members;
use brdfc_testing::repository;
use std::path::{Component, Path, PathBuf};

const INCLUDES: [&str; 3] = ["include!(\"", "include_bytes!(\"", "include_str!(\""];

/// The path without `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => drop(normal.pop()),
            Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}

/// Files outside a crate's folder that one of its source files includes, tests aside.
fn outside(folder: &Path, file: &Path, text: &str) -> Vec<String> {
    let compiled = text.split("#[cfg(test)]").next().unwrap_or_default();
    let paths =
        INCLUDES.iter().flat_map(|include| compiled.split(include).skip(1)).filter_map(|rest| rest.split('"').next());
    let wrong = paths.filter(|path| !normal(&file.with_file_name(path)).starts_with(folder));
    wrong.map(|path| format!("{}: {path}", file.display())).collect()
}

#[test]
fn published_crates_include_their_own_files_alone() {
    let published =
        |manifest: &toml::Table| manifest["package"].get("publish").and_then(toml::Value::as_bool) != Some(false);
    let mut wrong = Vec::new();
    let mut crates = 0;
    for (folder, _) in members().into_iter().filter(|(_, manifest)| published(manifest)) {
        crates += 1;
        let folder = normal(&repository().join(folder));
        for file in rust_files(&folder.join("src")).into_iter().filter(|file| !file.ends_with("tests.rs")) {
            wrong.extend(outside(&folder, &normal(&file), &std::fs::read_to_string(&file).unwrap()));
        }
    }
    assert!(crates > 10, "{crates} crates");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn files_of_others_are_noticed() {
    let outside = |text: &str| outside(Path::new("/a/crate"), Path::new("/a/crate/src/view/script.rs"), text).len();
    assert_eq!(outside("include_str!(\"page/main.js\") include_str!(\"../../README.md\")"), 0);
    assert_eq!(outside("include_str!(\"../../../other/x.js\") include_bytes!(\"../../../y\")"), 2);
    assert_eq!(outside("#[cfg(test)] include_str!(\"../../../other/x.js\")"), 0);
}
