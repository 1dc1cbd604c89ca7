//! How much memory the materials that are worked on may take together.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Of each thread, where nothing is said, bytes.
pub const PER_THREAD: u64 = 300 << 20;
/// Memory for a source of this kind while it is read, evaluated and cross-validated, in sixths of its file's length.
fn sixths(extension: &str) -> u64 {
    match extension {
        // Doubles become floats, next to a map of valid cells.
        "binary" => 4,
        // Rows of few columns with their search trees, three times: the scan and two folds of its cross-validation. Measured:
        // 22 times a file of 300,000 rows.
        "csv" => 144,
        // The same with 31 spectral columns, of which three values are kept. Measured: 3.7 times the file.
        "brdf" => 30,
        // Tensors with their sums.
        _ => 24,
    }
}

/// Memory for a source of this kind and of so many bytes while it is read, evaluated and cross-validated, bytes.
pub fn of_source(extension: &str, length: u64) -> u64 {
    (length / 6).saturating_mul(sixths(extension))
}

/// The longest file of this kind that fits, bytes.
pub fn longest_source(extension: &str, memory: u64) -> u64 {
    memory / sixths(extension) * 6
}

/// How long a thread waits before it looks for parts of loops again.
const MOMENT: Duration = Duration::from_millis(1);

/// Memory that several share.
pub struct Shared {
    all: u64,
    free: Mutex<u64>,
    freed: Condvar,
}

/// A share of it, given back at the end.
pub struct Share<'a> {
    of: &'a Shared,
    bytes: u64,
}

impl Shared {
    /// So many bytes.
    pub fn new(all: u64) -> Self {
        Self { all, free: Mutex::new(all), freed: Condvar::new() }
    }

    /// Waits until there are so many bytes; who wants more than there are works alone. A thread of a pool does parts of the
    /// pool's loops meanwhile.
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

    /// On the threads of a pool, too, where who waits does parts of the loop of who works.
    #[test]
    fn who_waits_in_a_pool_goes_on_when_there_is_enough() {
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
        for extension in ["binary", "brdf", "csv", "bsdf"] {
            let longest = longest_source(extension, 600 << 20);
            assert!(of_source(extension, longest) <= 600 << 20);
            assert!(of_source(extension, 2 * longest) > 600 << 20);
        }
        assert!(of_source("binary", 34_992_012) < 24 << 20);
    }
}
