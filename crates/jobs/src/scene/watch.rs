//! Watches the input files of a build: detects changed, new and removed files, and waits until writes to them are
//! complete.

use super::assets::files_of;
use super::batch::{address_of, find, given};
use super::manifest::Manifest;
use super::patterns::Named;
use crate::file_events::{FileEvents, Folders, Waker};
use crate::store::Stamp;
use crate::write::or_here;
use brdfc_source::btf_stack::LEVELS;
use brdfc_source::read::{MAX_TEXT_BYTES, read_file};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use walkdir::{DirEntry, WalkDir};

/// Files that do not change during this time are complete. Editors write in several steps.
const QUIET: Duration = Duration::from_millis(200);

/// The input files at one moment, with their stamps; `None` for a named file that is missing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Look {
    manifest: Option<PathBuf>,
    files: BTreeMap<PathBuf, Option<Stamp>>,
}

/// Kind of change of a file between two looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// The contents changed, or another file has the name.
    Changed,
    /// The file did not exist, or was not an input.
    New,
    /// The file no longer exists, or is no longer an input.
    Gone,
}

/// A change of an input file.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct Change {
    /// Path of the file.
    pub file: String,
    /// Kind of the change.
    pub what: What,
}

impl Look {
    /// Number of existing files.
    pub fn count(&self) -> usize {
        self.files.values().flatten().count()
    }

    /// Changes since an earlier look, by name. If the manifest changed, files that only its old or new version names
    /// do not count.
    pub fn changes_since(&self, earlier: &Self) -> Vec<Change> {
        let paths: BTreeSet<&PathBuf> = self.files.keys().chain(earlier.files.keys()).collect();
        let stamps = |path: &PathBuf| [earlier, self].map(|look| look.files.get(path).copied().flatten());
        let same_manifest = self.manifest.as_ref().is_none_or(|path| stamps(path)[0] == stamps(path)[1]);
        let change = |path: &&PathBuf| {
            let is_news = same_manifest || self.manifest.as_ref() == Some(*path);
            let what = match stamps(path).into() {
                (None, Some(_)) if is_news => What::New,
                (Some(_), None) if is_news => What::Gone,
                (Some(before), Some(now)) if before != now => What::Changed,
                _ => return None,
            };
            Some(Change { file: path.display().to_string(), what })
        };
        paths.iter().filter_map(change).collect()
    }
}

/// The input files of a build.
#[derive(Debug)]
pub struct Watched {
    /// The manifest, with its stamp at the last read.
    manifest: Option<(PathBuf, Option<Stamp>)>,
    /// Paths and patterns.
    named: Vec<Named>,
    /// The output folder.
    out: PathBuf,
}

impl Watched {
    /// Watches a manifest and the files that it names. While the manifest is missing or invalid, the files of its
    /// last valid version are watched.
    pub fn of_manifest(manifest: &Path, out: &Path) -> Self {
        Self { manifest: Some((manifest.to_owned(), None)), named: Vec::new(), out: out.to_owned() }
    }

    /// Watches files, folders and patterns.
    pub fn of_inputs(inputs: &[OsString], out: &Path) -> Self {
        Self { manifest: None, named: given(inputs), out: out.to_owned() }
    }

    /// Returns true if a file is a pack in the output folder. A build must not start again because of its own output.
    fn is_own(&self, path: &Path) -> bool {
        let there = |folder: &Path| or_here(folder).canonicalize().ok();
        path.extension().is_some_and(|extension| extension == "ktx2") && there(parent(path)) == there(&self.out)
    }

    /// Looks at all input files.
    pub fn look(&mut self) -> Look {
        let mut files = BTreeMap::new();
        if let Some((manifest, known)) = &mut self.manifest {
            let stamp = stamp(manifest);
            if stamp != *known {
                *known = stamp;
                if let Some(named) = named_in(manifest) {
                    self.named = named;
                }
            }
            files.insert(manifest.clone(), stamp);
        }
        for input in &self.named {
            let matched = input.is_pattern();
            let paths: Vec<PathBuf> = if self.manifest.is_some() && input.path().is_dir() {
                // A folder in a manifest is one asset, even with other files in it.
                files_of(&input.path())
            } else {
                // The build reports errors of inputs.
                let Ok(found) = find(std::slice::from_ref(input)) else { continue };
                let sources = found.sources.iter().filter(|(source, _)| address_of(source).is_none());
                sources.flat_map(|(source, _)| files_of(Path::new(source))).collect()
            };
            for path in paths.into_iter().filter(|path| !(matched && self.is_own(path))) {
                let stamp = stamp(&path);
                files.insert(path, stamp);
            }
        }
        Look { manifest: self.manifest.as_ref().map(|(path, _)| path.clone()), files }
    }

