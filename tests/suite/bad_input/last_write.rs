//! Programs that are killed at each call that changes a file, or find the disk full from there on; `last_write.c`, preloaded,
//! counts the calls. Afterwards everything is unchanged, or the next run completes the work.

use crate::common::cli::Folder;
use brdfc_jobs::btf_stack::StackFormat;
use brdfc_jobs::rti_capture::write_rti_capture;
use brdfc_pwt::ptm::spread_lights;
use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Upper and lower limit of the number of calls of any of these runs.
const MAX_CALLS: usize = 400;
const MIN_CALLS: usize = 2;

type Files = BTreeMap<String, Vec<u8>>;

/// The preloaded library; `None` without a compiler.
fn library(folder: &Folder) -> Option<PathBuf> {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/bad_input/last_write.c");
    let library = folder.path().join("last_write.so");
    let compiled = Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).args([source, "-ldl"]).status();
    match compiled {
        Ok(status) => {
            assert!(status.success());
            Some(library)
        }
        Err(error) => {
            println!("skipped: cc: {error}");
            None
        }
    }
}

/// A program that is stopped at each of its calls in turn. `reset` restores the folder, and `files` lists the files that the program
/// changes, before it and after an uninterrupted run.
struct Stopped<'a> {
    folder: &'a Folder,
    arguments: &'a [&'a str],
    reset: &'a dyn Fn(),
    files: &'a dyn Fn() -> Files,
}

impl Stopped<'_> {
    /// Runs the program until it is stopped at a call; returns how it ended.
    fn run(&self, call: usize, how: &str, library: &Path) -> Output {
        (self.reset)();
        let mut program = Command::new(env!("CARGO_BIN_EXE_brdfc"));
        program.args(self.arguments).args(["--jobs", "1"]).current_dir(self.folder.path()).stdin(Stdio::null());
        program.env("LD_PRELOAD", library).env("LAST_WRITE", call.to_string()).env("LAST_WRITE_HOW", how);
        program.output().unwrap()
    }

    fn is_never_half_done(&self) {
        let Some(library) = library(self.folder) else { return };
        (self.reset)();
        let before = (self.files)();
        self.folder.run(self.arguments).succeeded();
        let after = (self.files)();
        assert!(before != after);
        let goes_on = |call: usize| {
            self.folder.run(self.arguments).succeeded();
            assert!((self.files)() == after, "call {call}: {:?}", (self.files)().keys());
        };
        let killed = |call: &usize| {
            let is_killed = self.run(*call, "kill", &library).status.signal() == Some(9);
            goes_on(*call);
            is_killed
        };
        let calls = (1..MAX_CALLS).take_while(killed).count();
        println!("{}: {calls} calls", self.arguments.join(" "));
        assert!((MIN_CALLS..MAX_CALLS - 1).contains(&calls), "{calls}");
        for call in 1..=calls {
            let run = self.run(call, "full", &library);
            let (message, found) = (String::from_utf8_lossy(&run.stderr), (self.files)());
            // A cache that cannot store its entry is not a failure.
            let is_right = match run.status.code() {
                Some(0) => found == after,
                Some(4) => found == before && message.contains("No space left on device"),
                _ => false,
            };
            assert!(is_right, "call {call}: {:?}: {message}", found.keys());
            goes_on(call);
        }
    }
}

#[test]
fn builds_that_are_stopped_at_any_call() {
    let folder = Folder::new();
    let scene = |names: [&str; 2]| -> String {
        let material = |name: &str| {
            format!(
                "[materials.{name}]\nsource = 'synth:lambert?kd=0.{}'\ncodec = 'table'\nmax_bytes = 256\n\
                 [[uses]]\nmaterial = '{name}'\n",
                name.len()
            )
        };
        names.map(material).concat()
    };
    folder.write("old.toml", scene(["a", "bb"]).replace("256", "512"));
    folder.write("new.toml", scene(["a", "ccc"]));
    folder.run(&["build", "old.toml", "--out", "old", "--quiet"]).succeeded();
    let reset = || {
        let _ = std::fs::remove_dir_all(folder.path().join("packs"));
        for (name, bytes) in folder.files("old") {
            folder.write(&format!("packs/{name}"), bytes);
        }
    };
    let arguments = ["build", "new.toml", "--out", "packs", "--quiet"];
    Stopped { folder: &folder, arguments: &arguments, reset: &reset, files: &|| folder.products("packs") }
        .is_never_half_done();
}

#[test]
fn flattenings_that_are_stopped_at_any_call() {
    let folder = Folder::new();
    let arguments = [
        "flatten",
        "synth:button?resolution=16",
        "--texels",
        "16",
        "--views",
        "grid:2x4@50",
        "--lights",
        "grid:2x4@50",
        "--reflectance",
        "factors",
        "--out",
        "flat",
        "--quiet",
    ];
    let reset = || {
        let _ = std::fs::remove_dir_all(folder.path().join("flat"));
        folder.write("flat/flat.ktx2", "of an earlier run");
    };
    // A folder without a lock is considered new, and is cleaned up after a while.
    let files = || folder.files("flat").into_iter().filter(|(name, _)| !name.starts_with(".brdfc-")).collect();
    Stopped { folder: &folder, arguments: &arguments, reset: &reset, files: &files }.is_never_half_done();
}

#[test]
fn packs_of_photographs_that_are_stopped_at_any_call() {
    let folder = Folder::new();
    let lights = spread_lights(12);
    let shaded = |light: usize| (0..64).map(|texel| [lights[light][2] * texel as f32 / 64.0; 3]).collect();
    write_rti_capture(&folder.path().join("stack"), &lights, [8, 8], StackFormat::Png, shaded).unwrap();
    let reset = || {
        let _ = std::fs::remove_dir_all(folder.path().join("made"));
        folder.write("made/stack.ktx2", "of an earlier run");
    };
    // The remains of a killed run have a name of their own.
    let files = || folder.files("made").into_iter().filter(|(name, _)| !name.starts_with(".brdfc-")).collect();
    let arguments = ["pwt", "stack", "-o", "made/stack.ktx2", "--quiet"];
    Stopped { folder: &folder, arguments: &arguments, reset: &reset, files: &files }.is_never_half_done();
}
