//! The program of the studies, run from the command line.

mod bench;
#[cfg(feature = "render")]
mod drawn;
mod pages;
mod usage;

use brdfc_testing::program::Folder;
use brdfc_testing::repository;
use brdfc_testing::schema::complaint;
use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_brdfc-bench");

/// A folder for runs of `brdfc-bench`.
fn folder() -> Folder {
    Folder::of(PROGRAM)
}

/// Returns true if there is a graphics adapter. Otherwise prints why a test is skipped.
#[cfg(feature = "render")]
fn has_adapter() -> bool {
    use brdfc_gpu::{AdapterChoice, Gpu};
    let found = Gpu::open(&AdapterChoice::Best);
    found.as_ref().map_err(|error| println!("skipped: {error}")).is_ok()
}

/// Checks that a report conforms to `studies/schema.json` and has no other members.
#[track_caller]
fn conforms(report: &Value) {
    let text = std::fs::read_to_string(repository().join("studies/schema.json")).unwrap();
    let complaint = complaint(&serde_json::from_str(&text).unwrap(), report);
    assert!(complaint.is_none(), "{}", complaint.unwrap_or_default());
}
