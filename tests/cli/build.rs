//! `brdfc build`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};

const SCENE: &str = "\
[scene]
name = 'two'
[defaults]
grid = 4
[materials.model]
source = 'synth:ward?kd=0.2,0.1,0.1'
ratio = 2
[materials.table]
source = 'data/table.binary'
[materials.spare]
source = 'not-there.binary'
[[uses]]
object = 'wall'
material = 'model'
nearest = 30
[[uses]]
material = 'table'
";

fn folder() -> Folder {
    let folder = Folder::new();
    inputs(&folder);
    folder.write("data/table.binary", folder.read("table.binary"));
    folder.write("scene.toml", SCENE);
    folder
}

#[test]
fn packs_lists_and_the_report_are_written() {
    let folder = folder();
    let ran = folder.run(&["build", "scene.toml", "--json"]).succeeded();
    let report = ran.json();
    conforms("build", &report);
    assert_eq!((&report["scene"], &report["skipped"]), (&"two".into(), &vec!["spare"].into()));
    let names: Vec<_> = folder.products("packs").into_keys().collect();
    assert_eq!(names, ["model.brdf.ktx2", "model.json", "report.json", "table.brdf.ktx2", "table.json"]);

    let lasting: serde_json::Value = serde_json::from_str(&folder.text("packs/report.json")).unwrap();
    conforms("build", &lasting);
    for (kept, printed) in lasting["materials"].as_array().unwrap().iter().zip(report["materials"].as_array().unwrap())
    {
        assert_eq!(kept["report"], printed["report"]);
        assert!(printed["cached"] == false && printed["stages"].as_array().is_some_and(|s| s.len() >= 9), "{printed}");
        assert!(kept.get("cached").is_none() && kept.get("stages").is_none());
        let name = kept["material"].as_str().unwrap();
        let list: serde_json::Value = serde_json::from_str(&folder.text(&format!("packs/{name}.json"))).unwrap();
        conforms("material", &list);
        assert_eq!(list["report"], kept["report"]);
        let pack = format!("packs/{}", list["parts"]["brdf"].as_str().unwrap());
        assert_eq!(kept["report"]["bytes_on_disk"], folder.read(&pack).len());
        let info = folder.run(&["info", &pack, "--json"]).succeeded().json();
        assert_eq!(info["slices_kept"], kept["report"]["slices_kept"]);
    }
    // At distance 30 a grid of 2 levels loses log2(4.5) levels: all that fit.
    assert_eq!(report["materials"][0]["report"]["stored_levels"], 0);
    assert_eq!(report["materials"][1]["report"]["stored_levels"], 2);
}

#[test]
fn the_table_goes_to_stdout_and_progress_to_stderr() {
    let folder = folder();
    let ran = folder.run(&["build", "scene.toml"]).succeeded();
    let first: Vec<&str> = ran.stdout.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    assert_eq!(first, ["material", "model", "table"]);
    assert!(ran.stderr.contains("1 of 2: ") && ran.stderr.contains("2 of 2: "), "{}", ran.stderr);
    assert!(ran.stderr.contains("not used by the scene, not opened: spare"), "{}", ran.stderr);
    assert_eq!(folder.run(&["build", "scene.toml", "--quiet", "--no-cache"]).succeeded().stderr, "");
}

#[test]
fn a_dry_run_writes_nothing() {
    let folder = folder();
    let before = folder.files(".");
    let ran = folder.run(&["build", "scene.toml", "--dry-run"]).succeeded();
    for words in
        ["2:1", "0 of 2", "4:1", "2 of 2", "data/table.binary", "packs/model.brdf.ktx2", "not used by the scene: spare"]
    {
        assert!(ran.stdout.contains(words), "{words}: {}", ran.stdout);
    }
    let report = folder.run(&["build", "scene.toml", "--dry-run", "--json"]).succeeded().json();
    conforms("build", &report);
    assert_eq!(report["materials"].as_array().unwrap().len(), 2);
    assert!(folder.files(".") == before, "{:?}", folder.files(".").keys());
    folder.write("scene.toml", SCENE.replace("ratio = 2", "ratio = 0"));
    assert_eq!(folder.run(&["build", "scene.toml", "--dry-run"]).code, 3);
}

#[test]
fn a_failed_material_does_not_stop_the_others() {
    let folder = folder();
    for (change, code, words) in [
        (["data/table.binary", "data/gone.binary"], 4, "table: data/gone.binary: cannot read: "),
        (["data/table.binary", "scene.toml"], 3, "table: scene.toml: file name: found extension .toml"),
        (["data/table.binary", "synth:lewisss"], 3, "did you mean `lewis`?"),
        (["data/table.binary'", "data/table.binary'\nmax_error = 1e-9"], 1, "table: error budget: found "),
    ] {
        let out = folder.path().join("packs");
        let _ = std::fs::remove_dir_all(out);
        folder.write("scene.toml", SCENE.replace(change[0], change[1]));
        let ran = folder.run(&["build", "scene.toml", "--json"]);
        assert_eq!(ran.code, code, "{}", ran.stderr);
        assert!(ran.stderr.contains(words) && ran.stderr.contains("1 of 2 materials failed"), "{}", ran.stderr);
        let report = ran.json();
        conforms("build", &report);
        assert!(report["materials"][1]["error"].is_string() && report["materials"][1].get("pack").is_none());
        let names: Vec<_> = folder.products("packs").into_keys().collect();
        assert_eq!(names, ["model.brdf.ktx2", "model.json", "report.json"]);
        folder.run(&["info", "packs/model.brdf.ktx2"]).succeeded();
    }
}

#[test]
fn a_material_that_is_only_spare_needs_no_file() {
    let folder = Folder::new();
    folder.write("scene.toml", "[materials.spare]\nsource = 'gone.binary'\n");
    let ran = folder.run(&["build", "scene.toml"]).succeeded();
    assert!(ran.stderr.contains("not opened: spare"), "{}", ran.stderr);
    assert_eq!(folder.products("packs").into_keys().collect::<Vec<_>>(), ["report.json"]);
}

#[test]
fn the_demo_scene_is_planned() {
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/demo/scene.toml");
    let report = Folder::new().run(&["build", demo, "--dry-run", "--json"]).succeeded().json();
    let names: Vec<_> = report["materials"].as_array().unwrap().iter().map(|m| m["material"].clone()).collect();
    assert_eq!(names, ["blue_paint", "brushed_metal", "red_plastic", "satin"]);
}
