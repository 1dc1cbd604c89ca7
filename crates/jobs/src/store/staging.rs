//! Folders for what is not finished, which go away with the process that made them, and are swept where it was killed.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};
use tempfile::TempDir;

/// What the names of unfinished files and folders begin and end with.
pub const PREFIX: &str = ".brdfc-";
/// See [`PREFIX`].
pub const SUFFIX: &str = ".tmp";
/// Held as long as the process lives that works in the folder.
const LOCK: &str = "lock";
/// The same file before it is held.
const UNLOCKED: &str = "lock.new";
/// Between making something and locking it less time goes by.
const NEW: Duration = Duration::from_secs(10);

/// Those of this process.
static ALL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Held while finished files change places.
static PLACING: Mutex<()> = Mutex::new(());

/// Held while finished files change places. A program that ends on a signal takes it first, then calls
/// [`Staging::remove_all`].
pub fn placing() -> MutexGuard<'static, ()> {
    PLACING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder beside finished files, on the same file system, for those that are renamed into place when they are whole.
#[derive(Debug)]
pub struct Staging {
    // Before the folder: on some systems an open file cannot be removed.
    _lock: File,
    folder: TempDir,
}

impl Staging {
    /// Makes one in `parent`, which is there, after what dead processes left there is swept.
    pub fn new(parent: &Path) -> std::io::Result<Self> {
        sweep(parent);
        let folder = tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).tempdir_in(parent)?;
        all().push(folder.path().to_owned());
        Ok(Self { _lock: locked(folder.path())?, folder })
    }

    /// Removes all of this process, which is about to end.
    pub fn remove_all() {
        all().iter().for_each(|folder| drop(remove(folder)));
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        let _ = remove(self.folder.path());
        all().retain(|folder| folder != self.folder.path());
    }
}

/// Removes a folder, its lock last: what has none is taken for new, and would stay for a while if this is killed.
fn remove(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)?.flatten().filter(|entry| entry.file_name() != LOCK) {
        let path = entry.path();
        if path.is_dir() { std::fs::remove_dir_all(path)? } else { std::fs::remove_file(path)? }
    }
    std::fs::remove_dir_all(folder)
}

/// A folder's lock, which has its name only once it is held: whoever finds it free between the two would take its owner for
/// dead.
fn locked(folder: &Path) -> std::io::Result<File> {
    let aside = folder.join(UNLOCKED);
    let lock = File::create(&aside)?;
    // Where files cannot be locked, nothing that has a lock is swept.
    let _ = lock.try_lock();
    std::fs::rename(aside, folder.join(LOCK))?;
    Ok(lock)
}

fn all() -> MutexGuard<'static, Vec<PathBuf>> {
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what processes left unfinished in `parent` that are no longer there.
pub fn sweep(parent: &Path) {
    for path in abandoned(parent) {
        let _ = if path.is_dir() { remove(&path) } else { std::fs::remove_file(path) };
    }
}

/// What processes left unfinished in `parent` that are no longer there: files and folders.
pub fn abandoned(parent: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(parent) else { return Vec::new() };
    let is_ours = |entry: &std::fs::DirEntry| {
        let name = entry.file_name();
        name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX))
    };
    entries.flatten().filter(is_ours).map(|entry| entry.path()).filter(|path| is_abandoned(path)).collect()
}

fn is_abandoned(path: &Path) -> bool {
    let Ok(metadata) = path.symlink_metadata() else { return false };
    let lock: PathBuf = if metadata.is_dir() { path.join(LOCK) } else { path.to_owned() };
    let age = |metadata: std::fs::Metadata| SystemTime::now().duration_since(metadata.modified().ok()?).ok();
    let is_new = || age(metadata).is_none_or(|age| age < NEW);
    match File::open(&lock) {
        // A file is made before it is locked.
        Ok(file) => file.try_lock().is_ok() && (lock != path || !is_new()),
        Err(_) => !is_new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_dead_left_is_swept_and_what_the_living_use_is_not() {
        let parent = tempfile::tempdir().unwrap();
        let alive = Staging::new(parent.path()).unwrap();
        let dead = parent.path().join(".brdfc-dead.tmp");
        std::fs::create_dir(&dead).unwrap();
        std::fs::write(dead.join(LOCK), "").unwrap();
        std::fs::write(dead.join("part.ktx2"), "half").unwrap();
        let unrelated = parent.path().join("notes.tmp");
        std::fs::write(&unrelated, "a person's").unwrap();
        let next = Staging::new(parent.path()).unwrap();
        assert!(alive.path().is_dir() && next.path().is_dir() && unrelated.is_file() && !dead.exists());
        drop((alive, next));
        assert_eq!(std::fs::read_dir(parent.path()).unwrap().count(), 1);
    }

    /// Watches a folder that is removed: as long as there is anything in it, there is its lock.
    #[test]
    fn a_lock_is_removed_last() {
        let parent = tempfile::tempdir().unwrap();
        for _ in 0..20 {
            let staging = Staging::new(parent.path()).unwrap();
            let path = staging.path().to_owned();
            for number in 0..50 {
                std::fs::write(path.join(number.to_string()), "part").unwrap();
            }
            std::thread::scope(|scope| {
                scope.spawn(|| drop(staging));
                while path.exists() {
                    let has_lock = path.join(LOCK).exists();
                    let rest = std::fs::read_dir(&path).into_iter().flatten().flatten();
                    assert!(rest.filter(|entry| entry.file_name() != LOCK).count() == 0 || has_lock);
                }
            });
        }
    }

    #[test]
    fn who_sweeps_while_others_begin_takes_nobody_for_dead() {
        let parent = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..250 {
                        let begun = Staging::new(parent.path()).unwrap();
                        std::fs::write(begun.path().join("part"), "half").unwrap();
                        assert!(begun.path().join(LOCK).is_file());
                    }
                });
            }
        });
    }

    #[test]
    fn files_that_are_just_being_written_are_left_alone() {
        let parent = tempfile::tempdir().unwrap();
        let file = parent.path().join(".brdfc-new.tmp");
        std::fs::write(&file, "half").unwrap();
        sweep(parent.path());
        assert!(file.is_file());
        let old = SystemTime::now() - 2 * NEW;
        File::options().write(true).open(&file).unwrap().set_modified(old).unwrap();
        sweep(parent.path());
        assert!(!file.exists());
    }
}
