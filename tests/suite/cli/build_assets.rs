//! `brdfc build` of RTI captures, BTFs and environments.

use super::pwt::stack;
use super::pwt_views::{btf, ring};
use super::schemas::conforms;
use crate::common::cli::Folder;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const MANIFEST: &str = r#"
[materials.white]
source = "synth:lambert"
codec = "table"
max_bytes = "4KiB"

[captures.icon]
source = "stack"
degree = 2

[btfs.cloth]
source = "tile"
degree = 2

[environments.sky]
source = "sky.hdr"
side = 16

[[uses]]
material = "white"
"#;

/// Files of a build of [`MANIFEST`].
const FILES: [&str; 6] =
    ["cloth.pwt.ktx2", "icon.pwt.ktx2", "report.json", "sky.environment.ktx2", "white.brdf.ktx2", "white.json"];

/// One asset of each kind.
fn folder() -> Folder {
    let folder = stack();
    btf(&folder, "tile", &ring(&[40.0]));
    let sky = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/sky.hdr");
    folder.write("sky.hdr", std::fs::read(sky).unwrap());
    folder.write("scene.toml", MANIFEST);
    folder
}

fn build(folder: &Folder, arguments: &[&str]) -> Value {
    let report = folder.run(&[&["build", "scene.toml", "--json"], arguments].concat()).succeeded().json();
    conforms("build", &report);
    report
}

/// Names of the assets of a report, with true for those from the store.
fn cached(report: &Value) -> BTreeMap<String, bool> {
    let entries = report["assets"].as_array().unwrap().iter();
    entries.map(|entry| (entry["asset"].as_str().unwrap().to_owned(), entry["cached"] == true)).collect()
}

fn of(names: [&str; 3], cached: [bool; 3]) -> BTreeMap<String, bool> {
    names.into_iter().map(str::to_owned).zip(cached).collect()
}

const NAMES: [&str; 3] = ["cloth", "icon", "sky"];

#[test]
fn assets_are_made_cached_checked_and_reported() {
    let folder = folder();
    let report = build(&folder, &[]);
    assert_eq!(folder.products("packs").into_keys().collect::<Vec<_>>(), FILES);
    assert_eq!(cached(&report), of(NAMES, [false; 3]));
    let entry = |name: &str| report["assets"].as_array().unwrap().iter().find(|entry| entry["asset"] == name).unwrap();
    assert_eq!((&entry("icon")["kind"], &entry("icon")["source"]), (&"rti-capture".into(), &"stack".into()));
    assert_eq!(entry("cloth")["report"]["images"], 7 * 13);
    // The packs are those of `brdfc pwt` and `brdfc environment`.
    folder.run(&["pwt", "stack", "-o", "icon.ktx2", "--degree", "2"]).succeeded();
    folder.run(&["pwt", "tile", "-o", "cloth.ktx2", "--view", "all", "--degree", "2"]).succeeded();
    folder.run(&["environment", "sky.hdr", "-o", "sky.ktx2", "--side", "16"]).succeeded();
    for (name, part) in [("icon", "pwt"), ("cloth", "pwt"), ("sky", "environment")] {
        let ours = folder.read(&format!("packs/{name}.{part}.ktx2"));
        assert!(ours == folder.read(&format!("{name}.ktx2")), "{name}");
        assert_eq!(entry(name)["report"]["bytes_on_disk"], ours.len());
    }
    folder.run(&["verify", "packs"]).succeeded();
    // The same bytes again, from the store and without it, on one thread.
    let before = folder.products("packs");
    assert_eq!(cached(&build(&folder, &[])), of(NAMES, [true; 3]));
    let mut alone = folder.command(&["build", "scene.toml", "--no-cache", "--json"]);
    let alone = alone.env("RAYON_NUM_THREADS", "1").output().unwrap();
    assert_eq!(cached(&serde_json::from_slice(&alone.stdout).unwrap()), of(NAMES, [false; 3]));
    assert!(before == folder.products("packs"));
    // A changed photograph concerns only its capture.
    let photographs = std::fs::read_dir(folder.path().join("stack")).unwrap().map(|entry| entry.unwrap().path());
    let mut photographs: Vec<_> = photographs.filter(|path| path.extension().is_some_and(|e| e == "png")).collect();
    photographs.sort();
    std::fs::copy(&photographs[1], &photographs[0]).unwrap();
    let changed = build(&folder, &[]);
    assert_eq!(cached(&changed), of(NAMES, [true, false, true]));
    // A page with a rendering of each, and the earlier build to compare with.
    let required = "[captures.icon.require]\nmax_bytes = 1000\n\n[btfs.cloth]";
    folder.write("scene.toml", MANIFEST.replace("[btfs.cloth]", required));
    assert_eq!(folder.run(&["build", "scene.toml"]).code, 1);
    std::fs::write(folder.path().join("before.json"), &before["report.json"]).unwrap();
    let ran = folder.run(&["report", "packs", "-o", "page.html", "--against", "before.json", "--json"]);
    conforms("report", &ran.json());
    assert_eq!(ran.json()["assets"].as_array().unwrap().len(), 3);
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    for name in NAMES {
        assert!(page.contains(&format!("alt=\"rendering of {name}\"")), "{name}");
    }
    let worse = &ran.json()["regressions"][0];
    assert_eq!((ran.code, &worse["material"], &worse["figure"]), (1, &"icon".into(), &"require.max_bytes".into()));
}

