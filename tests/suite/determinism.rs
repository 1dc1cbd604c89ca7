//! The same input, options and version give the same bytes: at any number of threads, on any run, in any folder.

use crate::common::cli::{Folder, inputs};
use std::collections::BTreeMap;
use std::path::Path;

/// One material for every kind of source and target.
const SCENE: &str = "\
[scene]
name = 'all kinds'
[defaults]
grid = 8
[materials.table]
source = 'table.binary'
max_error = 0.05
[materials.round]
source = 'round.brdf'
max_bytes = 6000
[materials.brushed]
source = 'brushed.csv'
grid = 4
max_error = 0.1
bits = 12
trust_fit = true
[materials.rgl]
source = 'material.bsdf'
ratio = 8
[materials.half]
source = 'table.binary'
parameterisation = 'tangent-pole'
smooth = true
[materials.model]
source = 'synth:ward?kd=0.2,0.1,0.1&ay=0.5'
max_bytes = 9000
[[uses]]
material = 'table'
[[uses]]
material = 'round'
[[uses]]
material = 'brushed'
[[uses]]
material = 'rgl'
[[uses]]
material = 'half'
[[uses]]
material = 'model'
nearest = 30
";

fn scene() -> Folder {
    let folder = Folder::new();
    inputs(&folder);
    folder.write("scene.toml", SCENE);
    folder
}

fn build(folder: &Folder, out: &str, more: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let ran = folder.run(&[&["build", "scene.toml", "--quiet", "--out", out][..], more].concat()).succeeded();
    assert_eq!(ran.stderr, "");
    folder.products(out)
}

fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in a {
        assert!(*bytes == b[name], "{name} differs");
    }
}

#[test]
fn builds_do_not_depend_on_threads_runs_or_folders() {
    let (here, there) = (scene(), scene());
    let first = build(&here, "one", &["--jobs", "1"]);
    assert_eq!(first.len(), 13, "six packs, six lists, a report: {:?}", first.keys());
    for (out, more) in
        [("two", &["--jobs", "2"][..]), ("eight", &["--jobs", "8"]), ("again", &["--jobs", "8", "--no-cache"])]
    {
        assert_same(&first, &build(&here, out, more));
    }
    assert_same(&first, &build(&there, "deeper/down", &[]));
    for (name, bytes) in &first {
        let text = String::from_utf8_lossy(bytes);
        for path in [here.path(), &std::env::temp_dir(), Path::new("scene.toml")] {
            assert!(!text.contains(path.to_str().unwrap()), "{name} holds a path");
        }
        assert!(!text.contains("seconds"), "{name} holds a time");
    }
}

/// A tiny table, an anisotropic model, and an environment.
#[test]
fn maps_do_not_depend_on_threads_or_folders() {
    const LIT: &str = "[scene]\nenvironment = 'sky.hdr'\n[defaults]\ngrid = 2\n[materials.table]\nsource = 'table.binary'\n\
        [materials.model]\nsource = 'synth:ward?ay=0.5'\n[[uses]]\nmaterial = 'table'\n\
        maps = ['lobes', 'bandwidth', 'samples']\n[[uses]]\nmaterial = 'model'\nmaps = ['lobes', 'bandwidth', 'samples']\n";
    let scene = || {
        let folder = Folder::new();
        inputs(&folder);
        let colour = |x: u32, y: u32| image::Rgb([(x * x % 7) as f32, y as f32, 1.0]);
        let sky = image::DynamicImage::ImageRgb32F(image::Rgb32FImage::from_fn(64, 32, colour));
        sky.save(folder.path().join("sky.hdr")).unwrap();
        folder.write("scene.toml", LIT);
        folder
    };
    let (here, there) = (scene(), scene());
    let first = build(&here, "one", &["--jobs", "1"]);
    assert_eq!(first.len(), 13, "two packs, two lobes, six maps, two lists, a report: {:?}", first.keys());
    assert_same(&first, &build(&here, "eight", &["--jobs", "8"]));
    assert_same(&first, &build(&there, "deeper/down", &["--jobs", "3"]));
    for (name, bytes) in first.iter().filter(|(name, _)| name.ends_with(".json")) {
        let text = String::from_utf8_lossy(bytes);
        assert!(!text.contains(here.path().to_str().unwrap()) && !text.contains("seconds"), "{name}");
    }
}

