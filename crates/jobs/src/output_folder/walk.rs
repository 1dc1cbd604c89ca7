//! A random walk over an output folder and a simple model of it: builds, killed builds, a user who deletes, edits and
//! adds files, and flipped bits in the store. After each build, the folder has the requested files, or is unchanged.

use super::*;
use crate::output_folder::journal::Journal;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STEPS: usize = 10_000;
const NAMES: [&str; 6] = ["a", "b", "c", "A", "é", "report.json"];

/// Files in the folder, without the store.
type Files = BTreeMap<String, Vec<u8>>;

fn files_in(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).unwrap().flatten().filter(|entry| entry.path().is_file());
    entries.map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap())).collect()
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() { all.extend(files_below(&path)) } else { all.push(path) }
    }
    all.sort();
    all
}

/// The model of the folder.
#[derive(Debug, Default, Clone)]
struct Model {
    /// All files.
    files: Files,
    /// Files that the last build put there, which its report lists.
    placed: Files,
}

struct Walk {
    folder: tempfile::TempDir,
    random: ChaCha8Rng,
    model: Model,
    built: usize,
    refused: usize,
    taken_back: usize,
}

impl Walk {
    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn pick<T: Clone>(&mut self, from: &[T]) -> Option<T> {
        (!from.is_empty()).then(|| from[self.random.random_range(0..from.len())].clone())
    }

    /// Files that a build is asked for, including the report, which lists the others.
    fn asked(&mut self) -> Files {
        let mut files = Files::new();
        for name in NAMES.iter().filter(|name| **name != "report.json" && **name != "A") {
            if self.random.random_bool(0.6) {
                files.insert((*name).to_owned(), vec![self.random.random_range(b'0'..b'4')]);
            }
        }
        let text = files.iter().map(|(name, bytes)| format!("{name} {}\n", Digest::of(bytes)));
        files.insert("report.json".to_owned(), text.collect::<String>().into_bytes());
        files
    }

    /// Opens the folder like a build, with the files that the report lists.
    fn opened(&self) -> (Store, OutputFolder) {
        let store = Store::open(self.path(), true).unwrap();
        let mut folder = OutputFolder::open(self.path(), &store, &()).unwrap();
        if let Ok(report) = std::fs::read(self.path().join("report.json"))
            && let Ok(text) = String::from_utf8(report.clone())
        {
            let entry = |line: &str| {
                let (name, digest) = line.split_once(' ')?;
                Some((name.to_owned(), serde_json::from_str(&format!("{digest:?}")).ok()?))
            };
            let listed: Option<Vec<(String, Digest)>> = text.lines().map(entry).collect();
            if let Some(listed) = listed {
                folder.also_placed(listed.into_iter().chain([("report.json".to_owned(), Digest::of(&report))]));
            }
        }
        (store, folder)
    }

    fn build(&mut self) {
        let asked = self.asked();
        // Sometimes a folder gets in the way after the check.
        let in_the_way = self.random.random_bool(0.1).then(|| "c".to_owned());
        let (store, mut folder) = self.opened();
        let before = files_in(self.path());
        // If the report was edited and the store is gone, the files of earlier builds are unknown.
        let has_report =
            before.get("report.json").is_some_and(|report| self.model.placed.get("report.json") == Some(report));
        if folder.refuse_foreign(asked.keys().map(String::as_str), false).is_err() {
            let ours = |name: &String| self.model.placed.get(name) == before.get(name) || !before.contains_key(name);
            assert!(!has_report || !asked.keys().all(ours), "the files of builds are known: {:?}", self.model);
            assert_eq!(files_in(self.path()), before);
            self.refused += 1;
            // The user removes the files in the way.
            for name in asked.keys().filter(|name| before.contains_key(*name) && (!has_report || !ours(name))) {
                std::fs::remove_file(self.path().join(name)).unwrap();
                self.model.files.remove(name);
            }
            return;
        }
        let blocked = in_the_way.filter(|name| asked.contains_key(name) && !before.contains_key(name));
        if let Some(name) = &blocked {
            std::fs::create_dir(self.path().join(name)).unwrap();
        }
        let contents = asked.iter().map(|(name, bytes)| (name.clone(), Contents::Bytes(bytes.clone()))).collect();
        match folder.place(&store, &(), |_| Ok(contents)) {
            Ok(_) => {
                let now = files_in(self.path());
                assert!(blocked.is_none());
                for (name, bytes) in &asked {
                    assert_eq!(now.get(name), Some(bytes), "{name}");
                }
                for (name, bytes) in &before {
                    let was_ours = self.model.placed.get(name) == Some(bytes);
                    assert!(
                        asked.contains_key(name) || was_ours || now.get(name) == Some(bytes),
                        "{name} belongs to the user"
                    );
                    let stays = asked.contains_key(name) || !was_ours || !has_report;
                    assert!(stays || !now.contains_key(name), "{name} is left over");
                }
                (self.model.files, self.model.placed) = (now, asked);
                self.built += 1;
            }
            Err(error) => {
                assert!(blocked.is_some(), "{error}");
                assert_eq!(files_in(self.path()), before, "{error}");
                std::fs::remove_dir(self.path().join(blocked.unwrap())).unwrap();
                self.taken_back += 1;
            }
        }
    }

