//! Helpers for several tests.

pub mod flat;

use brdfc_gpu::{AdapterChoice, Gpu};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of opened devices, since a software driver compiles for one device in a single thread.
const DEVICES: usize = 2;

/// A graphics device, always the same for a test. Prints the reason and returns `None` if there is none.
pub fn gpu() -> Option<&'static Gpu> {
    static OPENED: [OnceLock<Result<Gpu, String>>; DEVICES] = [const { OnceLock::new() }; DEVICES];
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    // Each test has a thread of its own.
    thread_local!(static MINE: usize = NEXT.fetch_add(1, Ordering::Relaxed) % DEVICES);
    let opened = &OPENED[MINE.with(|mine| *mine)];
    let opened = opened.get_or_init(|| Gpu::open(&AdapterChoice::Best).map_err(|error| error.to_string()));
    opened.as_ref().map_err(|error| println!("skipped: {error}")).ok()
}
