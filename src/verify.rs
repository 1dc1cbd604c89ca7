//! Whether packs, folders of builds and reports are whole: `brdfc verify`.
//!
//! [`Checks::add`] takes paths, [`Checks::run`] reads every file: packs by their checksum and layout, what a `report.json` lists by
//! its hash, figures of a report by the hash of the list that has them as well.

pub use brdfc_jobs::verify::{CheckedFile, Checks};