    /// A build that was killed after it moved up to two of its files.
    fn killed(&mut self) {
        let asked = self.asked();
        let (_store, folder) = self.opened();
        if folder.refuse_foreign(asked.keys().map(String::as_str), false).is_err() {
            return;
        }
        let root = self.path().join(FOLDER);
        let mut journal = Journal::new(&root);
        let mut placements = Placements::default();
        for (name, bytes) in &asked {
            journal.write(name, bytes).unwrap();
            placements.files.insert(name.clone(), Placed { digest: Digest::of(bytes), stamp: None });
        }
        let there = folder.there();
        let gone: Vec<String> = there.keys().filter(|name| !asked.contains_key(*name)).cloned().collect();
        gone.iter().for_each(|name| journal.remove(name));
        if self.random.random_bool(0.5) {
            journal.list(&write_record(&placements)).unwrap();
            for (name, bytes) in asked.iter().take(self.random.random_range(0..3)) {
                let _ = std::fs::rename(self.path().join(name), root.join("commit/old").join(name));
                std::fs::rename(root.join("commit/new").join(name), self.path().join(name)).unwrap();
                assert_eq!(std::fs::read(self.path().join(name)).unwrap(), *bytes);
            }
            // The next process completes the moves.
            let left = |(name, _): &(&String, &Vec<u8>)| !gone.contains(name) && !asked.contains_key(*name);
            let rest = self.model.files.iter().filter(left).map(|(name, bytes)| (name.clone(), bytes.clone()));
            self.model.files = rest.chain(asked.clone()).collect();
            self.model.placed = asked;
        }
        std::mem::forget(journal);
        self.opened();
        assert_eq!(files_in(self.path()), self.model.files);
    }

    fn step(&mut self) {
        let store = self.path().join(FOLDER);
        match self.random.random_range(0..8) {
            0..3 => self.build(),
            3 => self.killed(),
            // The user deletes a file, edits one, adds one.
            4 => {
                if let Some(path) = self.pick(&files_below(self.path())) {
                    std::fs::remove_file(&path).unwrap();
                    self.model.files = files_in(self.path());
                }
            }
            5 => {
                let name = self.pick(&NAMES).unwrap();
                std::fs::write(self.path().join(name), format!("a person's {}", self.random.random_range(0..9)))
                    .unwrap();
                self.model.files = files_in(self.path());
            }
            6 => {
                if self.random.random_bool(0.5) && store.exists() {
                    std::fs::remove_dir_all(&store).unwrap();
                }
            }
            _ => {
                if let Some(path) = self.pick(&files_below(&store)) {
                    let mut bytes = std::fs::read(&path).unwrap();
                    if !bytes.is_empty() {
                        let at = self.random.random_range(0..bytes.len());
                        bytes[at] ^= 1 << self.random.random_range(0..8u32);
                        std::fs::write(&path, bytes).unwrap();
                    }
                }
            }
        }
    }
}

#[test]
fn a_build_ends_with_its_files_or_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let random = ChaCha8Rng::seed_from_u64(30);
    let mut walk = Walk { folder, random, model: Model::default(), built: 0, refused: 0, taken_back: 0 };
    (0..STEPS).for_each(|_| walk.step());
    let Walk { built, refused, taken_back, .. } = walk;
    println!("{built} builds, {refused} refused, {taken_back} taken back");
    assert!(built > STEPS / 10 && refused > 50 && taken_back > 20);
}
