//! The layers: which crate may use which, that no two files of a crate use one another, and which code stages must not use.
//! `docs/ARCHITECTURE.md` draws them.

mod circles;
pub mod code;

use circles::{Crate, circles};
use code::{code_of, imports_and_paths, rust_files};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The layers, lowest first: folders of crates. A crate may use those of lower layers, and none of its own.
const LAYERS: [&str; 14] = [
    "formats",
    "crates/shaders",
    "crates/core",
    "crates/readers",
    "crates/metrics",
    "crates/codec",
    "crates/codecs",
    "crates/encode",
    "crates/source",
    "crates/render",
    "crates/gpu",
    "crates/jobs",
    "crates/terminal",
    ".",
];
/// Crates outside the layers, with the highest layer that they may use: shared test code, the translator of shaders, the runner of
/// shaders over queries, the studies.
const OUTSIDE_LAYERS: [(&str, &str); 4] = [
    ("crates/testing", "crates/core"),
    ("crates/translate", "crates/shaders"),
    ("crates/probe", "crates/gpu"),
    ("studies", "crates/terminal"),
];
/// Crates for measurements of the studies.
const OF_STUDIES: (&str, &str) = ("studies", "crates/probe");
/// Crates that are tests, and may use any other: benchmarks, fuzz targets, and tests that need unsafe code.
const TESTS: [&str; 3] = ["studies/benches", "tests/fuzz", "tests/vulkan"];
/// A pair that must stay independent although one is lower: shaders draw the contents of packs, whichever encoder made them.
const INDEPENDENT: (&str, &str) = ("crates/gpu", "crates/codecs");
/// The layer of many crates, one for each codec. They are stages.
const CODECS: &str = "crates/codecs";

/// Crates that may use the graphics driver only with the feature `render`.
const GPU_BY_FEATURE: [&str; 3] = ["crates/jobs", "crates/terminal", "."];

/// Our crates that the command line may name: it uses the library for everything else.
const OF_COMMAND_LINE: [&str; 2] = ["brdfc", "brdfc_terminal"];

/// Layers of stages: typed input to typed output.
const STAGES: [&str; 10] = [
    "formats",
    "crates/shaders",
    "crates/core",
    "crates/readers",
    "crates/metrics",
    "crates/codec",
    CODECS,
    "crates/encode",
    "crates/source",
    "crates/render",
];
/// Names that a stage must not use.
const IMPURE: [&str; 8] =
    ["std::fs", "std::env", "std::time::Instant", "std::time::SystemTime", "std::process", "std::net", "clap", "ctrlc"];
