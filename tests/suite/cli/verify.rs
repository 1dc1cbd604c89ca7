//! `brdfc verify`: damaged, modified and missing files are listed, with exit code 1.

use super::schemas::conforms;
use crate::common::cli::{Folder, with_checksum};

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
    let cases: [Fault<'_>; 9] = [
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
            &|folder| {
                replace(folder, "packs/report.json", "\"relative_mean\": 0.", "\"relative_mean\": 0.0");
                folder.write("packs/report.json", with_checksum(&folder.text("packs/report.json")));
            },
            "packs/report.json: a: the figures ",
            "do not match the hash of a.json",
        ),
        (
            "packs",
            &|folder| replace(folder, "packs/report.json", "\"relative_mean\": 0.", "\"relative_mean\": 0.0"),
            "packs/report.json: the checksum does not match",
            "; a: the figures ",
        ),
        (
            "packs",
            &|folder| {
                let mut report: serde_json::Value = serde_json::from_slice(&folder.read("packs/report.json")).unwrap();
                report["materials"][0]["files"] = serde_json::json!([]);
                report.as_object_mut().unwrap().remove("checksum");
                folder.write("packs/report.json", with_checksum(&serde_json::to_string_pretty(&report).unwrap()));
            },
            "packs/report.json: a: the hashed files ",
            "the hashed files are not the parts of the material",
        ),
        (
            "packs/report.json",
            &|folder: &Folder| drop(folder.write("packs/report.json", b"{")),
            "packs/report.json: found ",
            "truncated JSON",
        ),
        (
            "packs/a.json",
            &|folder| {
                folder.run(&["encode", "synth:lambert", "-o", "packs/a.brdf.ktx2"]).succeeded();
            },
            "packs/a.json: the key/value data ",
            "differ from the data in a.brdf.ktx2",
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
        (&["empty"][..], 1, "empty: nothing to verify"),
        (&["gone.ktx2"], 4, "gone.ktx2: cannot read"),
        (&["empty/notes.txt"], 2, "empty/notes.txt: cannot be verified; expected a pack"),
        (&["gone.ktx2", "packs"], 4, "gone.ktx2: cannot read"),
    ] {
        let ran = folder.run(&[&["verify"], paths].concat());
        assert!(ran.code == code && ran.stderr.contains(problem), "{paths:?}: {ran:?}");
        assert_eq!(ran.stdout.contains("packs/more.ktx2: "), paths.contains(&"packs"), "{ran:?}");
    }
}

/// `verify` and `report` detect every edit of a report.
#[test]
fn edits_of_a_report_are_found() {
    let folder = Folder::new();
    let gated = "[materials.a]\nsource='synth:ggx'\nrequire={ max_delta_e = 0.001 }\n\
                 [materials.b]\nsource='gone.brdf'\n[materials.c]\nsource='synth:ward'\n\
                 [[uses]]\nmaterial='a'\n[[uses]]\nmaterial='b'\n";
    folder.write("scene.toml", gated);
    let ran = folder.run(&["build", "scene.toml", "--max-bytes", "1KiB", "--codec", "table", "--quiet"]);
    assert_eq!(ran.code, 4, "{ran:?}");
    let report = "packs/report.json";
    let whole = folder.text(report);
    let end = whole.find(",\n  \"checksum\": \"").expect("a checksum");
    let text = format!("{}\n}}\n", &whole[..end]);
    let digest = blake3::hash(text.as_bytes()).to_hex();
    assert_eq!(whole[end..], format!(",\n  \"checksum\": \"{digest}\"\n}}\n"));
    assert_eq!(with_checksum(&text), whole);
    folder.run(&["verify", "packs"]).succeeded();
    let edits: &[(&str, &str)] = &[
        ("\"passed\": false", "\"passed\": true"),
        ("\"gates\": [", "\"notes\": ["),
        ("\"error\": \"", "\"reason\": \""),
        ("\"scene\": \"", "\"scene\": \"another "),
        ("\"source\": \"synth:ggx", "\"source\": \"synth:ward"),
        ("\"skipped\": [\n    \"c\"\n  ]", "\"skipped\": []"),
        ("\"checksum\": \"", "\"checksums\": \""),
        (",\n  \"checksum\": \"", ",\n  \"more\": 1,\n  \"checksum\": \""),
        ("{\n", "{ \n"),
    ];
    for (from, to) in edits {
        assert!(whole.contains(from), "{from}: {whole}");
        folder.write(report, whole.replacen(from, to, 1));
        let ran = folder.run(&["verify", "packs"]);
        let line = ran.stdout.lines().find(|line| line.starts_with("packs/report.json: ")).unwrap_or_default();
        assert!(ran.code == 1 && line.contains("checksum"), "{to}: {ran:?}");
        let page = folder.run(&["report", "packs", "-o", "page.html"]);
        assert!(page.code == 3 && page.stderr.contains("packs/report.json: ") && page.stderr.contains("checksum"));
    }
    folder.write("old.json", folder.read(report));
    folder.write(report, &whole);
    let page = folder.run(&["report", "packs", "-o", "page.html", "--against", "old.json"]);
    assert!(page.code == 3 && page.stderr.contains("old.json: the checksum does not match"), "{page:?}");
    folder.run(&["verify", "packs"]).succeeded();
}

