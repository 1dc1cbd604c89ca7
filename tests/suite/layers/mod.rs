//! The layers: which crate may use which, that no two files of a crate use one another, and what stages keep away from.
//! `docs/ARCHITECTURE.md` draws them.

mod circles;
pub mod code;

use circles::{Crate, circles};
use code::{code_of, imports_and_paths, rust_files};
use std::collections::BTreeMap;
use std::path::Path;

/// Every crate of the workspace, lowest first, with what it may use. A new crate needs a line here.
const MAY_USE: &[(&str, &[&str])] = &[
    ("brdfc-formats", &[]),
    ("brdfc-source", &["brdfc-formats"]),
    ("brdfc-metrics", &["brdfc-formats", "brdfc-source"]),
    ("brdfc-bandwidth", BELOW_CODECS),
    ("brdfc-flat-btf", BELOW_CODECS),
    ("brdfc-importance", BELOW_CODECS),
    ("brdfc-wavelet", BELOW_CODECS),
    ("brdfc-render", BELOW_RENDER),
    ("brdfc-gpu", &["brdfc-formats", "brdfc-source", "brdfc-metrics", "brdfc-render"]),
    ("brdfc-jobs", BELOW_JOBS),
    ("brdfc-studies", BELOW_STUDIES),
    ("brdfc", BELOW_PROGRAM),
    // Beside the layers: what tests share, and the benchmarks.
    ("brdfc-testing", &["brdfc-formats", "brdfc-source"]),
    ("brdfc-benchmarks", &[]),
];
const BELOW_PROGRAM: &[&str] = &[
    "brdfc-formats",
    "brdfc-source",
    "brdfc-metrics",
    "brdfc-bandwidth",
    "brdfc-flat-btf",
    "brdfc-importance",
    "brdfc-wavelet",
    "brdfc-render",
    "brdfc-gpu",
    "brdfc-jobs",
    "brdfc-studies",
];
const BELOW_STUDIES: &[&str] = BELOW_PROGRAM.split_at(10).0;
const BELOW_JOBS: &[&str] = BELOW_PROGRAM.split_at(9).0;
const BELOW_RENDER: &[&str] = BELOW_PROGRAM.split_at(7).0;
const BELOW_CODECS: &[&str] = BELOW_PROGRAM.split_at(3).0;

/// Who may use the graphics driver only where the feature `render` asks for it.
const GPU_BY_FEATURE: [&str; 3] = ["brdfc-jobs", "brdfc-studies", "brdfc"];

/// Crates of stages: typed input to typed output.
const STAGES: [&str; 6] =
    ["brdfc-source", "brdfc-metrics", "brdfc-bandwidth", "brdfc-flat-btf", "brdfc-importance", "brdfc-wavelet"];
