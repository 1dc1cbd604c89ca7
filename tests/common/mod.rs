//! What several integration tests share. Each of them uses only a part.
#![allow(dead_code)]

pub mod cli;
pub mod flat;
pub mod tensor;

use std::path::{Path, PathBuf};

/// A file or folder of the shared measured data: `relative` to the folder that `BRDFC_SHARED` names, or else to
/// `../shared` beside this crate. Prints why a test that needs it is skipped where it is absent.
pub fn shared_data(relative: &str) -> Option<PathBuf> {
    let root = std::env::var_os("BRDFC_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = root.join("data").join(relative);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no {}", path.display());
    None
}

/// The graphics adapter, or why a test that needs one is skipped.
#[cfg(feature = "render")]
pub fn gpu() -> Option<brdfc::render::gpu::Gpu> {
    use brdfc::render::gpu::{AdapterChoice, Gpu};
    match Gpu::open(&AdapterChoice::Best) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            println!("skipped: {error}");
            None
        }
    }
}
