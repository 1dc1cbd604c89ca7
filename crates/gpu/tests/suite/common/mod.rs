//! What several tests share.

pub mod flat;

use brdfc_gpu::{AdapterChoice, Gpu};
use std::sync::OnceLock;

/// The graphics adapter, one for all tests, or nothing and the reason why a test is skipped.
pub fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Result<Gpu, String>> = OnceLock::new();
    let opened = GPU.get_or_init(|| Gpu::open(&AdapterChoice::Best).map_err(|error| error.to_string()));
    opened.as_ref().map_err(|error| println!("skipped: {error}")).ok()
}
