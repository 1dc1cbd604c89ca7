//! What was made before, by what it was made from.
//!
//! A folder `.brdfc-cache` beside the packs. Entries stand under a hash of the bytes that were read, the resolved recipe and
//! the encoders; files stand under the hash of their bytes. Whatever is broken, truncated, put in another's place or made by
//! another program is a miss: it is made again. Several builds may use one folder at a time.

mod digest;
mod keeper;
mod record;
mod staging;
mod stamp;

pub use digest::{Digest, Key};
pub use keeper::{DONE, FOLDER, Kept, Store};
pub use record::{read_record, write_record};
pub use staging::{PREFIX, SUFFIX, Staging, abandoned, placing};
pub use stamp::{HeardDigest, Stamp};
