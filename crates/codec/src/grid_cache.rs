//! Samples of a source that an earlier encoding made.

use brdfc_core::Tally;

/// A cache of what codecs sample of one source, which costs most where the source is a scan. `()` caches nothing.
pub trait GridCache {
    /// Bytes that were put under this name, and what was repaired in them.
    fn take(&self, name: &str) -> Option<(Vec<u8>, Tally)>;

    /// Stores bytes, which are made only by a cache that stores them. Failing to is no error: they are sampled again.
    fn put(&self, name: &str, values: &dyn Fn() -> Vec<u8>, tally: &Tally);
}

impl GridCache for () {
    fn take(&self, _: &str) -> Option<(Vec<u8>, Tally)> {
        None
    }

    fn put(&self, _: &str, _: &dyn Fn() -> Vec<u8>, _: &Tally) {}
}
