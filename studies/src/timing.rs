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

/// Seconds of the fastest of `runs` runs. One run before does not count, because drivers compile shaders then.
///
/// # Errors
/// Returns the first error of `run`.
#[cfg(feature = "render")]
pub(crate) fn fastest<T, E>(runs: usize, run: impl Fn() -> Result<T, E>) -> Result<f64, E> {
    run()?;
    let mut seconds = f64::INFINITY;
    for _ in 0..runs {
        let started = Instant::now();
        run()?;
        seconds = seconds.min(started.elapsed().as_secs_f64());
    }
    Ok(seconds)
}