/// Exceptions in those crates: the readers of measured files, and options that can be flags of a command line.
const MAY_TOUCH: &[(&str, &str, &str)] = &[
    ("crates/codec", "options.rs", "clap"),
    ("crates/source", "btf_stack.rs", "std::fs"),
    ("crates/source", "flat_btf.rs", "std::fs"),
    ("crates/source", "format.rs", "std::fs"),
    ("crates/source", "rti_capture.rs", "std::fs"),
    ("crates/source", "photograph.rs", "std::fs"),
    ("crates/source", "read.rs", "std::fs"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn manifest(folder: &str) -> toml::Table {
    std::fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap().parse().unwrap()
}

/// The folders of the workspace's crates, with their manifests.
pub fn members() -> Vec<(String, toml::Table)> {
    let workspace = manifest(".");
    let members = workspace["workspace"]["members"].as_array().unwrap();
    let folders = members.iter().flat_map(|member| {
        let member = member.as_str().unwrap();
        let Some(parent) = member.strip_suffix("/*") else { return vec![member.to_owned()] };
        let entries = std::fs::read_dir(root().join(parent)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut folders: Vec<String> = names.map(|name| format!("{parent}/{name}")).collect();
        folders.sort();
        folders
    });
    folders.map(|folder| (folder.clone(), manifest(&folder))).collect()
}

/// Returns the layer of a crate's folder.
fn layer(folder: &str) -> Option<usize> {
    let in_layer = |layer: &str| folder == layer || (layer == CODECS && folder.starts_with(CODECS));
    LAYERS.iter().position(|layer| in_layer(layer))
}

fn may_use(folder: &str, used: &str) -> bool {
    if (folder, used) == OF_STUDIES {
        return true;
    }
    let Some(used_layer) = layer(used) else { return false };
    if (folder, LAYERS[used_layer]) == INDEPENDENT {
        return false;
    }
    match OUTSIDE_LAYERS.iter().find(|(outside, _)| *outside == folder) {
        Some((_, highest)) => Some(used_layer) <= layer(highest),
        None => layer(folder).is_some_and(|layer| used_layer < layer),
    }
}

/// Lists violations of the layers in the manifest of the crate in a folder. Dependencies of tests are unrestricted.
fn wrong_arrows(folder: &str, manifest: &toml::Table) -> Vec<String> {
    if TESTS.contains(&folder) {
        return Vec::new();
    }
    let folders = self::manifest(".")["workspace"]["dependencies"].as_table().unwrap().clone();
    let path_of = |how: &toml::Value| Some(how.get("path")?.as_str()?.to_owned());
    // With the path of the workspace, or with its own path.
    let folder_of = |name: &str, how: &toml::Value| match path_of(how) {
        Some(path) => Some(joined(folder, &path)),
        None => folders.get(name).and_then(path_of),
    };
    if layer(folder).is_none() && !OUTSIDE_LAYERS.iter().any(|(outside, _)| *outside == folder) {
        return vec![format!("{folder} is in no layer: add it to LAYERS")];
    }
    let mut wrong = Vec::new();
    for section in ["dependencies", "build-dependencies"] {
        for (used, how) in manifest.get(section).and_then(toml::Value::as_table).into_iter().flatten() {
            if !used.starts_with("brdfc") {
                continue;
            }
            if !folder_of(used, how).is_some_and(|used| may_use(folder, &used)) {
                wrong.push(format!("{folder} uses {used}"));
            }
            let optional = how.get("optional").and_then(toml::Value::as_bool) == Some(true);
            if used == "brdfc-gpu" && GPU_BY_FEATURE.contains(&folder) && !optional {
                wrong.push(format!("{folder} always uses {used}"));
            }
        }
    }
    for (feature, parts) in manifest.get("features").and_then(toml::Value::as_table).into_iter().flatten() {
        let gpu = parts.as_array().unwrap().iter().any(|part| part.as_str() == Some("dep:brdfc-gpu"));
        if gpu && feature != "render" {
            wrong.push(format!("{folder} uses brdfc-gpu for the feature {feature}"));
        }
    }
    wrong
}

/// The folder that `path`, seen from another folder, is.
fn joined(folder: &str, path: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').collect();
    for part in path.split('/') {
        if part == ".." {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    parts.join("/")
}

/// Lists the code of a stage that uses a forbidden name.
fn impurities(folder: &str, file: &str, text: &str) -> Vec<String> {
    let (imports, paths) = imports_and_paths(&code_of(text));
    let named = imports.into_iter().map(|import| import.path).chain(paths).map(|path| path.join("::"));
    let mut wrong = Vec::new();
    for path in named {
        for impure in IMPURE {
            let touched = path == impure || path.starts_with(&format!("{impure}::"));
            // A feature has the name of the crate that it enables.
            if touched && path.contains("::") && !MAY_TOUCH.contains(&(folder, file, impure)) {
                wrong.push(format!("{folder}/{file} uses {path}"));
            }
        }
    }
    wrong
}

/// Our crates, other than the library, that a file of the command line names.
fn other_ways_in(file: &str, text: &str) -> Vec<String> {
    let (imports, paths) = imports_and_paths(&code_of(text));
    let named = imports.into_iter().map(|import| import.path).chain(paths);
    let is_other = |path: &Vec<String>| path[0].starts_with("brdfc") && !OF_COMMAND_LINE.contains(&path[0].as_str());
    named.filter(is_other).map(|path| format!("src/{file} uses {}", path.join("::"))).collect()
}

/// The files below a crate's `src/`, with their texts.
fn sources(folder: &str) -> Vec<(String, String)> {
    let src = root().join(folder).join("src");
    let named = |file: &Path| {
        let relative = file.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
        (relative, std::fs::read_to_string(file).unwrap())
    };
    rust_files(&src).iter().map(|file| named(file)).collect()
}

#[test]
fn arrows_point_one_way() {
    let members = members();
    assert!(members.len() >= LAYERS.len() + OUTSIDE_LAYERS.len() + TESTS.len(), "{}", members.len());
    let wrong: Vec<String> = members.iter().flat_map(|(folder, manifest)| wrong_arrows(folder, manifest)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    for known in LAYERS.into_iter().chain(OUTSIDE_LAYERS.map(|(folder, _)| folder)).chain(TESTS) {
        assert!(members.iter().any(|(folder, _)| folder.starts_with(known)), "{known}: a layer that is gone");
    }
}

#[test]
fn no_circles_between_files() {
    let mut wrong = BTreeMap::new();
    let mut files = 0;
    for (folder, _) in members().into_iter().filter(|(folder, _)| !TESTS.contains(&folder.as_str())) {
        let this = Crate::new(&sources(&folder));
        files += this.files();
        let found = circles(&this.graph());
        if !found.is_empty() {
            wrong.insert(folder, found);
        }
    }
    assert!(files > 250, "{files} files");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Folders of our crates on which those in a folder depend, including themselves.
fn made_of(folder: &str) -> BTreeSet<String> {
    let folders = manifest(".")["workspace"]["dependencies"].as_table().unwrap().clone();
    let mut all = BTreeSet::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        if all.insert(folder.clone()) {
            let used = manifest(&folder)["dependencies"].as_table().unwrap().clone();
            let path = |name: &String| Some(folders.get(name)?.get("path")?.as_str()?.to_owned());
            open.extend(used.keys().filter_map(path));
        }
    }
    all
}

/// Starts of files of the jobs that the makers of packs use, and that decide no byte of a pack.
const BESIDES_PACKS: [&str; 10] = [
    "error.rs",
    "report/gate.rs",
    "scene/error.rs",
    "scene/gates.rs",
    "scene/memory.rs",
    "scene/place.rs",
    "scene/run.rs",
    "scene/uses.rs",
    "stage_clock.rs",
    "store/",
];

/// Packs in a store belong to the encoders that made them: the key hashes the sources of everything that affects a pack.
#[test]
fn keys_of_the_store_change_with_every_crate_that_encodes() {
    let script = std::fs::read_to_string(root().join("crates/jobs/build.rs")).unwrap();
    let list = script.split_once("SOURCES").unwrap().1.split_once("];").unwrap().0;
    let hashed: Vec<&str> = list.split('"').skip(1).step_by(2).collect();
    let crates: BTreeSet<String> =
        ["crates/encode", "crates/source", "crates/codecs/lobes", "crates/codecs/environment", "crates/codecs/pwt"]
            .into_iter()
            .flat_map(made_of)
            .collect();
    assert!(crates.len() >= 9, "{crates:?}");
    let is_hashed = |folder: &str| {
        let from_jobs = folder.strip_prefix("crates/").map_or(format!("../../{folder}"), |name| format!("../{name}"));
        hashed.iter().any(|place| format!("{from_jobs}/src").starts_with(place))
    };
    let missing: Vec<&String> = crates.iter().filter(|folder| !is_hashed(folder)).collect();
    assert!(missing.is_empty(), "{missing:?} decide packs, and crates/jobs/build.rs does not hash them");
    let places: Vec<&str> = hashed.iter().filter_map(|place| place.strip_prefix("src/")).collect();
    let is_hashed = |file: &str| {
        places.iter().any(|place| file.strip_prefix(place).is_some_and(|rest| rest.is_empty() || rest.starts_with('/')))
    };
    let graph = Crate::new(&sources("crates/jobs")).graph();
    let used: BTreeSet<&str> = graph
        .iter()
        .filter(|(file, _)| is_hashed(file))
        .flat_map(|(_, arrows)| arrows.keys())
        .map(String::as_str)
        .filter(|file| !is_hashed(file) && !BESIDES_PACKS.iter().any(|start| file.starts_with(start)))
        .collect();
    assert!(graph.keys().filter(|file| is_hashed(file)).count() > 20);
    assert!(used.is_empty(), "{used:?} are used by what makes packs, and crates/jobs/build.rs does not hash them");
}

#[test]
fn stages_are_pure() {
    let mut wrong = Vec::new();
    let mut files = 0;
    let is_stage = |folder: &str| layer(folder).is_some_and(|layer| STAGES.contains(&LAYERS[layer]));
    for (folder, _) in members().into_iter().filter(|(folder, _)| is_stage(folder)) {
        for (file, text) in sources(&folder) {
            files += 1;
            wrong.extend(impurities(&folder, &file, &text));
        }
    }
    assert!(files > 100, "{files} files");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_command_line_is_a_client_of_the_library() {
    let files: Vec<_> = sources(".").into_iter().filter(|(file, _)| file.starts_with("cli/")).collect();
    assert!(files.len() > 40, "{} files", files.len());
    let wrong: Vec<String> = files.iter().flat_map(|(file, text)| other_ways_in(file, text)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let features = &manifest(".")["features"];
    let parts = features["cli"].as_array().unwrap().iter().filter_map(toml::Value::as_str);
    let ours: Vec<&str> = parts.filter(|part| part.starts_with("dep:brdfc")).collect();
    assert_eq!(ours, ["dep:brdfc-terminal"], "what else of ours the program needs is the library's");
}

/// Manifests disable the test harness of these, so that they are not compiled twice: a test in them would never run.
#[test]
fn files_that_are_not_compiled_as_tests_have_none() {
    let bench = root().join("studies/src/bin/brdfc-bench");
    let mut texts: Vec<String> =
        rust_files(&bench).into_iter().map(|file| std::fs::read_to_string(file).unwrap()).collect();
    let is_off = |manifest: &toml::Table| {
        manifest.get("lib").and_then(|lib| lib.get("test")).and_then(toml::Value::as_bool) == Some(false)
    };
    for (folder, _) in members().into_iter().filter(|(_, manifest)| is_off(manifest)) {
        texts.extend(sources(&folder).into_iter().map(|(_, text)| text));
    }
    assert!(texts.len() > 100, "{} files", texts.len());
    assert!(texts.iter().all(|text| !text.contains("#[test]") && !text.contains("cfg(test)")));
}

#[test]
fn other_ways_in_are_seen() {
    for (text, expected) in [
        (
            "use brdfc_jobs::convert::{Target, convert};",
            &["brdfc_jobs::convert::Target", "brdfc_jobs::convert::convert"][..],
        ),
        ("pub(super) use brdfc_core as core;", &["brdfc_core"]),
        ("fn f() { schema_for!(brdfc_gpu::Gpu) }", &["brdfc_gpu::Gpu"]),
        ("use brdfc::{Build, convert::Target}; use brdfc_terminal::words; use clap::Args; use super::encode;", &[]),
        ("// brdfc_jobs::encode\nlet text = \"brdfc_jobs::encode\";", &[]),
    ] {
        let expected: Vec<String> = expected.iter().map(|path| format!("src/cli/new.rs uses {path}")).collect();
        assert_eq!(other_ways_in("cli/new.rs", text), expected, "{text}");
    }
}

#[test]
fn wrong_arrows_are_seen() {
    for (folder, manifest, expected) in [
        ("crates/new", "", &["crates/new is in no layer: add it to LAYERS"][..]),
        ("formats", "dependencies.brdfc-source.workspace = true", &["formats uses brdfc-source"]),
        (
            "crates/codecs/wavelet",
            "dependencies.brdfc-bandwidth.workspace = true",
            &["crates/codecs/wavelet uses brdfc-bandwidth"],
        ),
        ("crates/codecs/new", "dependencies.brdfc-jobs.workspace = true", &["crates/codecs/new uses brdfc-jobs"]),
        ("crates/codecs/new", "dependencies.brdfc-source.workspace = true", &["crates/codecs/new uses brdfc-source"]),
        ("crates/codecs/new", "dependencies.brdfc-metrics.workspace = true", &[]),
        ("crates/encode", "dependencies.brdfc-new.path = '../codecs/new'", &[]),
        ("crates/encode", "dependencies.brdfc-new = { path = '../source' }", &["crates/encode uses brdfc-new"]),
        ("crates/encode", "dependencies.brdfc-new.workspace = true", &["crates/encode uses brdfc-new"]),
        ("crates/gpu", "dependencies.brdfc-wavelet.workspace = true", &["crates/gpu uses brdfc-wavelet"]),
        ("crates/render", "dependencies.brdfc-wavelet.workspace = true", &[]),
        ("crates/testing", "dependencies.brdfc-metrics.workspace = true", &["crates/testing uses brdfc-metrics"]),
        ("crates/jobs", "dependencies.brdfc-terminal.workspace = true", &["crates/jobs uses brdfc-terminal"]),
        ("crates/jobs", "dependencies.brdfc-testing.workspace = true", &["crates/jobs uses brdfc-testing"]),
        ("crates/jobs", "dependencies.brdfc-gpu.workspace = true", &["crates/jobs always uses brdfc-gpu"]),
        (".", "features.default = ['dep:brdfc-gpu']", &[". uses brdfc-gpu for the feature default"]),
        ("crates/jobs", "dependencies.brdfc-gpu = { workspace = true, optional = true }", &[]),
        ("formats", "dev-dependencies.brdfc-testing.workspace = true", &[]),
    ] {
        assert_eq!(wrong_arrows(folder, &manifest.parse().unwrap()), expected, "{folder}: {manifest}");
    }
}

#[test]
fn impure_stages_are_seen() {
    for (text, expected) in [
        ("use std::{fmt, fs::File};", &["crates/metrics/norms.rs uses std::fs::File"][..]),
        ("let t = std::time::Instant::now();", &["crates/metrics/norms.rs uses std::time::Instant::now"]),
        ("#[derive(clap::Args)]", &["crates/metrics/norms.rs uses clap::Args"]),
        ("use std::fmt; #[cfg(test)]\nmod tests { use std::fs::File; }", &[]),
        ("// std::fs::read\nlet s = \"std::env \\\" std::fs::read\"; let c = '\"'; f::<'a>();", &[]),
    ] {
        assert_eq!(impurities("crates/metrics", "norms.rs", text), expected, "{text}");
    }
    assert!(impurities("crates/source", "read.rs", "use std::fs::File;").is_empty());
}

/// The cycles of a fictitious crate.
fn made_up(files: &[(&str, &str)]) -> Vec<String> {
    let files: Vec<(String, String)> = files.iter().map(|(f, t)| ((*f).to_owned(), (*t).to_owned())).collect();
    circles(&Crate::new(&files).graph())
}

#[test]
fn circles_are_seen() {
    let shared = "pub struct A; pub fn b() {}";
    for (files, expected) in [
        (
            &[
                ("lib.rs", "mod a; mod b;"),
                ("a.rs", "use super::b::{self, B}; pub struct A;"),
                ("b.rs", "pub struct B; fn f(_: crate::a::A) {}"),
            ][..],
            &["a.rs -> b.rs: B", "b.rs -> a.rs: A"][..],
        ),
        // Via a third file, a module's name and a re-exported name.
        (
            &[
                ("lib.rs", "mod a; mod b; mod c;"),
                ("a.rs", "use crate::b; fn f() { b::g() } pub struct A;"),
                ("b/mod.rs", "mod inner; pub use inner::g;"),
                ("b/inner.rs", "pub fn g() { crate::c::h() }"),
                ("c.rs", "use crate::a as first; pub fn h() -> first::A { todo!() }"),
            ],
            &["a.rs -> b/inner.rs: g", "b/inner.rs -> c.rs: h", "c.rs -> a.rs: A"],
        ),
        // A parent that uses a child that uses it.
        (
            &[("lib.rs", "mod a; pub struct Recipe; fn f() { a::g() }"), ("a.rs", "pub fn g(_: crate::Recipe) {}")],
            &["a.rs -> lib.rs: Recipe", "lib.rs -> a.rs: g"],
        ),
        // A parent that lists and re-exports; children that share its definitions.
        (&[("lib.rs", "mod a; pub use a::g; pub struct Recipe;"), ("a.rs", "pub fn g(_: crate::Recipe) {}")], &[]),
        (
            &[("lib.rs", "mod a; mod b; pub use a::A;"), ("a.rs", shared), ("b.rs", "use crate::A; use super::a::b;")],
            &[],
        ),
        // Tests may use anything.
        (
            &[
                ("lib.rs", "mod a; mod b;"),
                ("a.rs", "pub struct A; #[cfg(test)] mod tests { use crate::b::B; }"),
                ("b.rs", "use super::a::A; pub struct B;"),
            ],
            &[],
        ),
        (
            &[
                ("lib.rs", "pub mod a; #[cfg(test)]\nmod testing;"),
                ("a.rs", "use crate::testing::t; pub struct A;"),
                ("testing.rs", "use crate::a::A; pub fn t() {}"),
            ],
            &[],
        ),
    ] {
        assert_eq!(made_up(files), expected, "{files:?}");
    }
}
