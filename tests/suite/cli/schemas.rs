//! The schemas of the reports of `--json`. `tests/suite/cli/report_keys.txt` lists their keys with their types, so that
//! none changes unseen; `./scripts/bless` writes it again. A type that several reports have alike is listed once. If they differ, the
//! name of the report precedes that of the type.

use crate::common::cli::Folder;
use brdfc_testing::schema::{check, complaint};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The reports for which the program has a schema.
fn names(folder: &Folder) -> Vec<String> {
    let help = folder.run(&["schema", "--help"]).succeeded().stdout;
    let values = help.lines().filter_map(|line| line.trim_start().strip_prefix("- ")?.split_once(':'));
    let names: Vec<String> = values.map(|(name, _)| name.to_owned()).collect();
    assert!(names.len() > 10, "{names:?}");
    names
}

fn schema(name: &str) -> Value {
    Folder::new().run(&["schema", name]).succeeded().json()
}

#[track_caller]
pub fn conforms(name: &str, report: &Value) {
    let complaint = complaint(&schema(name), report);
    assert!(complaint.is_none(), "{name}: {}", complaint.unwrap_or_default());
}

/// A type in one line, such as `array of Level or null`.
fn shape(schema: &Value) -> String {
    if let Some(name) = schema["$ref"].as_str() {
        return name.rsplit('/').next().unwrap_or(name).to_owned();
    }
    let several = |values: &Value, text: &dyn Fn(&Value) -> String| -> Option<String> {
        Some(values.as_array()?.iter().map(text).collect::<Vec<_>>().join(" or "))
    };
    let plain = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let kinds = several(&schema["type"], &plain).unwrap_or_else(|| plain(&schema["type"]));
    let items = ["items", "additionalProperties"].iter().find(|key| schema[**key].is_object());
    if let Some(options) = several(&schema["oneOf"], &shape).or_else(|| several(&schema["anyOf"], &shape)) {
        options
    } else if let Some(values) = several(&schema["enum"], &Value::to_string) {
        values
    } else if !schema["const"].is_null() {
        schema["const"].to_string()
    } else if let Some(first) = several(&schema["prefixItems"], &shape) {
        format!("{kinds} of {first}")
    } else if let Some(key) = items {
        format!("{kinds} of {}", shape(&schema[*key]))
    } else {
        kinds
    }
}

/// Adds a line for each key of an object, and of each alternative of one.
fn add_keys(name: &str, schema: &Value, lines: &mut BTreeSet<String>) {
    let properties = schema["properties"].as_object();
    for (key, value) in properties.into_iter().flatten() {
        let is_required = schema["required"].as_array().is_some_and(|keys| keys.contains(&json!(key)));
        lines.insert(format!("{name}.{key}{}: {}", if is_required { "" } else { "?" }, shape(value)));
        add_keys(&format!("{name}.{key}"), value, lines);
        add_keys(&format!("{name}.{key}"), &value["items"], lines);
    }
    let alternatives = ["oneOf", "anyOf", "allOf"].iter().filter_map(|key| schema[*key].as_array());
    alternatives.flatten().for_each(|alternative| add_keys(name, alternative, lines));
}

#[test]
fn keys_of_reports_are_those_on_record() {
    if !cfg!(feature = "render") {
        println!("skipped: schemas of what draws: needs --features render");
        return;
    }
    let mut lines = BTreeSet::new();
    // For each type, the reports by the lines that it has in them.
    let mut types: BTreeMap<String, BTreeMap<BTreeSet<String>, Vec<String>>> = BTreeMap::new();
    for name in names(&Folder::new()) {
        let schema = schema(&name);
        add_keys(&name, &schema, &mut lines);
        for (definition, schema) in schema["$defs"].as_object().into_iter().flatten() {
            let mut own = BTreeSet::new();
            if !schema["properties"].is_object() {
                own.insert(format!("{definition}: {}", shape(schema)));
            }
            add_keys(definition, schema, &mut own);
            types.entry(definition.clone()).or_default().entry(own).or_default().push(name.clone());
        }
    }
    for versions in types.into_values() {
        let is_one = versions.len() == 1;
        for (own, reports) in versions {
            let prefix = if is_one { String::new() } else { format!("{}/", reports.join(",")) };
            lines.extend(own.iter().map(|line| format!("{prefix}{line}")));
        }
    }
    let found: String = lines.iter().map(|line| format!("{line}\n")).collect();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/cli/report_keys.txt");
    if std::env::var_os("BRDFC_BLESS").is_some() {
        std::fs::write(&file, &found).unwrap();
    }
    let recorded = std::fs::read_to_string(&file).unwrap_or_default();
    let changed: Vec<&str> = found.lines().filter(|line| !recorded.lines().any(|other| other == *line)).collect();
    assert!(recorded == found, "report_keys.txt is old: ./scripts/bless keys_of_reports; new or changed: {changed:#?}");
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
