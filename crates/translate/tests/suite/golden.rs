//! Checks that translated shaders in the repository are naga's current output for the WGSL. `./scripts/bless` writes
//! them.

use brdfc_formats::PackKind;
use brdfc_jobs::view::PageShader;
use brdfc_shaders::Generated;
use brdfc_testing::golden::{blessing, tell};
use brdfc_testing::repository;
use brdfc_translate::{program, translate};
use serde::Serialize;
use std::collections::BTreeMap;

/// Compares a file of the repository with the data that it is made from.
fn check(file: &str, made: &impl Serialize) {
    let path = repository().join(file);
    let text = serde_json::to_string_pretty(made).unwrap() + "\n";
    if std::fs::read_to_string(&path).is_ok_and(|current| current == text) {
        return;
    }
    assert!(blessing(), "{file} differs from naga's output for the WGSL; run ./scripts/bless");
    std::fs::write(&path, text).unwrap();
    tell(&format!("{file}: written"));
}

#[test]
fn decoders_in_the_languages_of_engines() {
    let all: BTreeMap<&str, Generated> =
        PackKind::ALL.map(|decoder| (decoder.name(), translate(decoder).unwrap())).into_iter().collect();
    check(Generated::FILE, &all);
}

#[test]
fn shaders_of_pages() {
    let shaders = PageShader::all();
    let translated =
        shaders.iter().map(|shader| (&shader.name, program(&shader.wgsl, shader.vertex, shader.fragment).unwrap()));
    let all: BTreeMap<&String, _> = translated.collect();
    check(PageShader::FILE, &all);
}
