//! Waiting until files may have changed: the system tells of it, or some time goes by. Whether anything did is for the caller
//! to look at.

use notify::{RecommendedWatcher, RecursiveMode, Watcher as _};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

/// Between two looks where the system tells of changes: network drives and replaced folders keep still about some.
const WITH_EVENTS: Duration = Duration::from_secs(10);
/// Where it tells of none.
const WITHOUT_EVENTS: Duration = Duration::from_secs(2);

/// Folders, and whether those below them count too.
pub type Folders = BTreeMap<PathBuf, bool>;

/// What the system tells of folders.
pub struct FileEvents {
    watcher: Option<RecommendedWatcher>,
    followed: Folders,
    sender: SyncSender<()>,
    receiver: Receiver<()>,
    every: Duration,
    /// Why the system tells of none.
    problem: Option<String>,
}

/// Ends a wait.
#[derive(Debug, Clone)]
pub struct Waker(SyncSender<()>);

impl Waker {
    /// Ends the wait that goes on, or else the next one.
    pub fn wake(&self) {
        // Where somebody did before, that is enough.
        let _ = self.0.try_send(());
    }
}

impl FileEvents {
    /// Of no folder yet. With `poll` the system is not asked: every wait takes so long.
    pub fn new(poll: Option<Duration>) -> Self {
        let (sender, receiver) = sync_channel(1);
        let mut events = Self {
            watcher: None,
            followed: Folders::new(),
            sender,
            receiver,
            every: poll.unwrap_or(WITH_EVENTS),
            problem: None,
        };
        if poll.is_none() {
            let waker = events.waker();
            // Who reads, as the looks do, changes nothing.
            let heard = move |event: notify::Result<notify::Event>| {
                if !event.is_ok_and(|event| event.kind.is_access()) {
                    waker.wake();
                }
            };
            match notify::recommended_watcher(heard) {
                Ok(watcher) => events.watcher = Some(watcher),
                Err(error) => events.fail(&error.to_string()),
            }
        }
        events
    }

    fn fail(&mut self, error: &str) {
        self.watcher = None;
        self.every = WITHOUT_EVENTS;
        self.problem = Some(format!(
            "the system does not tell when files change ({error}): they are looked at every {} s",
            WITHOUT_EVENTS.as_secs()
        ));
    }

    /// Why the system tells of no changes, once.
    pub fn problem(&mut self) -> Option<String> {
        self.problem.take()
    }

    /// Who ends a wait from elsewhere.
    pub fn waker(&self) -> Waker {
        Waker(self.sender.clone())
    }

    /// Follows these folders and no others; whether some are new, where changes before now went unheard.
    pub fn follow(&mut self, folders: &Folders) -> bool {
        let Some(watcher) = &mut self.watcher else { return false };
        let gone: Vec<PathBuf> = self
            .followed
            .iter()
            .filter(|(path, deep)| folders.get(*path) != Some(deep))
            .map(|(p, _)| p.clone())
            .collect();
        for path in gone {
            // A folder that went away is not followed any more.
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
                // It went away just now, and the next look finds another in its place.
                Err(_) if !path.exists() => {}
                Err(error) => {
                    self.fail(&told(path, &error));
                    return true;
                }
            }
        }
        any_new
    }

    /// Follows none: a folder that was replaced is another one of the same name.
    pub fn forget(&mut self) {
        self.follow(&Folders::new());
    }

    /// Waits until something may have changed.
    pub fn wait(&self) {
        let _ = self.receiver.recv_timeout(self.every);
    }
}

fn told(path: &Path, error: &notify::Error) -> String {
    let reason = match &error.kind {
        notify::ErrorKind::MaxFilesWatch => "there are more folders than it follows".to_owned(),
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
    fn folders_are_followed_once_and_anew_after_they_were_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let mut events = FileEvents::new(None);
        let folders = Folders::from([(folder.path().to_owned(), false)]);
        assert!(events.problem().is_none());
        assert!(events.follow(&folders) && !events.follow(&folders));
        events.forget();
        assert!(events.follow(&folders));
        let gone = Folders::from([(folder.path().join("gone"), true)]);
        assert!(!events.follow(&gone) && events.problem().is_none(), "what is not there is no fault of the system");
    }
}
