//! Full disks and read-only folders.

use super::refused;
use crate::common::cli::Folder;
use std::process::Command;

const SCENE: &str = "[materials.a]\nsource = 'synth:lewis'\ngrid = 8\n[[uses]]\nmaterial = 'a'\n";

#[test]
fn a_file_in_place_of_the_output_folder() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    folder.write("packs", b"a file");
    refused(&folder, &["build", "scene.toml"], 4, &["brdfc: packs: cannot write: "]);
    refused(&folder, &["build", "scene.toml", "--out", "packs/deeper"], 4, &["brdfc: packs/deeper: cannot write: "]);
}

#[test]
fn a_folder_in_place_of_a_pack() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    folder.write("packs/a.brdf.ktx2/file", b"x");
    let words = ["brdfc: packs/a.brdf.ktx2: a folder is in the way; rename it"];
    for arguments in [["build", "scene.toml"].as_slice(), &["build", "scene.toml", "--force"]] {
        let ran = folder.run(arguments);
        assert!(ran.code == 4 && words.iter().all(|words| ran.stderr.contains(words)), "{}", ran.stderr);
    }
    assert_eq!(folder.products("packs").into_keys().collect::<Vec<_>>(), ["a.brdf.ktx2/file"]);
}

#[test]
#[cfg(unix)]
fn a_read_only_folder() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    let packs = folder.path().join("packs");
    std::fs::create_dir(&packs).unwrap();
    std::fs::set_permissions(&packs, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(packs.join("probe"), b"").is_ok() {
        println!("skipped: this user may write into read-only folders");
        return;
    }
    let ran = folder.run(&["build", "scene.toml"]);
    assert!(ran.code == 4 && ran.stderr.contains("cannot write: "), "{}", ran.stderr);
    assert!(folder.files("packs").is_empty());
}

/// Files that a build writes next to its packs never replace a measurement or another output.
#[test]
fn stamps_and_rules_are_files_of_their_own() {
    let folder = Folder::new();
    folder.run(&["synth", "lewis", "-o", "a.binary", "--dimensions", "6x6x12"]).succeeded();
    folder.write("scene.toml", "[materials.a]\nsource = 'a.binary'\ngrid = 2\n[[uses]]\nmaterial = 'a'\n");
    for (arguments, code, expected) in [
        (&["--stamp", "a.binary"][..], 2, "--stamp: would overwrite the input a.binary"),
        (&["--stamp", "scene.toml"], 2, "--stamp: would overwrite the input scene.toml; choose another file"),
        (&["--depfile", "a.binary"], 2, "--depfile: would overwrite the input a.binary; choose another file"),
        (&["--depfile", "x", "--stamp", "./x"], 2, "--depfile and --stamp: both are ./x; choose different paths"),
        (&["--stamp", "packs/report.json"], 2, "--stamp: packs/report.json is reserved for the build; choose another"),
        (&["--depfile", "packs/a.brdf.ktx2"], 2, "--depfile: packs/a.brdf.ktx2 is reserved for the build"),
        (&["--depfile", "no/x"], 4, "no/x: cannot write: there is no folder no"),
        (&["--from", "nowhere"], 4, "--from: found nowhere, expected a folder that 'brdfc build' filled"),
        (&["--shard", "1/1", "--stamp", "a.binary"], 2, "--stamp: would overwrite the input a.binary"),
    ] {
        std::fs::create_dir_all(folder.path().join("packs")).unwrap();
        refused(&folder, &[&["build", "scene.toml"], arguments].concat(), code, &[expected]);
    }
    folder.run(&["build", "scene.toml", "--stamp", "done", "--depfile", "packs/rule.d"]).succeeded();
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    // A small file system in its own name space, which disappears with the shell.
    let script = "mkdir small && mount -t tmpfs -o size=16k none small || exit 99
        \"$0\" encode synth:lewis --grid 32 -o small/p.ktx2; echo \"code $?\"
        \"$0\" flatten synth:button?resolution=16 --texels 16 --views grid:2x6@50 --reflectance factors -o small/flat
        echo \"code $?\"
        \"$0\" build scene.toml --quiet --out small/packs > /dev/null; echo \"code $?\"
        \"$0\" synth lewis -o small/a.binary --dimensions 16x16x32; echo \"code $?\"
        find small -type f -size +0";
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_brdfc")])
        .current_dir(folder.path())
        .output();
    let Ok(output) = output.map_err(|error| println!("skipped: unshare: {error}")) else { return };
    if !matches!(output.status.code(), Some(0)) {
        println!("skipped: cannot mount a small file system; /dev/full is tested elsewhere");
        return;
    }
    let (stdout, stderr) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    let lines: Vec<&str> = stdout.lines().collect();
    assert_eq!(
        (lines[0], *lines.iter().rfind(|line| line.starts_with("code")).unwrap()),
        ("code 4", "code 4"),
        "{stderr}"
    );
    assert!(stderr.contains("brdfc: small/p.ktx2: cannot write: ") && !stderr.contains("panicked"), "{stderr}");
    assert!(stderr.contains("brdfc: small/a.binary: cannot write: "), "{stderr}");
    assert!(stderr.contains("brdfc: small/flat, scratch file of view "), "{stderr}");
    // All commands report the system's message.
    for line in stderr.lines().filter(|line| line.contains("cannot write")) {
        assert!(line.ends_with(": cannot write: No space left on device"), "{line}");
    }
    for left in lines.iter().filter(|line| line.starts_with("small")) {
        assert!(
            !left.contains(".tmp")
                && !left.contains("small/flat")
                && !left.contains("p.ktx2")
                && !left.contains("a.binary"),
            "{left} is left"
        );
    }
}
