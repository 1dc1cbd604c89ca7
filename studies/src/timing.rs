//! Timing of functions.

use std::hint::black_box;
use std::time::Instant;

/// Seconds of the fastest of `runs` runs.
pub(crate) fn best_of<T>(runs: usize, run: impl Fn() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        black_box(run());
        start.elapsed().as_secs_f64()
    };
    (0..runs).map(time).fold(f64::INFINITY, f64::min)
}
