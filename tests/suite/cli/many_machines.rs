//! Builds in pieces, by engines that exist.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};
use std::collections::BTreeMap;
use std::process::Command;
use std::sync::LazyLock;

/// Four materials, two of which are the same work, with a map each, and one with lobes.
fn folder() -> Folder {
    let folder = Folder::new();
    inputs(&folder);
    let wave = image::Rgb32FImage::from_fn(32, 16, |x, _| image::Rgb([0.5 + 0.01 * x as f32, 1.0, 1.0]));
    image::DynamicImage::ImageRgb32F(wave).save(folder.path().join("sky.hdr")).unwrap();
    folder.write(
        "my scene.toml",
        "[scene]\nenvironment = 'sky.hdr'\n[defaults]\ncodec = 'table'\nmax_bytes = 2000\n\
         [materials.table]\nsource = 'table.binary'\n[materials.twin]\nsource = 'table.binary'\n\
         [materials.round]\nsource = 'round.brdf'\n[materials.ward]\nsource = 'synth:ward'\n\
         [[uses]]\nmaterial = 'table'\nmaps = ['samples']\n[[uses]]\nmaterial = 'twin'\nmaps = ['samples']\n\
         [[uses]]\nmaterial = 'round'\nmaps = ['samples']\n[[uses]]\nmaterial = 'ward'\nmaps = ['lobes', 'bandwidth']\n",
    );
    folder
}

/// Result of a single build.
static WHOLE: LazyLock<BTreeMap<String, Vec<u8>>> = LazyLock::new(|| {
    let folder = folder();
    folder.run(&["build", "my scene.toml"]).succeeded();
    folder.products("packs")
});

#[test]
fn shards_make_the_whole() {
    let folder = folder();
    for number in 1..=3 {
        let (shard, out) = (format!("{number}/3"), format!("part-{number}"));
        let ran = folder.run(&["build", "my scene.toml", "--shard", &shard, "--out", &out]).succeeded();
        assert!(ran.stdout.lines().all(|line| line.ends_with(": built")), "{}", ran.stdout);
        assert!(folder.products(&out).is_empty(), "nothing is put in place");
    }
    let from = ["--from", "part-1", "--from", "part-2", "--from", "part-3"];
    let merged = folder.run(&[&["build", "my scene.toml", "--json"][..], &from].concat()).succeeded().json();
    assert!(merged["materials"].as_array().unwrap().iter().all(|m| m["cached"] == true), "all is cached");
    assert!(folder.products("packs") == *WHOLE);
    for (arguments, words) in [
        (&["--shard", "4/3"][..], "--shard"),
        (&["--shard", "1/3", "--only", "table.brdf"], "--shard"),
        (
            &["--only", "table"],
            "--only: found \"table\", expected environment.maps, round.brdf, round.maps, table.brdf, table.maps, \
             ward.brdf, ward.lobes or ward.maps",
        ),
        (&["--shard", "1/3", "--json"], "--json does not apply to --shard and --only"),
    ] {
        let ran = folder.run(&[&["build", "my scene.toml"], arguments].concat());
        assert!(ran.code == 2 && ran.stderr.contains(words), "{}", ran.stderr);
    }
    let ran = folder.run(&["build", "my scene.toml", "--from", "nowhere"]);
    assert!(ran.code == 4 && ran.stderr.contains("--from: found nowhere, expected a folder that"), "{}", ran.stderr);
}

#[test]
fn the_graph_is_one_job_per_material_and_part() {
    let folder = folder();
    let graph = folder.run(&["plan", "my scene.toml", "--format", "json"]).succeeded().json();
    conforms("plan", &graph);
    let names: Vec<_> = graph["jobs"].as_array().unwrap().iter().map(|job| job["name"].as_str().unwrap()).collect();
    let of_tables = ["environment.maps", "round.brdf", "round.maps", "table.brdf", "table.maps"];
    let parts = [&of_tables[..], &["ward.brdf", "ward.lobes", "ward.maps"]].concat();
    assert_eq!(names, parts);
    for job in graph["jobs"].as_array().unwrap().iter().chain([&graph["merge"]]) {
        let command: Vec<&str> = job["command"].as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect();
        assert_eq!(command[0], "brdfc");
        folder.run(&command[1..]).succeeded();
        assert!(folder.path().join(job["stamp"].as_str().unwrap()).is_file());
    }
    assert!(folder.products("packs") == *WHOLE);
}

#[test]
fn ninja_runs_the_graph() {
    let Ok(version) = Command::new("ninja").arg("--version").output() else {
        println!("skipped: no ninja (Debian: ninja-build)");
        return;
    };
    assert!(version.status.success());
    let folder = folder();
    let program = env!("CARGO_BIN_EXE_brdfc");
    let ran = folder.run(&["plan", "my scene.toml", "--format", "ninja", "--program", program]).succeeded();
    folder.write("build.ninja", ran.stdout);
    let ninja = || {
        let output = Command::new("ninja").args(["-j", "2"]).current_dir(folder.path()).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        (output.status.success(), text)
    };
    let (built, message) = ninja();
    assert!(built && message.contains("[9/9] merge"), "{message}");
    assert!(folder.products("packs") == *WHOLE);
    assert!(ninja().1.contains("no work to do"));
    // Deleted files are restored, and nothing is built again.
    for (name, _) in folder.products("packs").iter().take(2) {
        std::fs::remove_file(folder.path().join("packs").join(name)).unwrap();
        let (built, message) = ninja();
        assert!(built && message.contains("[1/1] merge"), "{name}: {message}");
        assert!(folder.products("packs") == *WHOLE);
        assert!(ninja().1.contains("no work to do"), "{name}");
    }
    // A modified source is built again, and nothing else.
    folder.run(&["synth", "ggx?alpha=0.5", "-o", "round.brdf", "--rows", "300"]).succeeded();
    let (built, message) = ninja();
    assert!(built && message.contains("[3/3] merge"), "{message}");
    // A failed job stops the build before any file is moved.
    let before = folder.products("packs");
    folder.write("round.brdf", "no scan");
    let (built, message) = ninja();
    assert!(!built && message.contains("round.brdf: "), "{message}");
    assert!(folder.products("packs") == before);
}

#[test]
fn slurm_runs_shards_as_a_job_array() {
    let folder = folder();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/engines/slurm.sh");
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/many-machines.md")).unwrap();
    let run = std::fs::read_to_string(script).unwrap();
    for shown in
        ["sbatch --parsable --array=", "sbatch --wait --dependency=\"afterok:$array\" --kill-on-invalid-dep=yes"]
    {
        assert!(page.contains(shown) && run.contains(shown), "{shown}");
    }
    let program = env!("CARGO_BIN_EXE_brdfc");
    let ran = Command::new("timeout")
        .arg("100")
        .arg(script)
        .arg(folder.path())
        .args([program, "my scene.toml", "3"])
        .output();
    let ran = ran.unwrap();
    let message = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
    if ran.status.code() == Some(77) {
        println!("skipped: {}", message.lines().find(|line| line.starts_with("skipped")).unwrap_or("Slurm"));
        return;
    }
    assert!(ran.status.success(), "{message}");
    assert!(folder.products("packs") == *WHOLE, "{message}");
}
