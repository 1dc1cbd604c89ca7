//! Memory limit of the jobs that run at a time.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Default memory limit per thread, bytes.
pub const PER_THREAD: u64 = 300 << 20;

/// Memory to fit lobes: the environments of the fit and of its error, decoded. Measured: 50 MiB.
pub const LOBES: u64 = 64 << 20;

/// Memory to read, evaluate and cross-validate a source of this kind, in sixths of the length of its file.
fn sixths(extension: &str) -> u64 {
    match extension {
        // Doubles become floats, next to a map of valid cells.
        "binary" => 4,
        // Rows of few columns with their search trees, three times: the scan and two folds of its cross-validation. Measured:
        // 22 times a file of 300,000 rows.
        "csv" => 144,
        // The same with 31 spectral columns, of which three values are stored. Measured: 3.7 times the file.
        "brdf" => 30,
        // Tensors with their sums.
        _ => 24,
    }
}

/// Memory to smooth a table, in sixths of the length of its file: logarithms, fits and changes as doubles. Measured: 5 times a
/// file of doubles (MERL).
fn sixths_to_smooth(extension: &str) -> u64 {
    match extension {
        "binary" => 30,
        "bsdf" => 60,
        _ => 0,
    }
}

/// Memory to read, evaluate and cross-validate a source of this kind and length, and to smooth it, bytes.
pub fn of_source(extension: &str, length: u64, smoothed: bool) -> u64 {
    let to_smooth = if smoothed { sixths_to_smooth(extension) } else { 0 };
    (length / 6).saturating_mul(sixths(extension) + to_smooth)
}

/// Length of the longest file of this kind that fits into `memory`, bytes.
pub fn longest_source(extension: &str, memory: u64) -> u64 {
    match extension {
        // What reading takes. A large scan then has the whole limit, and may exceed it while it is cross-validated.
        "csv" => memory / 8,
        _ => memory / sixths(extension) * 6,
    }
}

/// Time that a thread waits before it looks for other work in the pool again.
const MOMENT: Duration = Duration::from_millis(1);

/// A memory limit that several jobs share.
pub struct Shared {
    all: u64,
    free: Mutex<u64>,
    freed: Condvar,
}

/// A share of the memory, returned on drop.
pub struct Share<'a> {
    of: &'a Shared,
    bytes: u64,
}

impl Shared {
    /// Creates a limit of `all` bytes.
    pub fn new(all: u64) -> Self {
        Self { all, free: Mutex::new(all), freed: Condvar::new() }
    }

    /// Waits until `bytes` bytes are free. A job that needs more than the whole limit runs alone. A thread of a pool
    /// runs other tasks of the pool while it waits.
    pub fn take(&self, bytes: u64) -> Share<'_> {
        let bytes = bytes.min(self.all);
        loop {
            let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            if *free >= bytes {
                *free -= bytes;
                return Share { of: self, bytes };
            }
            drop(free);
            if rayon::yield_now() != Some(rayon::Yield::Executed) {
                let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
                drop(self.freed.wait_timeout_while(free, MOMENT, |free| *free < bytes));
            }
        }
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        *self.of.free.lock().unwrap_or_else(PoisonError::into_inner) += self.bytes;
        self.of.freed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn no_more_is_taken_than_there_is() {
        let shared = Shared::new(10);
        let (taken, most) = (AtomicU64::new(0), AtomicU64::new(0));
        std::thread::scope(|scope| {
            for bytes in [4, 4, 4, 9, 100, 1, 3] {
                let (shared, taken, most) = (&shared, &taken, &most);
                scope.spawn(move || {
                    let share = shared.take(bytes);
                    most.fetch_max(taken.fetch_add(share.bytes, Ordering::SeqCst) + share.bytes, Ordering::SeqCst);
                    std::thread::yield_now();
                    taken.fetch_sub(share.bytes, Ordering::SeqCst);
                });
            }
        });
        assert!((9..=10).contains(&most.into_inner()));
    }

    /// A waiting thread of a pool runs parts of the loop of the working thread.
    #[test]
    fn a_waiting_thread_of_a_pool_continues_when_memory_is_free() {
        use rayon::prelude::*;
        let shared = Shared::new(10);
        let done = AtomicU64::new(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        pool.broadcast(|_| {
            for _ in 0..20 {
                let _share = shared.take(10);
                (0..64).into_par_iter().for_each(|_| {
                    done.fetch_add(1, Ordering::SeqCst);
                });
            }
        });
        assert_eq!(done.into_inner(), 3 * 20 * 64);
    }

    #[test]
    fn the_longest_source_fits() {
        for extension in ["binary", "brdf", "bsdf"] {
            let longest = longest_source(extension, 600 << 20);
            assert!(of_source(extension, longest, false) <= 600 << 20);
            assert!(of_source(extension, 2 * longest, false) > 600 << 20);
        }
        assert!(of_source("binary", 34_992_012, false) < 24 << 20);
        assert!((157..200).contains(&(of_source("binary", 34_992_012, true) >> 20)));
    }
}