#[test]
fn the_files_of_an_edited_report_are_checked() {
    let folder = built();
    let edited = folder.text("packs/report.json").replacen("{\n", "{ \n", 1);
    folder.write("packs/report.json", edited);
    std::fs::remove_file(folder.path().join("packs/a.brdf.ktx2")).unwrap();
    let ran = folder.run(&["verify", "packs"]);
    let faults: Vec<_> = ran.stdout.lines().filter_map(|line| line.split(": ").next()).collect();
    assert!(faults.starts_with(&["packs/report.json", "packs/a.brdf.ktx2"]), "{ran:?}");
}

#[test]
fn a_report_that_is_gone_is_a_fault() {
    let missing = |folder: &Folder| {
        let ran = folder.run(&["verify", "packs"]);
        assert!(ran.code == 1 && ran.stdout == "packs/report.json: missing\n", "{ran:?}");
    };
    let folder = built();
    let lose = |name: &str| std::fs::remove_file(folder.path().join("packs").join(name)).unwrap();
    lose("report.json");
    missing(&folder);
    std::fs::remove_dir_all(folder.path().join("packs/.brdfc-cache")).unwrap();
    missing(&folder);
    // Packs alone are a folder of packs.
    lose("a.json");
    folder.run(&["verify", "packs"]).succeeded();
}

/// Nothing counts as missing or damaged while a build moves files.
#[test]
fn a_living_build_is_no_damage() {
    let folder = built();
    let lock = std::fs::File::options().write(true).open(folder.path().join("packs/.brdfc-cache/lock")).unwrap();
    let report = folder.read("packs/report.json");
    let list = folder.path().join("packs/.brdfc-cache/commit/list");
    lock.lock().unwrap();
    folder.write("packs/.brdfc-cache/commit/list", b"begun");
    std::fs::remove_file(folder.path().join("packs/report.json")).unwrap();
    let report_on = ["report", "packs", "-o", "page.html", "--quiet"];
    for arguments in [&["verify", "packs"][..], &["verify", "packs/a.json"], &report_on] {
        let ran = folder.run(arguments);
        assert!(ran.code == 4 && ran.stderr.contains("packs: a build is replacing files in this folder"), "{ran:?}");
    }
    // Who comes while files are moved waits a little.
    std::thread::scope(|scope| {
        let waiting = scope.spawn(|| folder.run(&["verify", "packs"]));
        std::thread::sleep(std::time::Duration::from_millis(700));
        folder.write("packs/report.json", report);
        std::fs::remove_dir_all(list.parent().unwrap()).unwrap();
        lock.unlock().unwrap();
        waiting.join().unwrap().succeeded();
    });
    folder.run(&report_on).succeeded();
}
