//! Builds that are stopped in the middle: by people, by the system, by each other.

use crate::common::cli::Folder;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const MATERIALS: usize = 200;

/// Materials that take a fraction of a second each.
fn scene(numbers: impl Iterator<Item = usize>) -> String {
    scene_of(numbers, "grid = 16\nmax_error = 0.01\nbits = 12")
}

/// Materials that take little more than their comparison: builds meet, and are killed, also where they place files.
fn cheap(numbers: impl Iterator<Item = usize>, bits: u32) -> String {
    scene_of(numbers, &format!("grid = 4\nratio = 4\nbits = {bits}"))
}

fn scene_of(numbers: impl Iterator<Item = usize>, keys: &str) -> String {
    numbers
        .map(|k| {
            format!(
                "[materials.m{k}]\nsource = 'synth:ward?kd=0.{k:03},0.2,0.1'\n{keys}\n\
                 [[uses]]\nmaterial = 'm{k}'\n"
            )
        })
        .collect()
}

fn started(folder: &Folder, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_brdfc"))
        .args(arguments)
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

#[cfg(unix)]
fn signal(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[test]
#[cfg(unix)]
fn an_interrupt_changes_nothing_and_loses_nothing() {
    let folder = Folder::new();
    folder.write("scene.toml", scene(0..3));
    folder.run(&["build", "scene.toml"]).succeeded();
    let before = folder.products("packs");

    folder.write("scene.toml", scene(3..MATERIALS));
    let mut child = started(&folder, &["build", "scene.toml", "--jobs", "2"]);
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    lines.read_line(&mut line).unwrap();
    assert!(line.starts_with(&format!("1 of {}: ", MATERIALS - 3)), "{line}");
    signal(&child, "-INT");
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    assert!(
        rest.contains("brdfc: interrupted; the output folder is unchanged") && !rest.contains("panicked"),
        "{rest}"
    );
    assert!(folder.products("packs") == before, "{:?}", folder.products("packs").keys());
    assert!(folder.files("packs").keys().all(|name| !name.contains(".tmp")), "{:?}", folder.files("packs").keys());

    // The first that were finished serve the next build.
    folder.write("scene.toml", scene([10, 100, 101, 11].into_iter()));
    let again = folder.run(&["build", "scene.toml", "--json"]).succeeded().json();
    let cached = again["materials"].as_array().unwrap().iter().filter(|m| m["cached"] == true).count();
    assert!(cached >= 1, "{cached} of the first four");
    assert!(folder.products("packs").keys().all(|name| !name.starts_with("m0.")), "m0 is not needed any more");
}

/// Number of times that processes are killed at random moments.
fn kills() -> u64 {
    std::env::var("BRDFC_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(10)
}

/// The hashes in a report are those of the files, and there are no other files.
#[track_caller]
fn agrees(products: &BTreeMap<String, Vec<u8>>, what: &str) {
    let report: serde_json::Value = serde_json::from_slice(&products["report.json"]).unwrap();
    let mut names = vec!["report.json".to_owned()];
    for material in report["materials"].as_array().unwrap() {
        names.push(format!("{}.json", material["material"].as_str().unwrap()));
        for file in material["files"].as_array().unwrap() {
            let name = file["file"].as_str().unwrap();
            assert_eq!(file["blake3"], blake3::hash(&products[name]).to_hex().to_string(), "{what}: {name}");
            names.push(name.to_owned());
        }
    }
    names.sort();
    assert!(products.keys().eq(&names), "{what}: {:?} {names:?}", products.keys());
}

#[test]
#[cfg(unix)]
fn killed_builds_leave_the_folder_whole() {
    let folder = Folder::new();
    let scenes = [cheap(0..4, 12), cheap(2..6, 8)];
    let mut whole = Vec::new();
    for (text, out) in scenes.iter().zip(["even", "odd"]) {
        folder.write("scene.toml", text);
        folder.run(&["build", "scene.toml", "--out", out]).succeeded();
        whole.push(folder.products(out));
    }
    folder.run(&["build", "scene.toml", "--out", "packs"]).succeeded();
    let mut standing = whole[1].clone();
    for number in 0..kills() {
        let next = (number % 2) as usize;
        folder.write("scene.toml", &scenes[next]);
        let mut child = started(&folder, &["build", "scene.toml", "--no-cache", "--quiet"]);
        // From before the first file to after the last.
        std::thread::sleep(Duration::from_micros(number * 7919 * 31 % 400_000));
        signal(&child, if number % 3 == 0 { "-INT" } else { "-KILL" });
        let _ = child.wait();
        let products = folder.products("packs");
        if !folder.path().join("packs/.brdfc-cache/commit/list").exists() {
            agrees(&products, &format!("kill {number}"));
            assert!(products == standing || products == whole[next], "kill {number}: one build or the other");
            standing = products;
        }
        // The next run succeeds as if nothing had happened.
        if number % 5 == 4 {
            folder.run(&["build", "scene.toml", "--quiet"]).succeeded();
            assert!(folder.products("packs") == whole[next], "after kill {number}");
            let left: Vec<_> = folder.files("packs").into_keys().filter(|name| name.contains(".tmp")).collect();
            assert!(left.is_empty(), "after kill {number}: {left:?}");
            standing = whole[next].clone();
        }
    }
}

/// Two of one name: one has files of views until it is complete.
const SURFACES: [[&str; 3]; 2] = [
    ["synth:button?resolution=16", "grid:2x4@50", "--reflectance=factors"],
    ["synth:folds?resolution=16", "grid:2x3@50", "--no-supercompression"],
];

/// A coarse flat BTF in a folder.
fn flatten<'a>([surface, views, option]: [&'a str; 3], out: &'a str) -> Vec<&'a str> {
    let coarse = ["--texels", "8", "--name", "a", "--quiet"];
    [&["flatten", surface, "--views", views, option, "--out", out][..], &coarse].concat()
}

#[test]
#[cfg(unix)]
fn killed_flattenings_leave_the_folder_whole() {
    let folder = Folder::new();
    let whole = [0, 1].map(|k| {
        let out = ["even", "odd"][k];
        folder.run(&flatten(SURFACES[k], out)).succeeded();
        folder.files(out)
    });
    assert!(whole[0].len() == 1 && whole[0].keys().eq(whole[1].keys()) && whole[0] != whole[1]);
    folder.run(&flatten(SURFACES[1], "asset")).succeeded();
    let mut standing = 1;
    for number in 0..kills() {
        let next = (number % 2) as usize;
        let mut child = started(&folder, &flatten(SURFACES[next], "asset"));
        // From before the first stage to after the last.
        std::thread::sleep(Duration::from_micros(number * 7919 * 31 % 700_000));
        if number % 4 == 3 {
            signal(&child, "-INT");
        } else {
            let _ = child.kill();
        }
        let _ = child.wait();
        let products = without_unfinished(folder.files("asset"));
        standing = if products == whole[next] { next } else { standing };
        assert!(products == whole[standing], "kill {number}: the old or the new: {:?}", products.keys());
        // The next run succeeds as if nothing had happened.
        if number % 5 == 4 {
            folder.run(&flatten(SURFACES[next], "asset")).succeeded();
            assert!(folder.files("asset") == whole[next], "after kill {number}: {:?}", folder.files("asset").keys());
            standing = next;
        }
    }
}

fn without_unfinished(mut files: BTreeMap<String, Vec<u8>>) -> BTreeMap<String, Vec<u8>> {
    files.retain(|name, _| !name.starts_with(".brdfc-"));
    files
}

#[test]
fn two_builds_at_a_time_give_one_or_the_other() {
    let folder = Folder::new();
    folder.write("a.toml", cheap(0..3, 12));
    folder.write("b.toml", cheap(2..5, 8));
    let mut whole = Vec::new();
    for name in ["a", "b"] {
        folder.run(&["build", &format!("{name}.toml"), "--out", name]).succeeded();
        whole.push(folder.products(name));
    }
    for round in 0..4 {
        let children = ["a.toml", "b.toml", "a.toml"].map(|scene| started(&folder, &["build", scene, "--no-cache"]));
        for child in children {
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        let products = folder.products("packs");
        agrees(&products, &format!("round {round}"));
        assert!(whole.contains(&products), "round {round}: {:?}", products.keys());
    }
}
