//! Helpers that several tests share.

pub mod cli;

pub use brdfc_testing::{shared_data, tensor};

/// Returns true if there is a graphics adapter; otherwise prints why a test is skipped.
#[cfg(feature = "render")]
pub fn has_adapter() -> bool {
    use brdfc_gpu::{AdapterChoice, Gpu};
    static FOUND: std::sync::OnceLock<Result<(), String>> = std::sync::OnceLock::new();
    let found = FOUND.get_or_init(|| Gpu::open(&AdapterChoice::Best).map(drop).map_err(|error| error.to_string()));
    found.as_ref().map_err(|error| println!("skipped: {error}")).is_ok()
}
