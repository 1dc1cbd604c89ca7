//! Cache of samples that an earlier encoding made.

use brdfc_core::Tally;

/// Cache of a source's samples, which are most expensive for scans. `()` caches nothing.
pub trait GridCache {
    /// Bytes stored under this name, with the repairs that they include.
    fn take(&self, name: &str) -> Option<(Vec<u8>, Tally)>;

    /// Stores bytes. `values` runs only if the cache stores its result. Failures are ignored: the next encoding samples
    /// the source again.
    fn put(&self, name: &str, values: &dyn Fn() -> Vec<u8>, tally: &Tally);
}

impl GridCache for () {
    fn take(&self, _: &str) -> Option<(Vec<u8>, Tally)> {
        None
    }

    fn put(&self, _: &str, _: &dyn Fn() -> Vec<u8>, _: &Tally) {}
}