    /// The folders to watch for events, with true if their subfolders count. Programs replace files, so events of
    /// single files are not enough.
    fn folders(&self, look: &Look) -> Folders {
        let mut folders = Folders::new();
        let mut add = |path: &Path, deep: bool| {
            let there = path.ancestors().map(or_here).find(|folder| folder.is_dir());
            if let Some(folder) = there {
                let deep = deep && folder == or_here(path);
                folders.entry(folder.to_owned()).and_modify(|other| *other |= deep).or_insert(deep);
            }
        };
        for path in look.files.keys() {
            add(parent(path), false);
            if let (true, Ok(target)) = (path.is_symlink(), path.canonicalize()) {
                add(parent(&target), false);
            }
        }
        for input in &self.named {
            if input.is_pattern() {
                let (base, deep) = input.base();
                add(&base, deep);
            } else if input.path().is_dir() {
                // New files may be in subfolders: those of an RTI capture, or of a view of a BTF.
                let is_visible =
                    |entry: &DirEntry| entry.depth() == 0 || !entry.file_name().to_string_lossy().starts_with('.');
                let below = WalkDir::new(input.path()).max_depth(LEVELS).into_iter();
                let below = below.filter_entry(|entry| entry.path().is_dir() && is_visible(entry));
                below.flatten().for_each(|folder| add(folder.path(), false));
            }
        }
        folders
    }

    /// Waits until the input files differ from `before` and are complete. Returns `None` when `ended` is set; the
    /// thread that sets it has to call the [`Waker`].
    pub fn next(&mut self, events: &mut FileEvents, before: &Look, ended: &AtomicBool) -> Option<Look> {
        while !ended.load(Ordering::Relaxed) {
            let mut now = self.look();
            if events.follow(&self.folders(&now)) {
                continue;
            }
            if now == *before {
                events.wait();
                continue;
            }
            loop {
                std::thread::sleep(QUIET);
                let later = self.look();
                if later == now {
                    break;
                }
                now = later;
            }
            events.forget();
            if now != *before {
                return Some(now);
            }
        }
        None
    }

    /// Runs `work`, and watches for changes since `before` in the meantime. Returns the result and the new look if
    /// the input files changed. A change sets the flag that `work` receives, which should then stop: its result is
    /// out of date.
    pub fn during<T>(
        &mut self,
        events: &mut FileEvents,
        before: &Look,
        work: impl FnOnce(&AtomicBool) -> T,
    ) -> (T, Option<Look>) {
        let (cancelled, ended) = (AtomicBool::new(false), AtomicBool::new(false));
        let waker = events.waker();
        std::thread::scope(|scope| {
            // Dropped after a panic as well: otherwise the scope would wait forever.
            let end = End { ended: &ended, waker };
            let helper = scope.spawn(|| {
                let next = self.next(events, before, &ended);
                cancelled.store(next.is_some(), Ordering::Relaxed);
                next
            });
            let result = work(&cancelled);
            drop(end);
            (result, helper.join().ok().flatten())
        })
    }
}

struct End<'a> {
    ended: &'a AtomicBool,
    waker: Waker,
}

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        self.waker.wake();
    }
}

/// The inputs that a manifest names; `None` if it cannot be read.
pub(crate) fn named_in(manifest: &Path) -> Option<Vec<Named>> {
    let bytes = read_file(manifest, MAX_TEXT_BYTES).ok()?;
    let manifest_text = std::str::from_utf8(&bytes).ok()?;
    Some(Manifest::parse(manifest_text).ok()?.inputs(parent(manifest)))
}

/// Stamp of a file, or of a link whose target does not exist.
fn stamp(path: &Path) -> Option<Stamp> {
    Stamp::of_entry(&std::fs::metadata(path).or_else(|_| path.symlink_metadata()).ok()?)
}

