//! Effects of a build on a folder that already contains files.

use crate::common::cli::{Folder, Ran};

fn build(folder: &Folder, inputs: &[&str], options: &[&str]) -> Ran {
    let fast = ["--codec", "table", "--max-bytes", "1KiB", "--quiet"];
    folder.run(&[&["build"], inputs, options, &fast].concat())
}

fn packs(folder: &Folder, name: &str) -> Vec<String> {
    folder.files(name).into_keys().filter(|file| file.ends_with(".ktx2") && !file.starts_with('.')).collect()
}

#[test]
fn an_input_is_not_removed() {
    let folder = Folder::new();
    build(&folder, &["synth:ggx", "synth:ward"], &["--out", "lastweek"]).succeeded();
    let before = folder.files("lastweek");
    let scene = "[materials.again]\nsource='lastweek/ggx.brdf.ktx2'\n[[uses]]\nmaterial='again'\n";
    folder.write("scene.toml", scene);
    #[cfg(unix)]
    std::os::unix::fs::symlink("lastweek/ggx.brdf.ktx2", folder.path().join("link.ktx2")).unwrap();
    for input in ["lastweek/ggx.brdf.ktx2", "scene.toml", "link.ktx2"].into_iter().take(if cfg!(unix) { 3 } else { 2 })
    {
        let ran = build(&folder, &[input], &["--out", "lastweek"]);
        let expected = "lastweek/ggx.brdf.ktx2: the build would remove this input";
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{input}: {ran:?}");
        assert_eq!(packs(&folder, "lastweek"), ["ggx.brdf.ktx2", "ward.brdf.ktx2"]);
        assert!(
            before
                .iter()
                .filter(|(name, _)| name.ends_with(".ktx2"))
                .all(|(name, bytes)| { folder.read(&format!("lastweek/{name}")) == *bytes })
        );
    }
    build(&folder, &["scene.toml"], &["--out", "lastweek", "--keep"]).succeeded();
    assert_eq!(packs(&folder, "lastweek"), ["again.brdf.ktx2", "ggx.brdf.ktx2", "ward.brdf.ktx2"]);
    // Elsewhere it may be read, and files of other programs are not removed.
    build(&folder, &["lastweek/ggx.brdf.ktx2"], &["--out", "today"]).succeeded();
    std::fs::copy(folder.path().join("lastweek/ggx.brdf.ktx2"), folder.path().join("today/mine.ktx2")).unwrap();
    build(&folder, &["today/mine.ktx2"], &["--out", "today"]).succeeded();
    assert_eq!(packs(&folder, "today"), ["mine.brdf.ktx2", "mine.ktx2"]);
}

/// The store, or any part of it, may be deleted at any time: the report lists the build's own files.
#[test]
fn a_folder_is_known_by_its_report() {
    let folder = Folder::new();
    let both = ["synth:ggx", "synth:ward"];
    build(&folder, &both, &["--out", "packs"]).succeeded();
    let whole = folder.products("packs");
    let cache = folder.path().join("packs/.brdfc-cache");
    std::fs::remove_dir_all(&cache).unwrap();
    build(&folder, &both, &["--out", "packs"]).succeeded();
    assert!(folder.products("packs") == whole);
    let mut placed = std::fs::read(cache.join("placed")).unwrap();
    placed[40] ^= 4;
    std::fs::write(cache.join("placed"), placed).unwrap();
    // Files that are no longer requested are removed, including lists.
    build(&folder, &both[..1], &["--out", "packs"]).succeeded();
    let names: Vec<String> = folder.products("packs").into_keys().collect();
    assert_eq!(names, ["ggx.brdf.ktx2", "ggx.json", "report.json"]);
    // Files of other programs remain.
    std::fs::remove_dir_all(&cache).unwrap();
    folder.write("packs/ggx.json", "mine");
    let refused = build(&folder, &both, &["--out", "packs"]);
    assert!(refused.code == 4 && refused.stderr.contains("ggx.json: would overwrite a file"), "{refused:?}");
    assert_eq!(folder.text("packs/ggx.json"), "mine");
}

