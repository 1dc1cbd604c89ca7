//! File metadata by which an unchanged file is recognised without reading it.

use super::digest::Digest;
use brdfc_formats::FormatError;
use brdfc_source::read::ReadListener;
use serde::{Deserialize, Serialize};
use std::fs::{File, Metadata};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Two changes within this time may leave the same modification time.
const GRANULARITY: Duration = Duration::from_secs(2);

/// Length, times and inode of a file. A stamp changes when a program writes to the file or replaces it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    length: u64,
    /// Time of the last change of the contents, since 1970.
    modified: Duration,
    /// Time of the last change of the inode, seconds and nanoseconds; 0 where the system has none.
    changed: (i64, i64),
    /// Device and inode number; 0 where the system has none.
    place: (u64, u64),
}

impl Stamp {
    /// Returns the stamp of a regular file; `None` for others, and without a modification time.
    pub fn of(metadata: &Metadata) -> Option<Self> {
        metadata.is_file().then(|| Self::of_entry(metadata)).flatten()
    }

    /// Returns the stamp of a regular file or of a link itself, whose target may change without it; `None` for others, and without a
    /// modification time.
    pub fn of_entry(metadata: &Metadata) -> Option<Self> {
        if !metadata.is_file() && !metadata.is_symlink() {
            return None;
        }
        let modified = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        #[cfg(unix)]
        let (changed, place) = {
            use std::os::unix::fs::MetadataExt as _;
            ((metadata.ctime(), metadata.ctime_nsec()), (metadata.dev(), metadata.ino()))
        };
        #[cfg(not(unix))]
        let (changed, place) = ((0, 0), (0, 0));
        Some(Self { length: metadata.len(), modified, changed, place })
    }

    /// Returns true if a change after `now` is certain to change the stamp. File times have a coarse resolution.
    pub fn is_settled(&self, now: SystemTime) -> bool {
        let Ok(now) = now.duration_since(UNIX_EPOCH) else { return false };
        let changed = Duration::from_secs(self.changed.0.max(0) as u64);
        self.modified.max(changed) + GRANULARITY < now
    }
}

/// Hashes the bytes of a file while it is read, and detects changes in the meantime.
pub struct HashingObserver {
    hasher: blake3::Hasher,
    file: Option<File>,
    stamp: Option<Stamp>,
    started: SystemTime,
    /// Length of the largest file that is read, bytes.
    limit: u64,
}

impl HashingObserver {
    /// Prepares for a file of this kind with at most `limit` bytes. The kind is part of the hash, as other kinds are
    /// read in another order.
    pub fn new(kind: &str, limit: u64) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(kind.to_ascii_lowercase().as_bytes());
        Self { hasher, file: None, stamp: None, started: SystemTime::now(), limit }
    }

    /// Returns the hash, and the stamp if any later change is certain to change it.
    ///
    /// # Errors
    /// Returns an error if the file changed while it was read: the bytes may mix two versions.
    pub fn finish(self) -> std::io::Result<(Digest, Option<Stamp>)> {
        let now = self.file.as_ref().and_then(|file| Stamp::of(&file.metadata().ok()?));
        if now != self.stamp {
            return Err(std::io::Error::other("the file changed while it was read"));
        }
        let stamp = self.stamp.filter(|stamp| stamp.is_settled(self.started));
        Ok((Digest::finish(&self.hasher), stamp))
    }
}

impl ReadListener for HashingObserver {
    fn opened(&mut self, file: &File, length: u64) -> Result<(), FormatError> {
        if length > self.limit {
            let allowed = format!("at most {} bytes with this --memory", self.limit);
            return Err(FormatError::whole("file length", format!("{length} bytes"), allowed));
        }
        self.started = SystemTime::now();
        self.file = file.try_clone().ok();
        self.stamp = self.file.as_ref().and_then(|file| Stamp::of(&file.metadata().ok()?));
        Ok(())
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_source::read::read_file_observed;
    use std::io::Write as _;

    #[test]
    fn a_new_file_is_read_again_and_an_old_one_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.brdf");
        std::fs::write(&path, "rows").unwrap();
        let observed = |path| {
            let mut observer = HashingObserver::new("brdf", 100);
            read_file_observed(path, 100, &mut observer).unwrap();
            observer.finish().unwrap()
        };
        let (digest, stamp) = observed(&path);
        assert!(stamp.is_none(), "it may change within the same tick");
        assert_eq!(digest, observed(&path).0);
        let stamp = Stamp::of(&std::fs::metadata(&path).unwrap()).unwrap();
        assert!(stamp.is_settled(SystemTime::now() + Duration::from_secs(9)));
        assert!(HashingObserver::new("brdf", 3).opened(&File::open(&path).unwrap(), 4).is_err());
    }

    #[test]
    fn a_change_during_the_read_is_detected() {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(b"first").unwrap();
        let mut observer = HashingObserver::new("brdf", 100);
        observer.opened(file.as_file(), 5).unwrap();
        file.write_all(b" and more").unwrap();
        assert!(observer.finish().is_err());
    }
}
