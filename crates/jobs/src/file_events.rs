//! Waits until files may have changed: until the system reports a change, or an interval has passed. The caller checks for changes.

use notify::{RecommendedWatcher, RecursiveMode, Watcher as _};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

/// Interval between checks if the system reports changes. It does not report all changes on network drives and in replaced folders.
const INTERVAL_WITH_EVENTS: Duration = Duration::from_secs(10);
/// Interval between checks if the system does not report changes.
const INTERVAL_WITHOUT_EVENTS: Duration = Duration::from_secs(2);

/// Folders, and true for those that are watched recursively.
pub type Folders = BTreeMap<PathBuf, bool>;

/// File events of folders.
pub struct FileEvents {
    watcher: Option<RecommendedWatcher>,
    followed: Folders,
    sender: SyncSender<()>,
    receiver: Receiver<()>,
    interval: Duration,
    /// Reason why the system reports no changes.
    problem: Option<String>,
}

/// Handle with which another thread ends a wait for file events.
#[derive(Debug, Clone)]
pub struct Waker(SyncSender<()>);

impl Waker {
    /// Ends the current wait, or else the next one.
    pub fn wake(&self) {
        // An error means that a wake-up is already pending.
        let _ = self.0.try_send(());
    }
}

impl FileEvents {
    /// Creates events without folders. With `poll`, every wait takes this long and system events are not used.
    pub fn new(poll: Option<Duration>) -> Self {
        let (sender, receiver) = sync_channel(1);
        let mut events = Self {
            watcher: None,
            followed: Folders::new(),
            sender,
            receiver,
            interval: poll.unwrap_or(INTERVAL_WITH_EVENTS),
            problem: None,
        };
        if poll.is_none() {
            let waker = events.waker();
            // Read access, as by the checks themselves, changes nothing.
            let observer = move |event: notify::Result<notify::Event>| {
                if !event.is_ok_and(|event| event.kind.is_access()) {
                    waker.wake();
                }
            };
            match notify::recommended_watcher(observer) {
                Ok(watcher) => events.watcher = Some(watcher),
                Err(error) => events.fail(&error.to_string()),
            }
        }
        events
    }

    fn fail(&mut self, error: &str) {
        self.watcher = None;
        self.interval = INTERVAL_WITHOUT_EVENTS;
        self.problem = Some(format!(
            "the system does not report file changes ({error}); files are checked every {} s",
            INTERVAL_WITHOUT_EVENTS.as_secs()
        ));
    }

    /// Reason why the system reports no changes; returned once.
    pub fn problem(&mut self) -> Option<String> {
        self.problem.take()
    }

    /// A handle that ends a wait from another thread.
    pub fn waker(&self) -> Waker {
        Waker(self.sender.clone())
    }

    /// Follows exactly these folders. Returns true if some are new, in which earlier changes were not observed.
    pub fn follow(&mut self, folders: &Folders) -> bool {
        let Some(watcher) = &mut self.watcher else { return false };
        let gone: Vec<PathBuf> = self
            .followed
            .iter()
            .filter(|(path, deep)| folders.get(*path) != Some(deep))
            .map(|(p, _)| p.clone())
            .collect();
        for path in gone {
            // Removed folders are no longer watched, so an error is ignored.
            let _ = watcher.unwatch(&path);
            self.followed.remove(&path);
        }
        let mut any_new = false;
        for (path, deep) in folders {
            if self.followed.contains_key(path) {
                continue;
            }
            let mode = if *deep { RecursiveMode::Recursive } else { RecursiveMode::NonRecursive };
            match watcher.watch(path, mode) {
                Ok(()) => {
                    self.followed.insert(path.clone(), *deep);
                    any_new = true;
                }
                // It was just removed; the next check finds its replacement.
                Err(_) if !path.exists() => {}
                Err(error) => {
                    self.fail(&problem_text(path, &error));
                    return true;
                }
            }
        }
        any_new
    }

    /// Stops following all folders, because folders may have been replaced by others of the same name.
    pub fn forget(&mut self) {
        self.follow(&Folders::new());
    }

    /// Waits until something may have changed.
    pub fn wait(&self) {
        let _ = self.receiver.recv_timeout(self.interval);
    }
}

fn problem_text(path: &Path, error: &notify::Error) -> String {
    let reason = match &error.kind {
        notify::ErrorKind::MaxFilesWatch => "too many folders to watch".to_owned(),
        notify::ErrorKind::Io(error) => error.to_string(),
        _ => error.to_string(),
    };
    format!("{}: {reason}", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_ends_when_it_is_woken_before_or_meanwhile() {
        let events = FileEvents::new(Some(Duration::from_secs(3600)));
        events.waker().wake();
        events.waker().wake();
        events.wait();
        let waker = events.waker();
        std::thread::scope(|scope| {
            scope.spawn(move || waker.wake());
            events.wait();
        });
    }

    #[test]
    fn folders_are_followed_once_and_again_after_forget() {
        let folder = tempfile::tempdir().unwrap();
        let mut events = FileEvents::new(None);
        let folders = Folders::from([(folder.path().to_owned(), false)]);
        assert!(events.problem().is_none());
        assert!(events.follow(&folders) && !events.follow(&folders));
        events.forget();
        assert!(events.follow(&folders));
        let gone = Folders::from([(folder.path().join("gone"), true)]);
        assert!(!events.follow(&gone) && events.problem().is_none(), "a missing folder is not a problem of the system");
    }
}