/// Names with letters of any script; names that are too long for files are truncated, and nothing is partially replaced.
#[test]
fn names_of_files_are_those_of_materials() {
    let folder = Folder::new();
    let red = std::fs::read(brdfc_testing::testdata("demo/red_plastic.binary")).unwrap();
    let long = "x".repeat(246);
    for name in ["漢字", "木綿", "é", &long] {
        folder.write(&format!("scans/{name}.binary"), &red);
    }
    build(&folder, &["scans"], &["--out", "packs"]).succeeded();
    let cut = format!("{}.brdf.ktx2", "x".repeat(200));
    assert_eq!(packs(&folder, "packs"), [cut.as_str(), "é.brdf.ktx2", "木綿.brdf.ktx2", "漢字.brdf.ktx2"]);
    build(&folder, &["scans"], &["--out", "packs"]).succeeded();
    folder.run(&["report", "packs", "-o", "page.html", "--quiet"]).succeeded();
    assert!(folder.text("page.html").contains("漢字"));
    // The same name in another form of accents.
    folder.write("scans/e\u{301}.binary", &red);
    let refused = build(&folder, &["scans"], &["--out", "packs"]);
    assert!(refused.code == 3 && refused.stderr.contains("both would be named é"), "{refused:?}");
    // In manifests, a name that is too long is an error before any work.
    folder.write("scene.toml", format!("[materials.{long}]\nsource = 'synth:ggx'\n[[uses]]\nmaterial = '{long}'\n"));
    let refused = build(&folder, &["scene.toml"], &["--out", "packs"]);
    assert!(refused.code == 3 && refused.stderr.contains("expected at most 200 bytes"), "{refused:?}");
    assert_eq!(packs(&folder, "packs").len(), 4);
}

#[test]
fn retained_materials_stay_in_the_report() {
    let folder = Folder::new();
    build(&folder, &["synth:ggx", "synth:ward"], &["--out", "packs"]).succeeded();
    let reported = |folder: &Folder| -> Vec<(String, bool)> {
        let report: serde_json::Value = serde_json::from_slice(&folder.read("packs/report.json")).unwrap();
        let entry = |entry: &serde_json::Value| {
            (entry["material"].as_str().unwrap().to_owned(), entry["retained"].as_bool().unwrap_or(false))
        };
        report["materials"].as_array().unwrap().iter().map(entry).collect()
    };
    let old = folder.read("packs/report.json");
    folder.write("old.json", &old);
    build(&folder, &["synth:lambert"], &["--out", "packs", "--keep"]).succeeded();
    let expected = [("ggx", true), ("lambert", false), ("ward", true)];
    assert_eq!(reported(&folder), expected.map(|(name, retained)| (name.to_owned(), retained)));
    // Sources of retained materials are still known, and no file is missing.
    let page = folder.run(&["report", "packs", "-o", "page.html", "--against", "old.json"]);
    assert!(page.code == 0 && !page.stderr.contains("gone"), "{page:?}");
    // Missing files come back from the store.
    let before = folder.products("packs");
    for file in ["packs/ward.brdf.ktx2", "packs/ggx.json"] {
        std::fs::remove_file(folder.path().join(file)).unwrap();
    }
    build(&folder, &["synth:lambert"], &["--out", "packs", "--keep"]).succeeded();
    assert!(folder.products("packs") == before);
    build(&folder, &["synth:lambert"], &["--out", "packs"]).succeeded();
    assert_eq!(reported(&folder), [("lambert".to_owned(), false)]);
    assert_eq!(packs(&folder, "packs"), ["lambert.brdf.ktx2"]);
}

#[test]
fn one_reserved_name_stops_no_other() {
    let folder = Folder::new();
    for name in ["red.brdf", "con.brdf", "report.brdf"] {
        folder.write(&format!("scans/{name}"), "broken");
    }
    folder.run(&["synth", "synth:lambert", "-o", "scans/blue.csv"]).succeeded();
    let ran = build(&folder, &["scans"], &["--out", "packs"]);
    assert_eq!((ran.code, packs(&folder, "packs")), (3, vec!["blue.brdf.ktx2".to_owned()]), "{ran:?}");
    for name in ["con_", "report_", "red"] {
        assert!(ran.stderr.contains(&format!("brdfc: {name}: scans/")), "{ran:?}");
    }
}

