//! `brdfc verify`: damaged, modified and missing files are listed, with exit code 1.

use super::schemas::conforms;
use crate::common::cli::Folder;

/// A path to verify after a change to a folder, with the beginning of the fault's line and its text.
type Fault<'a> = (&'a str, &'a dyn Fn(&Folder), &'a str, &'a str);

fn built() -> Folder {
    let folder = Folder::new();
    folder.write("scans/a.binary", include_bytes!("../../../testdata/demo/red_plastic.binary"));
    folder.run(&["build", "scans", "--max-bytes", "4KiB", "--out", "packs", "--quiet"]).succeeded();
    folder
}

#[test]
fn whole_folders_packs_and_reports() {
    let folder = built();
    folder.write("packs/notes.txt", b"of another program");
    for (path, count) in [("packs", 3), ("packs/report.json", 3), ("packs/a.json", 2), ("packs/a.brdf.ktx2", 1)] {
        let report = folder.run(&["verify", path, "--json"]).succeeded().json();
        conforms("verify", &report);
        assert_eq!((report["files"].as_array().unwrap().len(), &report["faults"]), (count, &0.into()), "{report}");
    }
    let ran = folder.run(&["verify", "packs", "packs/a.brdf.ktx2"]).succeeded();
    assert!(ran.stdout.is_empty() && ran.stderr.ends_with("4 files: intact\n"), "{ran:?}");
}

#[test]
fn each_fault_is_named() {
    let replace = |folder: &Folder, file: &str, from: &str, to: &str| {
        let text = String::from_utf8(folder.read(file)).unwrap();
        assert!(text.contains(from), "{text}");
        folder.write(file, text.replacen(from, to, 1).as_bytes());
    };
    let flip = |folder: &Folder| {
        let mut bytes = folder.read("packs/a.brdf.ktx2");
        let middle = bytes.len() / 2;
        bytes[middle] ^= 4;
        folder.write("packs/a.brdf.ktx2", &bytes);
    };
    let cases: [Fault<'_>; 8] = [
        ("packs", &flip, "packs/a.brdf.ktx2: ", "checksum of the file"),
        ("packs/a.brdf.ktx2", &flip, "packs/a.brdf.ktx2: ", "checksum of the file"),
        (
            "packs",
            &|folder| {
                folder.run(&["encode", "synth:lambert", "-o", "packs/a.brdf.ktx2"]).succeeded();
            },
            "packs/a.brdf.ktx2: ",
            "changed since the build",
        ),
        (
            "packs",
            &|folder| std::fs::remove_file(folder.path().join("packs/a.json")).unwrap(),
            "packs/a.json: ",
            "cannot read",
        ),
        (
            "packs",
            &|folder| replace(folder, "packs/report.json", "\"relative_mean\": 0.", "\"relative_mean\": 0.0"),
            "packs/report.json: invalid figures of a: ",
            "expected those of a.json",
        ),
        (
            "packs",
            &|folder| {
                let mut report: serde_json::Value = serde_json::from_slice(&folder.read("packs/report.json")).unwrap();
                report["materials"][0]["files"] = serde_json::json!([]);
                folder.write("packs/report.json", report.to_string());
            },
            "packs/report.json: invalid files of a: ",
            "expected the hash of each of its parts",
        ),
        (
            "packs/report.json",
            &|folder: &Folder| drop(folder.write("packs/report.json", b"{")),
            "packs/report.json: ",
            "ends too early",
        ),
        (
            "packs/a.json",
            &|folder| {
                folder.run(&["encode", "synth:lambert", "-o", "packs/a.brdf.ktx2"]).succeeded();
            },
            "packs/a.json: invalid key/value data: ",
            "expected that of a.brdf.ktx2",
        ),
    ];
    for (path, change, begins, says) in cases {
        let folder = built();
        change(&folder);
        let ran = folder.run(&["verify", path]);
        let line = ran.stdout.lines().find(|line| line.starts_with(begins)).unwrap_or_default();
        assert!(ran.code == 1 && line.contains(says), "{path}, {says}: {ran:?}");
        assert!(ran.stderr.contains("not intact"), "{ran:?}");
    }
}

#[test]
fn nothing_to_check_is_a_failed_check_and_others_are_checked_all_the_same() {
    let folder = built();
    folder.write("empty/notes.txt", b"");
    folder.write("packs/more.ktx2", b"no pack");
    for (paths, code, problem) in [
        (&["empty"][..], 1, "empty: found nothing to check"),
        (&["gone.ktx2"], 4, "gone.ktx2: cannot read"),
        (&["empty/notes.txt"], 2, "found another file, expected a pack"),
        (&["gone.ktx2", "packs"], 4, "gone.ktx2: cannot read"),
    ] {
        let ran = folder.run(&[&["verify"], paths].concat());
        assert!(ran.code == code && ran.stderr.contains(problem), "{paths:?}: {ran:?}");
        assert_eq!(ran.stdout.contains("packs/more.ktx2: "), paths.contains(&"packs"), "{ran:?}");
    }
}
