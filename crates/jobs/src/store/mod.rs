//! Cache of build results, keyed by their inputs.
//!
//! The cache is the folder `.brdfc-cache` next to the packs. The key of an entry is a hash of the bytes of the
//! source, the resolved recipe and the encoders; the name of a file is the hash of its bytes. Entries that are
//! damaged, truncated, swapped or made by other encoders are misses, and the build makes their files again. Several
//! builds may use one cache at a time.

mod digest;
mod keeper;
mod record;
mod staging;
mod stamp;

pub use digest::{Digest, Key};
pub use keeper::{Cached, DONE, FOLDER, Store};
pub use record::{read_record, write_record};
pub use staging::{PREFIX, SUFFIX, Staging, abandoned, placing};
pub use stamp::{HashingObserver, Stamp};