/// Materials are retained completely or not at all: a modified file, parts that are no longer requested, and names that differ
/// only in case do not contradict the report.
#[test]
fn retained_materials_match_the_report() {
    let folder = Folder::new();
    let sources = "[materials.a]\nsource='synth:ggx'\n[materials.b]\nsource='synth:ggx'\n";
    folder.write("both.toml", format!("{sources}[[uses]]\nmaterial='a'\n[[uses]]\nmaterial='b'\n"));
    let reported = || -> Vec<String> {
        let report: serde_json::Value = serde_json::from_slice(&folder.read("packs/report.json")).unwrap();
        let names = report["materials"].as_array().unwrap().iter();
        names.map(|entry| entry["material"].as_str().unwrap().to_owned()).collect()
    };
    build(&folder, &["both.toml"], &["--out", "packs"]).succeeded();
    folder.write("packs/b.brdf.ktx2", "garbage");
    build(&folder, &["synth:ward"], &["--out", "packs", "--keep"]).succeeded();
    assert_eq!(reported(), ["a", "b", "ward"]);
    folder.run(&["verify", "packs"]).succeeded();
    folder.write("upper.toml", "[materials.A]\nsource='synth:lambert'\n[[uses]]\nmaterial='A'\n");
    build(&folder, &["upper.toml"], &["--out", "packs", "--keep"]).succeeded();
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    assert_eq!((reported(), packs(&folder, "packs").len()), (names(&["A", "b", "ward"]), 3));
    assert!(!folder.path().join("packs/a.brdf.ktx2").exists() || cfg!(not(target_os = "linux")));
    // A material that fails now has no earlier pack.
    folder.write("broken.toml", "[materials.ward]\nsource='gone.brdf'\n[[uses]]\nmaterial='ward'\n");
    assert_eq!(build(&folder, &["broken.toml"], &["--out", "packs", "--keep"]).code, 4);
    assert_eq!(
        (reported(), packs(&folder, "packs")),
        (names(&["A", "b", "ward"]), names(&["A.brdf.ktx2", "b.brdf.ktx2"]))
    );
}

#[test]
fn marks_and_rules_are_not_written_over_the_builds_own_files() {
    let folder = Folder::new();
    let refused = |inputs: &[&str], options: &[&str]| {
        let ran = build(&folder, inputs, options);
        assert!(ran.code == 2 && ran.stderr.contains("; choose another name or folder"), "{options:?}: {ran:?}");
    };
    for stamp in ["k/../k/ggx.brdf.ktx2", "k/../k/report.json", "k/.brdfc-cache/placed"] {
        refused(&["synth:ggx"], &["--out", "k", "--stamp", stamp]);
        refused(&["synth:ggx"], &["--out", "k", "--depfile", stamp]);
    }
    build(&folder, &["synth:ggx"], &["--out", "k", "--stamp", "k/done", "--depfile", "k/rule.d"]).succeeded();
    refused(&["synth:ward"], &["--out", "k", "--keep", "--stamp", "k/ggx.brdf.ktx2"]);
    assert!(!folder.read("k/ggx.brdf.ktx2").is_empty() && folder.files("k").contains_key("rule.d"));
}

/// With --keep nothing of earlier builds goes that cannot be listed or put back: the build is refused before any work.
#[test]
fn what_cannot_be_kept_is_refused() {
    let keep = |folder: &Folder| build(folder, &["synth:lambert"], &["--out", "packs", "--keep"]);
    let both = || {
        let folder = Folder::new();
        build(&folder, &["synth:lambert", "synth:ggx"], &["--out", "packs"]).succeeded();
        folder
    };
    let refused = |folder: &Folder, words: &str| {
        let before = folder.products("packs");
        let ran = keep(folder);
        assert!(ran.code == 4 && ran.stderr.contains(words) && ran.stderr.contains("without --keep"), "{ran:?}");
        assert!(folder.products("packs") == before);
    };
    let unlisted = "packs: --keep needs the report.json of the build that made ggx.brdf.ktx2; restore it";
    let folder = both();
    let report = folder.text("packs/report.json");
    std::fs::remove_file(folder.path().join("packs/report.json")).unwrap();
    refused(&folder, unlisted);
    for damaged in ["", "{}", &report[..report.len() / 2], &report.replace("synth:ggx", "synth:ward")] {
        folder.write("packs/report.json", damaged);
        refused(&folder, unlisted);
    }
    folder.write("packs/report.json", &report);
    keep(&folder).succeeded();
    // Without a store and without a report its list says that a build made it.
    std::fs::remove_dir_all(folder.path().join("packs/.brdfc-cache")).unwrap();
    std::fs::remove_file(folder.path().join("packs/report.json")).unwrap();
    refused(&folder, "packs: --keep needs the report.json of the build that made ggx.json");
    folder.write("packs/report.json", &report);
    // A damaged pack that the store does not have either.
    for damage in [true, false] {
        if damage {
            folder.write("packs/ggx.brdf.ktx2", "damaged");
        } else {
            std::fs::remove_file(folder.path().join("packs/ggx.brdf.ktx2")).unwrap();
        }
        let lost = if damage { "changed since the build" } else { "missing" };
        refused(&folder, &format!("packs/ggx.brdf.ktx2: {lost}, and the store has no copy"));
    }
    // Nothing is to be kept of a folder that has nothing else.
    let folder = Folder::new();
    keep(&folder).succeeded();
    std::fs::remove_file(folder.path().join("packs/report.json")).unwrap();
    keep(&folder).succeeded();
}