#[test]
fn a_folder_stands_for_all_assets_in_it() {
    let folder = folder();
    folder.run(&["synth", "lambert", "-o", "red.binary", "--dimensions", "8x8x8"]).succeeded();
    folder.write("notes.txt", "no asset");
    // A folder of other images is no BTF.
    folder.write("images/a.png", "no image");
    std::fs::remove_file(folder.path().join("scene.toml")).unwrap();
    let ran = folder.run(&["build", ".", "--out", "packs", "--json"]).succeeded();
    assert_eq!(cached(&ran.json()).into_keys().collect::<Vec<_>>(), ["sky", "stack", "tile"]);
    assert!(ran.stderr.contains("skipped: ./notes.txt"), "{}", ran.stderr);
    let names: Vec<_> = folder.products("packs").into_keys().collect();
    assert!(names.contains(&"red.brdf.ktx2".to_owned()) && names.contains(&"stack.pwt.ktx2".to_owned()), "{names:?}");
    // Options of materials would be ignored.
    let ran = folder.run(&["build", "stack", "--max-bytes", "4KiB"]);
    assert!(ran.code == 2 && ran.stderr.contains("apply to materials, and this build has none"), "{}", ran.stderr);
    // A capture by itself, as its folder and as its list.
    for input in ["stack", "stack/dirs.lp"] {
        let report = folder.run(&["build", input, "--out", "one", "--json"]).succeeded().json();
        assert_eq!(report["assets"].as_array().unwrap().len(), 1, "{report}");
    }
}

#[test]
fn assets_that_fail_do_not_stop_the_others() {
    let folder = folder();
    folder.write("broken/dirs.lp", "2\na.png 0 0 1\n");
    folder.write("images/a.png", "no image");
    for (change, code, words) in [
        (["\"stack\"", "\"broken\""], 3, "icon: broken/dirs.lp: "),
        (["\"stack\"", "\"gone\""], 4, "icon: gone: cannot read: "),
        (
            ["\"stack\"", "\"tile\""],
            3,
            "icon: tile: input: found a BTF, expected an RTI capture: a folder with a list of lights (.lp), the list, a .ptm or a \
             .rti, or list it under [btfs]",
        ),
        (["\"stack\"", "\"images\""], 3, "icon: images: "),
        (["degree = 2\n\n[btfs", "max_delta_e = 0.0001\n\n[btfs"], 1, "icon: max_delta_e: found a mean ΔE of "),
        (
            ["[btfs.cloth]", "[captures.icon.require]\nmax_bytes = 1000\n\n[btfs.cloth]"],
            1,
            "icon: require.max_bytes: found ",
        ),
    ] {
        let _ = std::fs::remove_dir_all(folder.path().join("packs"));
        folder.write("scene.toml", MANIFEST.replacen(change[0], change[1], 1));
        let ran = folder.run(&["build", "scene.toml", "--json"]);
        assert!(ran.code == code && ran.stderr.contains(words), "{change:?}: {} {}", ran.code, ran.stderr);
        assert!(ran.stderr.contains("1 of 4 assets "), "{}", ran.stderr);
        conforms("build", &ran.json());
        // Only an asset that cannot be made has no pack.
        let has_pack = folder.path().join("packs/icon.pwt.ktx2").exists();
        assert_eq!(has_pack, code == 1, "{change:?}");
        assert!(folder.path().join("packs/cloth.pwt.ktx2").exists());
    }
}