#[test]
fn the_cache_keeps_bytes_and_notices_every_change() {
    let folder = scene();
    let cached = |name: &str, more: &[&str]| {
        let ran = folder.run(&[&["build", "scene.toml", "--json", "--out", "out"][..], more].concat()).succeeded();
        let report = ran.json();
        let materials = report["materials"].as_array().unwrap();
        let entry = materials.iter().find(|m| m["material"] == name).unwrap();
        let others = materials.iter().filter(|m| m["material"] != name).all(|m| m["cached"] == true);
        (entry["cached"].as_bool().unwrap(), others)
    };
    assert_eq!(cached("table", &[]), (false, false));
    let first = folder.products("out");
    assert_eq!(cached("table", &[]), (true, true), "nothing changed");
    assert_same(&first, &folder.products("out"));
    let words = folder.run(&["build", "scene.toml", "--out", "out"]).succeeded().stdout;
    assert_eq!(words.matches("cached").count(), 6, "{words}");
    assert_eq!(cached("table", &["--no-cache"]), (false, false));
    assert_same(&first, &folder.products("out"));

    folder.write("out/table.brdf.ktx2", b"broken");
    assert_eq!(cached("table", &[]), (true, true), "a broken pack is put in place again");
    assert_same(&first, &folder.products("out"));
    let retained = blake3::hash(&first["table.brdf.ktx2"]).to_hex();
    folder.write("out/table.brdf.ktx2", b"broken");
    folder.write(&format!("out/.brdfc-cache/objects/{retained}"), b"broken");
    assert_eq!(cached("table", &[]), (false, true), "without a whole one it is made again");
    for (name, bytes) in folder.files("out/.brdfc-cache/entries") {
        let mut flipped = bytes;
        let middle = flipped.len() / 2;
        flipped[middle] ^= 4;
        folder.write(&format!("out/.brdfc-cache/entries/{name}"), flipped);
    }
    assert_eq!(cached("table", &[]), (false, false), "nothing that an entry says is believed that was changed");
    std::fs::remove_file(folder.path().join("out/table.json")).unwrap();
    assert_eq!(cached("table", &[]), (true, true), "the list alone is cheap to write again");
    assert_same(&first, &folder.products("out"));

    folder.write("scene.toml", SCENE.replace("max_bytes = 6000", "max_bytes = 5000"));
    assert_eq!(cached("round", &[]), (false, true), "an option changed");
    let text = folder.text("round.brdf");
    let last = text.trim_end().len();
    folder.write("round.brdf", &text[..text[..last].rfind('\n').unwrap() + 1]);
    assert_eq!(cached("round", &[]), (false, true), "the source changed");
    assert!(folder.products("out")["round.brdf.ktx2"] != first["round.brdf.ktx2"]);
}

#[test]
fn encoding_does_not_depend_on_threads() {
    let folder = Folder::new();
    let targets = [&["--max-error", "0.1"][..], &["--max-bytes", "5000"], &["--ratio", "4", "--smooth"]];
    for (input, target) in inputs(&folder).into_iter().zip(targets.into_iter().cycle()) {
        let run = |jobs: &str| {
            let arguments = [&["encode", input, "--grid", "4", "-o", "pack.ktx2", "--json", "--jobs", jobs], target];
            let mut report = folder.run(&arguments.concat()).succeeded().json();
            assert!(report.as_object_mut().unwrap().remove("stages").is_some());
            (folder.read("pack.ktx2"), report)
        };
        let first = run("1");
        for jobs in ["2", "8"] {
            assert!(run(jobs) == first, "{input} {target:?} --jobs {jobs}");
        }
    }
}

#[test]
fn values_and_comparisons_do_not_depend_on_threads() {
    let folder = Folder::new();
    let [table, scan, ..] = inputs(&folder);
    for arguments in [&["compare", table, scan, "--directions", "3000", "--json"][..], &["info", scan, "--json"]] {
        let run = |jobs: &str| folder.run(&[arguments, &["--jobs", jobs]].concat()).succeeded().stdout;
        let first = run("1");
        assert!(["2", "8", "1"].into_iter().all(|jobs| run(jobs) == first), "{arguments:?}");
    }
}

#[test]
fn simulated_files_depend_on_the_seed_alone() {
    let folder = Folder::new();
    let file = |name: &str, seed: &str| {
        let more = ["--noise", "0.1", "--gaps", "0.2", "--duplicates", "0.1", "--rows", "200", "--seed", seed];
        folder.run(&[&["synth", "ggx", "-o", name][..], &more].concat()).succeeded();
        folder.read(name)
    };
    for [first, second, third] in [["a.brdf", "b.brdf", "c.brdf"], ["a.csv", "b.csv", "c.csv"]] {
        assert!(file(first, "1") == file(second, "1"));
        assert!(file(first, "1") != file(third, "2"));
    }
}
