//! Number of external crates that the default build compiles: each one costs every person who builds the program.

use std::collections::BTreeSet;
use std::process::Command;

/// External crates of the default build on Linux, including those that build scripts and macros need.
const CRATES: usize = 189;

#[test]
fn the_default_build_has_no_more_crates() {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--offline", "--package", "brdfc", "--edges", "normal,build", "--prefix", "none"])
        .args(["--target", "x86_64-unknown-linux-gnu", "--format", "{p}", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    // Name and version, without the rest of the line; our own crates have a path.
    let name = |line: &str| line.split(' ').take(2).collect::<Vec<_>>().join(" ");
    let is_ours = |line: &&str| line.contains(&format!("({}", env!("CARGO_MANIFEST_DIR")));
    let (ours, others): (Vec<&str>, Vec<&str>) = printed.lines().filter(|line| !line.is_empty()).partition(is_ours);
    assert!(ours.iter().any(|line| line.starts_with("brdfc v")) && ours.iter().all(|line| line.starts_with("brdfc")));
    let crates: BTreeSet<String> = others.into_iter().map(name).collect();
    assert!(
        crates.len() <= CRATES,
        "the default build has {} crates of others, not {CRATES}. 'git diff Cargo.lock' and 'cargo tree --invert NAME' show what came and \
         why. Does it cost less than writing what is used of it ('cargo build --release --timings')? Turn its default features \
         off, make it a dependency of tests, or leave it out. Where it is worth it, raise CRATES in this file, and say why in \
         the commit.",
        crates.len()
    );
    assert_eq!(crates.len(), CRATES, "fewer crates than there were: lower CRATES in this file, so that they stay away");
}