#[test]
fn wrong_tables_of_assets_are_named_with_their_lines() {
    let folder = Folder::new();
    for (table, words) in [
        ("[captures.a]", "line 1, captures.a: no source; expected source = \"...\", an RTI capture"),
        (
            "[btfs.a]\nsource = \"synth:button\"",
            "line 2, btfs.a.source: found \"synth:button\", expected an ordinary BTF",
        ),
        (
            "[captures.a]\nsource = \"a\"\ndegree = 9",
            "line 3, captures.a.degree: found 9, expected 0 to 5, or up to 35",
        ),
        ("[captures.a]\nsource = \"a\"\nloss = 1\nenergy = 0.5", "captures.a.loss: not allowed together with energy"),
        ("[captures.a]\nsource = \"a\"\nside = 8", "line 3, key in [captures.a]: found \"side\", expected "),
        ("[captures.a]\nsource = \"a\"\nterms = \"x\"", "line 3, manifest: unknown variant `x`"),
        (
            "[environments.a]\nsource = \"a.hdr\"\nside = 9",
            "line 3, environments.a.side: found 9, expected a power of two",
        ),
        ("[environments.a]\nsource = \"a.hdr\"\nrequire.max_delta_e = 1", "found \"max_delta_e\", expected max_bytes"),
        ("[captures.report]\nsource = \"a\"", "captures.report: found the name \"report\", expected another name"),
        (
            "[captures.a]\nsource = \"a\"\n[btfs.a]\nsource = \"b\"",
            "line 3, btfs.a: [captures.a] has this name, too; choose names that differ",
        ),
        ("[captures.a]\nsource = \"a\"\n[btfs.A]\nsource = \"b\"", "are one file on some systems"),
    ] {
        folder.write("scene.toml", table);
        let ran = folder.run(&["build", "scene.toml"]);
        assert!(ran.code == 3 && ran.stderr.contains(words), "{table}: {} {}", ran.code, ran.stderr);
        assert!(!folder.path().join("packs").exists());
    }
}

/// Work items of several machines give the files of one.
#[test]
fn assets_are_work_items() {
    let folder = folder();
    build(&folder, &["--out", "whole"]);
    let graph = folder.run(&["plan", "scene.toml", "--out", "packs", "--format", "json"]).succeeded().json();
    let jobs: Vec<_> = graph["jobs"].as_array().unwrap().iter().map(|job| job["name"].as_str().unwrap()).collect();
    assert_eq!(jobs, ["white.brdf", "cloth.pwt", "icon.pwt", "sky.environment"]);
    let inputs = graph["jobs"][2]["inputs"].as_array().unwrap();
    assert!(inputs.len() > 40 && inputs.contains(&"stack/dirs.lp".into()), "{inputs:?}");
    folder.run(&["build", "scene.toml", "--out", "packs", "--only", "icon.pwt", "--only", "white.brdf"]).succeeded();
    folder.run(&["build", "scene.toml", "--out", "other", "--shard", "2/2"]).succeeded();
    let report = build(&folder, &["--out", "packs", "--from", "other"]);
    // Every second item: `cloth` and `sky`.
    assert_eq!(cached(&report), of(NAMES, [true; 3]));
    assert!(folder.products("whole") == folder.products("packs"));
    // A build without the assets keeps them on request, and removes them otherwise.
    folder.run(&["build", "synth:lambert", "--out", "packs", "--keep"]).succeeded();
    assert!(folder.path().join("packs/icon.pwt.ktx2").exists());
    folder.run(&["build", "synth:lambert", "--out", "packs"]).succeeded();
    assert!(!folder.path().join("packs/icon.pwt.ktx2").exists());
}

#[test]
fn a_plan_lists_assets() {
    let folder = folder();
    let text = folder.run(&["build", "scene.toml", "--dry-run"]).succeeded().stdout;
    assert!(text.contains("RTI capture") && text.contains("packs/sky.environment.ktx2"), "{text}");
    build(&folder, &[]);
    let report = folder.run(&["build", "scene.toml", "--dry-run", "--json"]).succeeded().json();
    conforms("build", &report);
    assert_eq!(cached(&report), of(NAMES, [true; 3]));
}
