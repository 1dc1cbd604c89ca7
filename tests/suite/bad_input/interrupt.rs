//! Interrupts in the middle of a build.

use crate::common::cli::Folder;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

const MATERIALS: usize = 200;

/// Materials that take a fraction of a second each.
fn scene(numbers: impl Iterator<Item = usize>) -> String {
    numbers
        .map(|k| {
            format!(
                "[materials.m{k}]\nsource = 'synth:ward?kd=0.{k:03},0.2,0.1'\ngrid = 16\nmax_error = 0.01\nbits = 12\n\
                 [[uses]]\nmaterial = 'm{k}'\n"
            )
        })
        .collect()
}

#[test]
#[cfg(unix)]
fn finished_packs_are_whole_and_nothing_else_is_left() {
    let folder = Folder::new();
    folder.write("scene.toml", scene(0..MATERIALS));
    let mut child = Command::new(env!("CARGO_BIN_EXE_brdfc"))
        .args(["build", "scene.toml", "--jobs", "2"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    lines.read_line(&mut line).unwrap();
    assert!(line.starts_with(&format!("1 of {MATERIALS}: ")), "{line}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    assert!(
        rest.contains("brdfc: interrupted; files that were finished are whole") && !rest.contains("panicked"),
        "{rest}"
    );

    let files = folder.products("packs");
    let packs: Vec<_> = files.keys().filter(|name| name.ends_with(".ktx2")).collect();
    assert!(!packs.is_empty() && packs.len() < MATERIALS, "{} packs: it was stopped in the middle", packs.len());
    for pack in &packs {
        folder.run(&["info", &format!("packs/{pack}")]).succeeded();
        assert!(files.contains_key(&pack.replace(".brdf.ktx2", ".json")), "{pack} is listed");
    }
    assert_eq!(files.len(), 2 * packs.len() + 1, "packs, their lists, the report: {:?}", files.keys());
    assert!(folder.files("packs").keys().all(|name| !name.ends_with(".tmp")));
    let report: serde_json::Value = serde_json::from_str(&folder.text("packs/report.json")).unwrap();
    let made = report["materials"].as_array().unwrap().iter().filter(|m| m.get("pack").is_some()).count();
    assert_eq!(made, packs.len());

    // The next build keeps what is there.
    let number = |pack: &&String| pack[1..pack.find('.').unwrap()].parse().unwrap();
    folder.write("scene.toml", scene(packs.iter().map(number)));
    let again = folder.run(&["build", "scene.toml", "--json"]).succeeded().json();
    assert!(again["materials"].as_array().unwrap().iter().all(|m| m["cached"] == true), "{again}");
    for pack in packs {
        assert!(folder.read(&format!("packs/{pack}")) == files[pack], "{pack} stayed");
    }
}