/// Two builds at a time: the one that has to wait says so, and the wait is in no material's time.
#[test]
fn a_build_that_waits_says_so() {
    let folder = Folder::new();
    build(&folder, &["synth:ggx"], &["--out", "packs"]).succeeded();
    let lock = std::fs::File::options().write(true).open(folder.path().join("packs/.brdfc-cache/lock")).unwrap();
    lock.lock().unwrap();
    std::thread::scope(|scope| {
        let arguments = ["build", "synth:lambert", "--codec", "table", "--max-bytes", "1KiB", "--out", "packs"];
        let waiting = scope.spawn(move || folder.run(&arguments));
        std::thread::sleep(std::time::Duration::from_secs(6));
        lock.unlock().unwrap();
        let ran = waiting.join().unwrap().succeeded();
        assert!(ran.stderr.starts_with("note: waiting for another brdfc that works in packs\n"), "{ran:?}");
        let done = ran.stderr.lines().find_map(|line| line.strip_prefix("1 of 1: lambert done (")).unwrap();
        let seconds: f64 = done.split(' ').next().unwrap().parse().unwrap();
        assert!(seconds < 5.0, "{ran:?}");
    });
}

/// Links of git-annex or DVC whose files were not fetched are inputs that cannot be read, however they are asked for.
#[test]
#[cfg(unix)]
fn links_that_lead_nowhere_are_errors() {
    let folder = Folder::new();
    folder.write("scans/red.binary", std::fs::read(brdfc_testing::testdata("demo/red_plastic.binary")).unwrap());
    let link = |target: &str, name: &str| std::os::unix::fs::symlink(target, folder.path().join("scans").join(name));
    link("../annex/blue", "blue.binary").unwrap();
    link("../annex/table", "table.csv").unwrap();
    link("ring.brdf", "ring.brdf").unwrap();
    link("nothing", "notes.txt").unwrap();
    link(".", "round").unwrap();
    folder.write("scene.toml", "[materials.all]\nsource='scans/*.b*'\n[[uses]]\nmaterial='all'\n");
    for input in ["scans", "scans/*.{b*,csv}", "**/*.{binary,brdf,csv}", "scene.toml"] {
        let ran = build(&folder, &[input], &["--out", "packs"]);
        assert_eq!((ran.code, packs(&folder, "packs")), (4, vec!["red.brdf.ktx2".to_owned()]), "{input}: {ran:?}");
        let lost = "scans/blue.binary: cannot read: the target of this link does not exist";
        assert!(ran.stderr.contains(lost) && ran.stderr.contains("scans/ring.brdf: cannot read: "), "{ran:?}");
        assert!(ran.stderr.contains("scans/table.csv: cannot read: ") || input == "scene.toml", "{ran:?}");
    }
    let ran = build(&folder, &["scans/*.binary"], &["--out", "packs", "--fail-fast"]);
    assert_eq!((ran.code, packs(&folder, "packs").len()), (4, 1), "{ran:?}");
}

/// Names that are one file on systems that do not tell case, in Unicode's sense of it.
#[test]
fn names_that_are_one_file_elsewhere_are_refused() {
    let folder = Folder::new();
    for [a, b] in [["straße", "STRASSE"], ["ﬁn", "fin"], ["λόγος", "ΛΌΓΟΣ"], ["é", "E\u{301}"]] {
        let material =
            |name: &str| format!("[materials.\"{name}\"]\nsource='synth:ggx'\n[[uses]]\nmaterial='{name}'\n");
        folder.write("scene.toml", material(a) + &material(b));
        let ran = build(&folder, &["scene.toml"], &["--out", "packs"]);
        assert!(ran.code == 3 && ran.stderr.contains(b), "{ran:?}");
    }
    for name in ["con", "COM¹", "lpt².map", "nul .x"] {
        let ran = folder.run(&["flatten", "synth:button", "-o", "out", "--name", name]);
        assert!(ran.code == 2 && ran.stderr.contains("that Windows does not reserve"), "{ran:?}");
    }
    let ran = folder.run(&["flatten", "synth:button", "-o", "con"]);
    assert!(ran.code == 2 && ran.stderr.contains("--out: found \"con\", ") && !folder.path().join("con").exists());
}
