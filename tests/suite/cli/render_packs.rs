//! `brdfc render` of the packs in a folder.

use super::render::MANIFEST;
use crate::common::cli::Folder;
use crate::common::has_adapter;

/// Limits check the files that ship.
#[test]
fn limits_hold_for_the_files_of_the_folder_alone() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let material = |name: &str, kd: &str| {
        format!("[materials.{name}]\nsource = 'synth:lambert?kd={kd}'\n[[uses]]\nmaterial = '{name}'\n")
    };
    let scene = "[render]\nscene = 'sphere'\nwidth = 48\nheight = 48\n";
    folder.write("scene.toml", material("a", "0.3") + &material("b", "0.6") + scene);
    folder.run(&["build", "scene.toml", "--out", "made"]).succeeded();
    let checked = ["render", "scene.toml", "--packs", "made", "-o", "x.png", "--max-delta-e", "3"];
    folder.run(&checked).succeeded();
    let whole = folder.read("made/a.brdf.ktx2");
    folder.write("made/a.brdf.ktx2", folder.read("made/b.brdf.ktx2"));
    let swapped = folder.run(&checked);
    assert!(swapped.code == 1 && swapped.stderr.contains("a.brdf.ktx2: damaged, or made from"), "{swapped:?}");
    std::fs::remove_file(folder.path().join("made/a.brdf.ktx2")).unwrap();
    let missing = folder.run(&checked);
    assert!(missing.code == 1 && missing.stderr.contains("a.brdf.ktx2: missing; run "), "{missing:?}");
    let drawn = folder.run(&checked[..6]).succeeded();
    assert!(drawn.stderr.contains("a.brdf.ktx2 is not in the folder"), "{drawn:?}");
    folder.write("made/a.brdf.ktx2", whole);
    folder.run(&checked).succeeded();
}

#[test]
fn packs_of_a_build_are_drawn_as_they_are() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    folder.write("scene.toml", MANIFEST.replace("\n[render.materials]\nball = 'blue'\n", ""));
    folder.run(&["build", "scene.toml", "--out", "packs"]).succeeded();
    let fresh = folder.run(&["render", "scene.toml", "-o", "a.png"]).succeeded();
    let retained = folder.run(&["render", "scene.toml", "--packs", "packs", "-o", "b.png"]).succeeded();
    assert_eq!(fresh.stdout, retained.stdout);
    assert_eq!(folder.read("a.png"), folder.read("b.png"));
    let missing = folder.run(&["render", "scene.toml", "--packs", "nowhere"]);
    assert_eq!(missing.code, 4, "{}", missing.stderr);
    assert!(missing.stderr.contains("nowhere: cannot read: not a folder"), "{}", missing.stderr);
    // Outdated packs are not drawn, and remain in the folder.
    let old = folder.products("packs");
    folder.write("scene.toml", folder.text("scene.toml").replace("grid = 8", "grid = 4"));
    let changed = folder.run(&["render", "scene.toml", "-o", "c.png"]).succeeded();
    assert!(changed.stderr.contains("red.brdf.ktx2 is out of date"), "{}", changed.stderr);
    assert!(folder.read("c.png") != folder.read("a.png") && folder.products("packs") == old);
    folder.run(&["build", "scene.toml", "--out", "packs"]).succeeded();
    let current = folder.run(&["render", "scene.toml", "-o", "d.png"]).succeeded();
    assert!(!current.stderr.contains("is out of date") && folder.read("c.png") == folder.read("d.png"));
}
