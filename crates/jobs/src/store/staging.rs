//! Staging folders for unfinished files. A process removes its own folders when it ends; later processes remove the
//! folders of killed processes.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};
use tempfile::TempDir;

/// First characters of the names of unfinished files and folders.
pub const PREFIX: &str = ".brdfc-";
/// Last characters of the names of unfinished files and folders.
pub const SUFFIX: &str = ".tmp";
/// Lock file of a staging folder, locked until its process ends.
const LOCK: &str = "lock";
/// Name of the lock file before it is locked.
const UNLOCKED: &str = "lock.new";
/// Upper bound of the time between creating a file and locking it.
const NEW: Duration = Duration::from_secs(10);

/// Staging folders of this process.
static ALL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Locked while finished files are moved into place.
static PLACING: Mutex<()> = Mutex::new(());

/// Locks the placing of finished files. A program that ends on a signal takes this lock first, then calls
/// [`Staging::remove_all`].
pub fn placing() -> MutexGuard<'static, ()> {
    PLACING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A staging folder on the same file system as the finished files, which are renamed into place when complete.
#[derive(Debug)]
pub struct Staging {
    // Declared before the folder, to be dropped first: some systems cannot remove an open file.
    _lock: File,
    folder: TempDir,
}

impl Staging {
    /// Removes abandoned staging folders in `parent`, which exists, and creates a new one.
    ///
    /// # Errors
    /// Returns an error if the folder or its lock cannot be created.
    pub fn new(parent: &Path) -> std::io::Result<Self> {
        sweep(parent);
        let folder = tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).tempdir_in(parent)?;
        all().push(folder.path().to_owned());
        Ok(Self { _lock: locked(folder.path())?, folder })
    }

    /// Removes all staging folders of this process, which is about to end.
    pub fn remove_all() {
        all().iter().for_each(|folder| drop(remove(folder)));
    }

    /// Path of the folder.
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

/// Removes a folder, its lock last. A folder without a lock counts as new, and would stay for a while if this process
/// is killed.
fn remove(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)?.flatten().filter(|entry| entry.file_name() != LOCK) {
        let path = entry.path();
        if path.is_dir() { std::fs::remove_dir_all(path)? } else { std::fs::remove_file(path)? }
    }
    std::fs::remove_dir_all(folder)
}

/// Creates the lock of a folder. The file gets its name only when it is locked: otherwise another process could find it
/// unlocked and remove the folder.
fn locked(folder: &Path) -> std::io::Result<File> {
    let aside = folder.join(UNLOCKED);
    let lock = File::create(&aside)?;
    // On systems without file locks, folders with a lock file are never removed.
    let _ = lock.try_lock();
    std::fs::rename(aside, folder.join(LOCK))?;
    Ok(lock)
}

fn all() -> MutexGuard<'static, Vec<PathBuf>> {
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes abandoned files and folders in `parent`.
pub fn sweep(parent: &Path) {
    for path in abandoned(parent) {
        let _ = if path.is_dir() { remove(&path) } else { std::fs::remove_file(path) };
    }
}

/// Unfinished files and folders in `parent` whose processes have ended.
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
        // A new file may not be locked yet.
        Ok(file) => file.try_lock().is_ok() && (lock != path || !is_new()),
        Err(_) => !is_new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweep_removes_abandoned_folders_only() {
        let parent = tempfile::tempdir().unwrap();
        let in_use = Staging::new(parent.path()).unwrap();
        let abandoned = parent.path().join(".brdfc-dead.tmp");
        std::fs::create_dir(&abandoned).unwrap();
        std::fs::write(abandoned.join(LOCK), "").unwrap();
        std::fs::write(abandoned.join("part.ktx2"), "half").unwrap();
        let unrelated = parent.path().join("notes.tmp");
        std::fs::write(&unrelated, "a person's").unwrap();
        let next = Staging::new(parent.path()).unwrap();
        assert!(in_use.path().is_dir() && next.path().is_dir() && unrelated.is_file() && !abandoned.exists());
        drop((in_use, next));
        assert_eq!(std::fs::read_dir(parent.path()).unwrap().count(), 1);
    }

    /// Watches a folder while it is removed: its lock exists as long as any other file does.
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
    fn concurrent_sweeps_remove_no_new_folders() {
        let parent = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..250 {
                        let staging = Staging::new(parent.path()).unwrap();
                        std::fs::write(staging.path().join("part"), "half").unwrap();
                        assert!(staging.path().join(LOCK).is_file());
                    }
                });
            }
        });
    }

    #[test]
    fn sweep_keeps_new_files() {
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
