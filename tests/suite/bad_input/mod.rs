//! Invalid inputs of the real program: each error states the file, the place, what is wrong and what is valid, and
//! nothing is written.

mod disk;
mod files;
mod interrupt;
mod large;
#[cfg(target_os = "linux")]
mod last_write;
mod lights;
mod manifest;
mod meso;
mod options;
mod packs;
mod scans;

use crate::common::cli::{Folder, states_what_is_expected};

/// Runs the program, checks the common properties of errors, and returns the message.
#[track_caller]
fn refused(folder: &Folder, arguments: &[&str], code: i32, expected: &[&str]) -> String {
    let before = folder.files(".");
    let ran = folder.run(arguments);
    assert_eq!((ran.code, ran.stdout.as_str()), (code, ""), "{arguments:?}: {}", ran.stderr);
    for words in expected {
        assert!(ran.stderr.contains(words), "{arguments:?}: no \"{words}\" in: {}", ran.stderr);
    }
    for words in ["panicked", "internal error", "RUST_BACKTRACE"] {
        assert!(!ran.stderr.contains(words), "{arguments:?}: {}", ran.stderr);
    }
    assert!(ran.stderr.len() < 2000 && !ran.stderr.chars().any(|c| c.is_control() && c != '\n'), "{}", ran.stderr);
    let after = folder.files(".");
    assert!(after == before, "{arguments:?} wrote: {:?}", after.keys());
    ran.stderr
}

/// Rejected as a file by every command that opens one, with exit code 3.
#[track_caller]
fn bad_file(name: &str, bytes: &[u8], expected: &[&str]) {
    let folder = Folder::new();
    folder.write(name, bytes);
    let start = format!("brdfc: {name}: ");
    let all = [&[start.as_str()], expected].concat();
    let message = refused(&folder, &["info", name], 3, &all);
    assert!(message.lines().count() == 1 && states_what_is_expected(&message), "{message}");
    assert_eq!(refused(&folder, &["encode", name, "-o", "pack.ktx2", "--grid", "2"], 3, &all), message);
}

/// Accepted; returns what `info` prints.
#[track_caller]
fn accepted(name: &str, bytes: &[u8]) -> serde_json::Value {
    let folder = Folder::new();
    folder.write(name, bytes);
    folder.run(&["encode", name, "-o", "pack.ktx2", "--grid", "2"]).succeeded();
    folder.run(&["info", name, "--json"]).succeeded().json()
}
