//! The program of the studies, run from the command line.

mod bench;
#[cfg(feature = "render")]
mod drawn;
mod pages;
mod usage;

use brdfc_testing::program::Folder;
use brdfc_testing::schema::complaint;
use serde_json::Value;
use std::sync::OnceLock;

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

/// The schema of the studies.
fn schema() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| folder().run(&["--schema"]).succeeded().json())
}

/// Checks that a report conforms to the schema and has no other members.
#[track_caller]
fn conforms(report: &Value) {
    let complaint = complaint(schema(), report);
    assert!(complaint.is_none(), "{}", complaint.unwrap_or_default());
}