/// What a stage has no need of.
const IMPURE: [&str; 7] = ["std::fs", "std::env", "std::time", "std::process", "std::net", "clap", "ctrlc"];
/// Files of those crates that may: the readers of measured files, and options that can be flags of a command line.
const MAY_TOUCH: &[(&str, &str, &str)] = &[
    ("brdfc-source", "btf_stack.rs", "std::fs"),
    ("brdfc-source", "flat_btf.rs", "std::fs"),
    ("brdfc-source", "format.rs", "std::fs"),
    ("brdfc-source", "read.rs", "std::fs"),
    ("brdfc-wavelet", "options.rs", "clap"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folders of the workspace's crates, with their manifests.
fn members() -> Vec<(String, toml::Table)> {
    let read = |folder: &str| -> toml::Table {
        std::fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap().parse().unwrap()
    };
    let workspace = read(".");
    let members = workspace["workspace"]["members"].as_array().unwrap();
    let folders = members.iter().map(|member| member.as_str().unwrap().to_owned());
    folders.map(|folder| (folder.clone(), read(&folder))).collect()
}

fn name_of(manifest: &toml::Table) -> &str {
    manifest["package"]["name"].as_str().unwrap()
}

/// What breaks the rule of arrows in a crate's manifest. Dependencies of tests are free.
fn wrong_arrows(manifest: &toml::Table) -> Vec<String> {
    let name = name_of(manifest);
    let Some((_, allowed)) = MAY_USE.iter().find(|(member, _)| *member == name) else {
        return vec![format!("{name} is in no layer: add it to MAY_USE")];
    };
    let mut wrong = Vec::new();
    for section in ["dependencies", "build-dependencies"] {
        for (used, how) in manifest.get(section).and_then(toml::Value::as_table).into_iter().flatten() {
            if !used.starts_with("brdfc") {
                continue;
            }
            if !allowed.contains(&used.as_str()) {
                wrong.push(format!("{name} uses {used}"));
            }
            let optional = how.get("optional").and_then(toml::Value::as_bool) == Some(true);
            if used == "brdfc-gpu" && GPU_BY_FEATURE.contains(&name) && !optional {
                wrong.push(format!("{name} always uses {used}"));
            }
        }
    }
    for (feature, parts) in manifest.get("features").and_then(toml::Value::as_table).into_iter().flatten() {
        let gpu = parts.as_array().unwrap().iter().any(|part| part.as_str() == Some("dep:brdfc-gpu"));
        if gpu && feature != "render" {
            wrong.push(format!("{name} uses brdfc-gpu for the feature {feature}"));
        }
    }
    wrong
}

/// What a stage's code touches that it should not.
fn impurities(name: &str, file: &str, text: &str) -> Vec<String> {
    let (imports, paths) = imports_and_paths(&code_of(text));
    let named = imports.into_iter().map(|import| import.path).chain(paths).map(|path| path.join("::"));
    let mut wrong = Vec::new();
    for path in named {
        for impure in IMPURE {
            let touched = path == impure || path.starts_with(&format!("{impure}::"));
            // A feature has the name of the crate that it asks for.
            if touched && path.contains("::") && !MAY_TOUCH.contains(&(name, file, impure)) {
                wrong.push(format!("{name}/{file} uses {path}"));
            }
        }
    }
    wrong
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
    let wrong: Vec<String> = members.iter().flat_map(|(_, manifest)| wrong_arrows(manifest)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let gone = MAY_USE.iter().filter(|(name, _)| !members.iter().any(|(_, manifest)| name_of(manifest) == *name));
    assert_eq!(gone.count(), 0, "a line of MAY_USE for a crate that is gone");
    // The table itself: each crate uses only what stands above its own line.
    for (at, (name, allowed)) in MAY_USE.iter().enumerate() {
        let lower: Vec<&str> = MAY_USE[..at].iter().map(|(lower, _)| *lower).collect();
        assert!(allowed.iter().all(|used| lower.contains(used)), "{name}: {allowed:?}");
    }
}

#[test]
fn no_circles_between_files() {
    let mut wrong = BTreeMap::new();
    let mut files = 0;
    for (folder, _) in members() {
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

#[test]
fn stages_are_pure() {
    let mut wrong = Vec::new();
    for (folder, manifest) in members() {
        let name = name_of(&manifest);
        if STAGES.contains(&name) {
            for (file, text) in sources(&folder) {
                wrong.extend(impurities(name, &file, &text));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn wrong_arrows_are_seen() {
    for (manifest, expected) in [
        ("[package]\nname = 'brdfc-new'", &["brdfc-new is in no layer: add it to MAY_USE"][..]),
        (
            "package.name = 'brdfc-formats'\ndependencies.brdfc-source.workspace = true",
            &["brdfc-formats uses brdfc-source"],
        ),
        (
            "package.name = 'brdfc-wavelet'\ndependencies.brdfc-bandwidth.workspace = true",
            &["brdfc-wavelet uses brdfc-bandwidth"],
        ),
        (
            "package.name = 'brdfc-jobs'\ndependencies.brdfc-studies.workspace = true",
            &["brdfc-jobs uses brdfc-studies"],
        ),
        ("package.name = 'brdfc-jobs'\ndependencies.brdfc-gpu.workspace = true", &["brdfc-jobs always uses brdfc-gpu"]),
        (
            "package.name = 'brdfc'\nfeatures.default = ['dep:brdfc-gpu']",
            &["brdfc uses brdfc-gpu for the feature default"],
        ),
        ("package.name = 'brdfc-jobs'\ndependencies.brdfc-gpu = { workspace = true, optional = true }", &[]),
        ("package.name = 'brdfc-formats'\ndev-dependencies.brdfc-testing.workspace = true", &[]),
    ] {
        assert_eq!(wrong_arrows(&manifest.parse().unwrap()), expected, "{manifest}");
    }
}

#[test]
fn impure_stages_are_seen() {
    for (text, expected) in [
        ("use std::{fmt, fs::File};", &["brdfc-metrics/norms.rs uses std::fs::File"][..]),
        ("let t = std::time::Instant::now();", &["brdfc-metrics/norms.rs uses std::time::Instant::now"]),
        ("#[derive(clap::Args)]", &["brdfc-metrics/norms.rs uses clap::Args"]),
        ("use std::fmt; #[cfg(test)]\nmod tests { use std::fs::File; }", &[]),
        ("// std::fs::read\nlet s = \"std::env \\\" std::fs::read\"; let c = '\"'; f::<'a>();", &[]),
    ] {
        assert_eq!(impurities("brdfc-metrics", "norms.rs", text), expected, "{text}");
    }
    assert!(impurities("brdfc-source", "read.rs", "use std::fs::File;").is_empty());
}

/// The circles of a made-up crate.
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
        // By way of a third file, a module's name and a passed-on name.
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
        // A parent that lists and passes on; children that share what it defines.
        (&[("lib.rs", "mod a; pub use a::g; pub struct Recipe;"), ("a.rs", "pub fn g(_: crate::Recipe) {}")], &[]),
        (
            &[("lib.rs", "mod a; mod b; pub use a::A;"), ("a.rs", shared), ("b.rs", "use crate::A; use super::a::b;")],
            &[],
        ),
        // Tests may use what they like.
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
