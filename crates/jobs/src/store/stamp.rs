//! What a file system says of a file, by which it is known again without being read.

use super::digest::Digest;
use brdfc_formats::FormatError;
use brdfc_source::read::ReadListener;
use serde::{Deserialize, Serialize};
use std::fs::{File, Metadata};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// A change within this time of another may leave the same time behind.
const GRANULARITY: Duration = Duration::from_secs(2);

/// Length, times and place of a file: the same as long as nobody writes to it or replaces it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    length: u64,
    /// Since 1970.
    modified: Duration,
    /// Of the file's own entry, where the system has that: seconds and nanoseconds; device and number of the file.
    changed: (i64, i64),
    place: (u64, u64),
}

impl Stamp {
    /// Of a file; `None` of what has no contents of its own, such as a pipe, or no time.
    pub fn of(metadata: &Metadata) -> Option<Self> {
        if !metadata.is_file() {
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

    /// Whether a change after `now` would leave another stamp: times of files have a coarse grain.
    pub fn is_settled(&self, now: SystemTime) -> bool {
        let Ok(now) = now.duration_since(UNIX_EPOCH) else { return false };
        let changed = Duration::from_secs(self.changed.0.max(0) as u64);
        self.modified.max(changed) + GRANULARITY < now
    }
}

/// Hashes what is read, and notes whether the file changed meanwhile.
pub struct HeardDigest {
    hasher: blake3::Hasher,
    file: Option<File>,
    stamp: Option<Stamp>,
    started: SystemTime,
    /// Largest file, bytes.
    limit: u64,
}

impl HeardDigest {
    /// Of a file of this kind, that has at most so many bytes. Files of other kinds are read in another order.
    pub fn new(kind: &str, limit: u64) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(kind.to_ascii_lowercase().as_bytes());
        Self { hasher, file: None, stamp: None, started: SystemTime::now(), limit }
    }

    /// The hash of what was read, and by what the file is known again, if that is safe to say.
    ///
    /// # Errors
    /// A file that was written to meanwhile: what was read may be no file that ever was.
    pub fn finish(self) -> std::io::Result<(Digest, Option<Stamp>)> {
        let now = self.file.as_ref().and_then(|file| Stamp::of(&file.metadata().ok()?));
        if now != self.stamp {
            return Err(std::io::Error::other("it was written to meanwhile"));
        }
        let stamp = self.stamp.filter(|stamp| stamp.is_settled(self.started));
        Ok((Digest::finish(&self.hasher), stamp))
    }
}

impl ReadListener for HeardDigest {
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
    use brdfc_source::read::read_heard;
    use std::io::Write as _;

    #[test]
    fn a_new_file_is_read_again_and_an_old_one_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.brdf");
        std::fs::write(&path, "rows").unwrap();
        let heard = |path| {
            let mut heard = HeardDigest::new("brdf", 100);
            read_heard(path, 100, &mut heard).unwrap();
            heard.finish().unwrap()
        };
        let (digest, stamp) = heard(&path);
        assert!(stamp.is_none(), "it may be written to within the same tick");
        assert_eq!(digest, heard(&path).0);
        let stamp = Stamp::of(&std::fs::metadata(&path).unwrap()).unwrap();
        assert!(stamp.is_settled(SystemTime::now() + Duration::from_secs(9)));
        assert!(HeardDigest::new("brdf", 3).opened(&File::open(&path).unwrap(), 4).is_err());
    }

    #[test]
    fn a_change_meanwhile_is_noticed() {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(b"first").unwrap();
        let mut heard = HeardDigest::new("brdf", 100);
        heard.opened(file.as_file(), 5).unwrap();
        file.write_all(b" and more").unwrap();
        assert!(heard.finish().is_err());
    }
}
