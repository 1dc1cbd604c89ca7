//! The schemas of the reports of `--json`. `./scripts/bless` writes them to `schemas/` again.

use crate::common::cli::Folder;
use brdfc_testing::schema::{check, complaint};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The reports for which the program has a schema.
fn names(folder: &Folder) -> Vec<String> {
    let help = folder.run(&["schema", "--help"]).succeeded().stdout;
    let values = help.lines().filter_map(|line| line.trim_start().strip_prefix("- ")?.split_once(':'));
    let names: Vec<String> = values.map(|(name, _)| name.to_owned()).collect();
    assert!(names.len() > 10, "{names:?}");
    names
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas").join(format!("{name}.json"))
}

fn schema(name: &str) -> Value {
    let text = std::fs::read_to_string(file(name)).unwrap_or_else(|error| panic!("schemas/{name}.json: {error}"));
    serde_json::from_str(&text).unwrap()
}

#[track_caller]
pub fn conforms(name: &str, report: &Value) {
    let complaint = complaint(&schema(name), report);
    assert!(complaint.is_none(), "{name}: {}", complaint.unwrap_or_default());
}

#[test]
fn schemas_in_the_repository_are_those_of_the_program() {
    if !cfg!(feature = "render") {
        println!("skipped: schemas of what draws: needs --features render");
        return;
    }
    let folder = Folder::new();
    let names = names(&folder);
    for name in &names {
        let printed = folder.run(&["schema", name]).succeeded().stdout;
        if std::env::var_os("BRDFC_BLESS").is_some() {
            std::fs::create_dir_all(file(name).parent().unwrap()).unwrap();
            std::fs::write(file(name), &printed).unwrap();
        }
        let retained = std::fs::read_to_string(file(name)).unwrap_or_default();
        assert!(retained == printed, "schemas/{name}.json is old: ./scripts/bless");
    }
    let files = std::fs::read_dir(file("x").parent().unwrap()).unwrap().count();
    assert_eq!(files, names.len(), "nothing else lies in schemas/");
}

#[test]
fn schemas_follow_the_2020_12_draft() {
    for name in &names(&Folder::new()) {
        let schema = schema(name);
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
        check(&schema);
        assert!(schema["required"].as_array().unwrap().contains(&json!("version")), "{name}");
    }
}

#[test]
fn schemas_refuse_reports_that_are_wrong() {
    let report = Folder::new().run(&["info", "synth:lewis", "--json"]).succeeded().json();
    conforms("info", &report);
    for (key, value) in [("version", json!("1")), ("kind", json!("merly")), ("surprise", json!(1))] {
        let mut wrong = report.clone();
        wrong[key] = value;
        assert!(complaint(&schema("info"), &wrong).is_some(), "{key}");
    }
    let mut short = report.clone();
    short.as_object_mut().unwrap().remove("grey");
    assert!(complaint(&schema("info"), &short).is_some());
}