fn parent(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(now: &Look, earlier: &Look, folder: &Path) -> Vec<String> {
        let name = |file: &str| Path::new(file).strip_prefix(folder).unwrap().display().to_string();
        now.changes_since(earlier).iter().map(|change| format!("{} {:?}", name(&change.file), change.what)).collect()
    }

    #[test]
    fn a_manifest_names_the_watched_files() {
        let there = tempfile::tempdir().unwrap();
        let (folder, manifest) = (there.path(), there.path().join("[scene].toml"));
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        let text = "[materials.all]\nsource='*.brdf'\n[materials.spare]\nsource='spare.csv'\n[materials.model]\n\
                    source='synth:ward'\n[[uses]]\nmaterial='all'\n[[uses]]\nmaterial='model'\n";
        write("[scene].toml", text);
        write("a.brdf", "a");
        write("spare.csv", "not used");
        let mut watched = Watched::of_manifest(&manifest, Path::new("packs"));
        let first = watched.look();
        assert_eq!(first.count(), 2);
        assert_eq!(watched.look(), first);
        write("spare.csv", "still not used");
        write("b.brdf", "b");
        let second = watched.look();
        assert_eq!(summary(&second, &first, folder), ["b.brdf New"]);
        // While the manifest cannot be read, its previous files are watched.
        write("[scene].toml", "[materials");
        let third = watched.look();
        assert_eq!((summary(&third, &second, folder), third.count()), (vec!["[scene].toml Changed".to_owned()], 3));
        std::fs::remove_file(&manifest).unwrap();
        assert_eq!(summary(&watched.look(), &third, folder), ["[scene].toml Gone"]);
        write("[scene].toml", &text.replace("*.brdf", "spare.csv"));
        let changes = summary(&watched.look(), &third, folder);
        assert_eq!(changes, ["[scene].toml Changed"], "files of the new version do not count");
    }

    #[test]
    fn only_packs_outside_the_output_folder_are_watched() {
        let there = tempfile::tempdir().unwrap();
        let folder = there.path();
        for name in ["packs/a.brdf.ktx2", "packs/a.json", "packs/b.brdf", "old/c.brdf.ktx2"] {
            std::fs::create_dir_all(folder.join(name).parent().unwrap()).unwrap();
            std::fs::write(folder.join(name), "").unwrap();
        }
        let pattern = OsString::from(folder.join("*/*.*[f2]"));
        let count = |inputs: &[OsString], out: &str| Watched::of_inputs(inputs, &folder.join(out)).look().count();
        assert_eq!(count(std::slice::from_ref(&pattern), "packs/."), 2);
        assert_eq!(count(std::slice::from_ref(&pattern), "elsewhere"), 3);
        assert_eq!(count(&[folder.join("packs/a.brdf.ktx2").into()], "packs"), 1, "a named pack");
    }

    #[cfg(unix)]
    #[test]
    fn links_without_targets_are_changes() {
        let there = tempfile::tempdir().unwrap();
        let folder = there.path();
        std::fs::write(folder.join("b.brdf"), "b").unwrap();
        let mut watched = Watched::of_inputs(&[folder.into()], Path::new("packs"));
        let first = watched.look();
        std::os::unix::fs::symlink("later.brdf", folder.join("a.brdf")).unwrap();
        let second = watched.look();
        assert_eq!(summary(&second, &first, folder), ["a.brdf New"]);
        std::fs::write(folder.join("later.brdf"), "a").unwrap();
        let third = watched.look();
        assert_eq!(summary(&third, &second, folder), ["a.brdf Changed", "later.brdf New"]);
        std::fs::remove_file(folder.join("a.brdf")).unwrap();
        assert_eq!(summary(&watched.look(), &third, folder), ["a.brdf Gone"]);
    }

    #[test]
    fn subfolders_of_an_input_folder_are_watched() {
        let there = tempfile::tempdir().unwrap();
        let folder = there.path();
        std::fs::create_dir_all(folder.join("coin/deep/deeper")).unwrap();
        std::fs::create_dir_all(folder.join(".git/objects")).unwrap();
        let mut watched = Watched::of_inputs(&[folder.into()], Path::new("packs"));
        let look = watched.look();
        let followed: Vec<PathBuf> = watched.folders(&look).into_keys().collect();
        assert_eq!(followed, [folder.to_owned(), folder.join("coin"), folder.join("coin/deep")]);
        std::fs::write(folder.join("coin/a.lp"), "").unwrap();
        assert_eq!(summary(&watched.look(), &look, folder), ["coin/a.lp New"]);
    }

    #[test]
    fn a_folder_of_a_manifest_is_one_asset() {
        let there = tempfile::tempdir().unwrap();
        let (folder, manifest) = (there.path(), there.path().join("scene.toml"));
        let write = |name: &str| std::fs::write(folder.join(name), "").unwrap();
        std::fs::write(&manifest, "[btfs.a]\nsource='a'\n").unwrap();
        std::fs::create_dir(folder.join("a")).unwrap();
        ["a/tl000 pl000 tv000 pv000.png", "a/scan.dat"].into_iter().for_each(write);
        let mut watched = Watched::of_manifest(&manifest, Path::new("packs"));
        let first = watched.look();
        write("a/tl030 pl000 tv000 pv000.png");
        assert_eq!(summary(&watched.look(), &first, folder), ["a/tl030 pl000 tv000 pv000.png New"]);
    }

    #[test]
    fn folders_are_watched_instead_of_files() {
        let there = tempfile::tempdir().unwrap();
        let folder = there.path().join("[a]");
        std::fs::create_dir_all(folder.join("scans/deep")).unwrap();
        let followed = |source: &str| {
            let manifest = folder.join("scene.toml");
            let text = format!("[materials.all]\nsource='{source}'\n[[uses]]\nmaterial='all'\n");
            std::fs::write(&manifest, text).unwrap();
            let mut watched = Watched::of_manifest(&manifest, Path::new("packs"));
            let look = watched.look();
            let name = |path: &Path| path.strip_prefix(&folder).unwrap().display().to_string();
            watched.folders(&look).iter().map(|(path, deep)| (name(path), *deep)).collect::<Vec<_>>()
        };
        let (here, scans) = (|deep| (String::new(), deep), |deep| ("scans".to_owned(), deep));
        assert_eq!(followed("scans/a.brdf"), [here(false), scans(false)]);
        assert_eq!(followed("scans/*.brdf"), [here(false), scans(false)]);
        assert_eq!(followed("scans/*/*.brdf"), [here(false), scans(true)]);
        assert_eq!(followed("**/*.brdf"), [here(true)]);
        // A missing folder is awaited in its nearest existing parent.
        assert_eq!(followed("gone/below/a.brdf"), [here(false)]);
        assert_eq!(followed("gone/*/a.brdf"), [here(false)]);
    }
}
