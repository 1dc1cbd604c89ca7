//! `brdfc watch`.

use super::schemas::conforms;
use crate::common::cli::Folder;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Limit of the time of anything here.
const PATIENCE: Duration = Duration::from_secs(120);

const SCENE: &str = "\
[scene]
environment = 'sky.hdr'
[defaults]
grid = 4
[materials.model]
source = 'synth:ward?kd=0.2,0.1,0.1'
ratio = 2
[materials.scan]
source = 'data/scan.binary'
[materials.all]
source = 'more/*.binary'
[[uses]]
maps = ['bandwidth', 'samples']
material = 'model'
[[uses]]
maps = ['bandwidth', 'samples']
material = 'scan'
[[uses]]
maps = ['bandwidth', 'samples']
material = 'all'
";

fn scan(folder: &Folder, file: &str, model: &str) {
    let path = folder.path().join(file);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    folder.run(&["synth", model, "-o", file, "--dimensions", "6x6x12"]).succeeded();
}

fn sky(folder: &Folder, brightness: f32) {
    let image = image::Rgb32FImage::from_fn(32, 16, |x, _| image::Rgb([0.1 + 0.01 * x as f32, 1.0, brightness]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::DynamicImage::ImageRgb32F(image).write_to(&mut bytes, image::ImageFormat::Hdr).unwrap();
    replace(folder, "sky.hdr", bytes.get_ref());
}

fn folder() -> Folder {
    let folder = Folder::new();
    scan(&folder, "data/scan.binary", "lewis?n=20");
    scan(&folder, "more/one.binary", "lambert?kd=0.3");
    sky(&folder, 1.0);
    folder.write("scene.toml", SCENE);
    folder
}

/// A running `brdfc watch` and its output.
struct Watch<'a> {
    child: Child,
    lines: Receiver<String>,
    reports: Receiver<String>,
    folder: &'a Folder,
}

fn lines_of(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines() {
            let Ok(line) = line else { return };
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

impl<'a> Watch<'a> {
    fn new(folder: &'a Folder, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_brdfc"))
            .arg("watch")
            .args(arguments)
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (lines, reports) = (lines_of(child.stderr.take().unwrap()), lines_of(child.stdout.take().unwrap()));
        Self { child, lines, reports, folder }
    }

    /// Lines of stderr up to and including the first that contains these words.
    #[track_caller]
    fn until(&self, words: &str) -> Vec<String> {
        let (mut lines, started) = (Vec::new(), Instant::now());
        loop {
            let left = PATIENCE.saturating_sub(started.elapsed());
            let line =
                self.lines.recv_timeout(left).unwrap_or_else(|error| panic!("no {words:?} ({error}): {lines:?}"));
            lines.push(line);
            if lines.last().unwrap().contains(words) {
                return lines;
            }
        }
    }

    /// Waits for the build after a change of this file, and compares its folder with the result of `build`.
    #[track_caller]
    fn built(&self, change: &str) -> String {
        let line = self.until(change).pop().unwrap();
        self.folder.run(&["build", "scene.toml", "--out", "fresh", "--quiet"]).succeeded();
        assert!(self.folder.products("packs") == self.folder.products("fresh"), "{line}");
        line
    }

    fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap().success());
    }

    /// Waits for its exit code.
    #[track_caller]
    fn interrupted(mut self) -> i32 {
        self.signal("-INT");
        let started = Instant::now();
        while started.elapsed() < PATIENCE {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code().unwrap();
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("it goes on after an interrupt");
    }
}

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Replaces a file atomically, as editors do.
fn replace(folder: &Folder, file: &str, bytes: impl AsRef<[u8]>) {
    let aside = folder.write("aside.tmp", bytes);
    std::fs::rename(aside, folder.path().join(file)).unwrap();
}

#[test]
fn all_inputs_of_a_build_are_watched() {
    let folder = folder();
    // Without events, too.
    for arguments in [&["scene.toml"][..], &["scene.toml", "--poll", "0.2"]] {
        let _ = std::fs::remove_dir_all(folder.path().join("packs"));
        let _ = std::fs::remove_file(folder.path().join("more/two.binary"));
        folder.write("scene.toml", SCENE);
        let watch = Watch::new(&folder, arguments);
        let line = watch.built("first build: ");
        assert!(line.contains("4 built, 0 cached"), "{line}");
        let first = folder.products("packs");
        assert_eq!(watch.until("watching "), ["watching 4 files; press Ctrl-C to stop"]);

        replace(&folder, "scene.toml", SCENE.replace("ratio = 2", "ratio = 4"));
        let line = watch.built("scene.toml changed: ");
        assert!(line.contains("1 built, 3 cached, 3 files written"), "{line}");
        let changed: Vec<_> = differing(&first, &folder.products("packs"));
        assert_eq!(changed, ["model.brdf.ktx2", "model.json", "report.json"]);

        // A file of that pattern; a source that is replaced; one that is overwritten in place.
        scan(&folder, "more/two.binary", "lambert?kd=0.5");
        watch.built("more/two.binary new: ");
        scan(&folder, "new.binary", &format!("lewis?n={}", 20 + arguments.len()));
        replace(&folder, "data/scan.binary", folder.read("new.binary"));
        let line = watch.built("data/scan.binary changed: ");
        assert!(line.contains("1 built, 4 cached"), "{line}");
        sky(&folder, 2.0 + arguments.len() as f32);
        watch.built("sky.hdr changed: ");
        std::fs::remove_file(folder.path().join("more/two.binary")).unwrap();
        let line = watch.built("more/two.binary gone: ");
        assert!(line.contains("files removed"), "{line}");
        assert_eq!(watch.interrupted(), 0);
    }
}

fn differing(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    b.iter().filter(|(name, bytes)| a.get(*name) != Some(bytes)).map(|(name, _)| name.clone()).collect()
}

#[test]
fn failures_are_reported_and_the_packs_stay() {
    let folder = folder();
    let watch = Watch::new(&folder, &["scene.toml"]);
    watch.until("watching ");
    let good = folder.products("packs");
    for (file, broken, words) in [
        ("scene.toml", &b"[materials"[..], "brdfc: scene.toml: line 1"),
        ("scene.toml", b"[materials.model]\nsource = 'synth:ward'\n", "brdfc: scene.toml: nothing to build"),
        ("data/scan.binary", b"no scan", "brdfc: 1 of 3 materials failed"),
    ] {
        let whole = folder.read(file);
        replace(&folder, file, broken);
        let lines = watch.until(&format!("{file} changed: "));
        assert!(lines.iter().any(|line| line.contains(words)), "{lines:?}");
        assert!(lines.last().unwrap().contains("the output folder is unchanged"), "{lines:?}");
        assert!(folder.products("packs") == good);
        replace(&folder, file, whole);
        watch.built(&format!("{file} changed: "));
    }
    // A source that is missing for a while.
    let source = folder.path().join("data");
    std::fs::rename(&source, folder.path().join("elsewhere")).unwrap();
    let lines = watch.until("data/scan.binary gone: ");
    assert!(lines.iter().any(|line| line.contains("data/scan.binary: cannot read")), "{lines:?}");
    assert!(lines.last().unwrap().contains("3 cached, 1 failed") && folder.products("packs") == good, "{lines:?}");
    std::fs::rename(folder.path().join("elsewhere"), &source).unwrap();
    watch.built("data/scan.binary new: ");
    assert_eq!(watch.interrupted(), 0);
}

#[test]
fn a_scene_that_is_wrong_at_first_is_waited_for_and_wrong_usage_is_not() {
    let folder = folder();
    folder.write("scene.toml", SCENE.replace("[[uses]]", "[[used]]"));
    let watch = Watch::new(&folder, &["scene.toml"]);
    let lines = watch.until("watching ");
    assert!(lines[0].contains("\"used\"") && lines[1].starts_with("first build: failed"), "{lines:?}");
    replace(&folder, "scene.toml", SCENE);
    watch.built("scene.toml changed: ");
    drop(watch);
    for (arguments, code, words) in [
        (&["gone.toml"][..], 4, "gone.toml: cannot read"),
        (&["scene.toml", "--out", "-"], 2, "-: not a folder; for a folder of this name, write ./-"),
        (&["scene.toml", "--out", "scene.toml"], 4, "scene.toml: cannot write: not a folder"),
        (&["scene.toml", "--poll", "0"], 2, "--poll: found 0, expected 0.1 to 3600 seconds"),
        (&["scene.toml", "--poll", "1e99"], 2, "--poll: found 1e99, expected 0.1 to 3600 seconds"),
        (&["scene.toml", "--memory", "1MiB"], 2, "--memory: found 1MiB, expected 64MiB or more, such as 512MiB"),
        (&["-"], 2, "inputs: builds do not read stdin, only commands with one input do"),
        (&["scene.toml", "scene.toml"], 2, "expected one manifest"),
    ] {
        let ran = folder.run(&[&["watch"], arguments].concat());
        assert_eq!(ran.code, code, "{}", ran.stderr);
        assert!(ran.stderr.contains(words), "{}", ran.stderr);
    }
}

/// Notes concern newly built materials; for cached ones there is a count, once.
#[test]
fn notes_of_cached_materials_are_counted() {
    let folder = Folder::new();
    scan(&folder, "dark.binary", "lambert?kd=0");
    scan(&folder, "black.binary", "lambert?kd=0");
    let black = "the material is black at all test directions";
    let first = Watch::new(&folder, &["dark.binary", "black.binary", "--codec", "table"]);
    let lines = first.until("watching ");
    assert_eq!(lines.iter().filter(|line| line.contains(black)).count(), 2, "{lines:?}");
    drop(first);
    let second = Watch::new(&folder, &["dark.binary", "black.binary", "--codec", "table"]);
    let lines = second.until("watching ");
    assert!(!lines.iter().any(|line| line.contains(black)), "{lines:?}");
    let count = "note: 2 materials from the cache have notes; 'brdfc report' lists them";
    assert!(lines.iter().any(|line| line == count), "{lines:?}");
    // A different black.
    folder.run(&["synth", "lambert?kd=0", "-o", "new.binary", "--dimensions", "6x6x14"]).succeeded();
    replace(&folder, "dark.binary", folder.read("new.binary"));
    let lines = second.until("dark.binary changed: ");
    let notes: Vec<&String> = lines.iter().filter(|line| line.starts_with("note: ")).collect();
    assert!(!notes.is_empty() && notes.iter().all(|note| note.starts_with("note: dark: ")), "{lines:?}");
}

#[test]
fn reports_are_lines_of_json() {
    let folder = folder();
    let watch = Watch::new(&folder, &["scene.toml", "--json", "--quiet"]);
    let report = || -> Value {
        let line = watch.reports.recv_timeout(PATIENCE).unwrap();
        let report = serde_json::from_str(&line).unwrap();
        conforms("watch", &report);
        report
    };
    let first = report();
    conforms("build", &first["build"]);
    assert!(first["changed"].as_array().unwrap().is_empty() && first["written"].as_array().unwrap().len() == 14);
    replace(&folder, "scene.toml", "[materials");
    let broken = report();
    assert_eq!(broken["changed"], serde_json::json!([{ "file": "scene.toml", "what": "changed" }]));
    assert!(broken["error"].as_str().unwrap().contains("scene.toml: line 1") && broken.get("build").is_none());
    replace(&folder, "scene.toml", SCENE);
    assert!(report().get("error").is_none());
}

/// Folders and patterns of files need no manifest, and files that the build writes are not new files.
#[test]
fn new_files_of_a_folder_and_of_a_pattern_are_built() {
    let folder = Folder::new();
    scan(&folder, "scans/one.binary", "lambert?kd=0.3");
    for input in ["scans", "*/*.*[y2]"] {
        let watch = Watch::new(&folder, &[input, "--max-bytes", "1KiB", "--quiet", "--json"]);
        let changed = || -> Value {
            let line = watch.reports.recv_timeout(PATIENCE).unwrap();
            serde_json::from_str::<Value>(&line).unwrap()["changed"].clone()
        };
        assert_eq!(changed(), serde_json::json!([]));
        scan(&folder, "scans/two.binary", "lambert?kd=0.5");
        assert_eq!(changed(), serde_json::json!([{ "file": "scans/two.binary", "what": "new" }]), "{input}");
        assert!(watch.reports.recv_timeout(Duration::from_millis(600)).is_err(), "{input}: no build of its own packs");
        std::fs::remove_file(folder.path().join("scans/two.binary")).unwrap();
        std::fs::remove_dir_all(folder.path().join("packs")).unwrap();
    }
}

/// Cancels the running build, and starts again with the current files.
#[test]
fn a_change_in_the_middle_of_a_build_begins_it_again() {
    let folder = Folder::new();
    // One of minutes, and one of a moment.
    let material = |k: usize, grid: usize| {
        format!(
            "[materials.m{k}]\nsource = 'synth:ggx?alpha=0.{k}'\ngrid = {grid}\nratio = 4\n[[uses]]\nmaterial = 'm{k}'\n"
        )
    };
    let long = |first: usize| (first..first + 400).map(|k| material(k, 64)).collect::<String>();
    folder.write("scene.toml", long(100));
    let watch = Watch::new(&folder, &["scene.toml"]);
    let store = folder.path().join("packs/.brdfc-cache/entries");
    let started = Instant::now();
    while std::fs::read_dir(&store).map_or(0, Iterator::count) == 0 {
        assert!(started.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(10));
    }
    folder.write("scene.toml", material(1, 4));
    let line = watch.built("first build: ");
    assert!(line.contains("1 built, 0 cached"), "{line}");

    // An interrupt in the middle of a build has the same effect as for `build`.
    folder.write("scene.toml", long(500));
    let before = folder.products("packs");
    let known = std::fs::read_dir(&store).unwrap().count();
    let started = Instant::now();
    while std::fs::read_dir(&store).unwrap().count() == known {
        assert!(started.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(watch.interrupted(), 130);
    assert!(folder.products("packs") == before);
}
