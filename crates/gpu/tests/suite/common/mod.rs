//! What several tests share.

pub mod flat;

use brdfc_gpu::{AdapterChoice, Gpu};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Devices that are opened: what a software driver compiles for one goes through one thread.
const DEVICES: usize = 2;

/// A graphics device, of each test the same, or nothing and the reason why a test is skipped.
pub fn gpu() -> Option<&'static Gpu> {
    static OPENED: [OnceLock<Result<Gpu, String>>; DEVICES] = [const { OnceLock::new() }; DEVICES];
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    // Each test has a thread of its own.
    thread_local!(static MINE: usize = NEXT.fetch_add(1, Ordering::Relaxed) % DEVICES);
    let opened = &OPENED[MINE.with(|mine| *mine)];
    let opened = opened.get_or_init(|| Gpu::open(&AdapterChoice::Best).map_err(|error| error.to_string()));
    opened.as_ref().map_err(|error| println!("skipped: {error}")).ok()
}
