//! Integrity of packs, folders of builds and reports: `brdfc verify`.
//!
//! [`Checks::add`] takes paths, and [`Checks::run`] reads every file. It checks packs by their checksum and layout,
//! files of a `report.json` by their hashes, and figures of a `MATERIAL.json` against `report.json`.

pub use brdfc_jobs::verify::{CheckedFile, Checks};
