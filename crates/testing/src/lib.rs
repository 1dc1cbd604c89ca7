//! Inputs and checks shared by the tests of several crates: synthetic data, the laws of reflectance, and the folder of
//! measured data.
#![allow(missing_docs)]

pub mod browser;
pub mod checks;
pub mod codec;
pub mod codecs;
pub mod engines;
pub mod golden;
pub mod gradient;
pub mod packs;
pub mod pages;
pub mod program;
pub mod sampler;
#[cfg(feature = "schema")]
pub mod schema;
pub mod tensor;
pub mod viewer_files;
pub mod wrapped;

use std::path::{Path, PathBuf};

/// Path of the repository.
pub fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// A file of `testdata/`.
pub fn testdata(relative: &str) -> String {
    repository().join("testdata").join(relative).display().to_string()
}

/// A file or folder of the measured data, in the folder of `BRDFC_SHARED` or else in `../shared` next to the
/// repository. If it is missing, prints that the test is skipped and returns `None`.
pub fn shared_data(relative: &str) -> Option<PathBuf> {
    let root = std::env::var_os("BRDFC_SHARED").map_or_else(|| repository().join("../shared"), PathBuf::from);
    let path = root.join("data").join(relative);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no {}", path.display());
    None
}
