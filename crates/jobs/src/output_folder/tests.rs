use super::*;

fn bytes(name: &str, text: &str) -> (String, Contents) {
    (name.to_owned(), Contents::Bytes(text.as_bytes().to_vec()))
}

struct There {
    folder: tempfile::TempDir,
    store: Store,
}

impl There {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), true).unwrap();
        Self { folder, store }
    }

    fn open(&self) -> OutputFolder {
        OutputFolder::open(self.folder.path(), &self.store, &()).unwrap()
    }

    fn place(&self, files: &[(String, Contents)]) -> Changes {
        self.open().place(&self.store, &(), |_| Ok(files.to_vec())).unwrap()
    }

    fn text(&self, name: &str) -> Option<String> {
        std::fs::read_to_string(self.folder.path().join(name)).ok()
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.path().join(name), text).unwrap();
    }
}

#[test]
fn the_folder_has_the_listed_files() {
    let there = There::new();
    there.write("notes.txt", "a person's");
    let first = there.place(&[bytes("a", "1"), bytes("b", "2"), bytes("report.json", "ab")]);
    assert_eq!(first.written, ["a", "b", "report.json"]);
    assert_eq!(there.place(&[bytes("a", "1"), bytes("b", "2"), bytes("report.json", "ab")]), Changes::default());
    let second = there.place(&[bytes("b", "2"), bytes("c", "3"), bytes("report.json", "bc")]);
    assert_eq!((second.written, second.removed), (vec!["c".into(), "report.json".into()], vec!["a".into()]));
    assert_eq!((there.text("a"), there.text("notes.txt").as_deref()), (None, Some("a person's")));
    let keep = |there: &BTreeMap<String, Digest>| {
        assert_eq!(there.keys().collect::<Vec<_>>(), ["b", "c", "report.json"]);
        Ok(vec![("b".to_owned(), Contents::Cached(there["b"])), bytes("c", "3")])
    };
    let third = there.open().place(&there.store, &(), keep).unwrap();
    assert_eq!(
        (third.written, third.removed, there.text("b").as_deref()),
        (vec![], vec!["report.json".into()], Some("2"))
    );
    // The file that stayed still belongs to the build.
    assert_eq!(there.place(&[bytes("c", "3")]).removed, ["b"]);
}

#[test]
fn edited_files_stay_and_damaged_files_are_repaired() {
    let there = There::new();
    there.place(&[bytes("a", "1"), bytes("b", "2")]);
    there.write("a", "edited by a person");
    there.write("b", "bro");
    let changes = there.place(&[bytes("b", "2")]);
    assert_eq!((changes.written, changes.left), (vec!["b".to_owned()], vec!["a".to_owned()]));
    assert_eq!(there.text("a").as_deref(), Some("edited by a person"));
    let error = there.open().refuse_foreign(["b", "a"], false).unwrap_err().to_string();
    assert!(error.contains("a: would overwrite a file that no build wrote"), "a belongs to the user: {error}");
    there.open().refuse_foreign(["a"], true).unwrap();
    std::fs::create_dir(there.folder.path().join("c")).unwrap();
    assert!(there.open().refuse_foreign(["c"], true).is_err(), "folders are not replaced");
}

#[test]
fn a_report_lists_the_files_if_the_store_was_deleted() {
    let there = There::new();
    there.place(&[bytes("a", "1")]);
    std::fs::remove_file(there.folder.path().join(FOLDER).join(PLACED)).unwrap();
    let mut folder = there.open();
    assert!(folder.refuse_foreign(["a"], false).is_err());
    let listed = [("a", "1"), ("../a", "1"), ("gone", "1")];
    folder.also_placed(listed.map(|(name, text)| (name.to_owned(), Digest::of(text.as_bytes()))));
    folder.refuse_foreign(["a"], false).unwrap();
    assert_eq!(folder.there().len(), 1);
    there.write("a", "of a person");
    let mut folder = there.open();
    folder.also_placed([("a".to_owned(), Digest::of(b"1"))]);
    assert!(folder.refuse_foreign(["a"], false).is_err());
}

/// On systems where names that differ only in case are one file, removing the old file must not remove the new one.
#[test]
fn old_files_are_removed_before_new_ones_are_moved() {
    let there = There::new();
    there.place(&[bytes("a", "1")]);
    let root = there.folder.path().join(FOLDER);
    let mut journal = Journal::new(&root);
    journal.write("a", b"2").unwrap();
    journal.remove("a");
    journal.commit(there.folder.path(), &root, &write_record(&Placements::default())).unwrap();
    assert_eq!(there.text("a").as_deref(), Some("2"));
}

/// A folder in the way of the last of three files: the first two are moved back by the same process, or by the next
/// if that one was killed.
#[test]
fn failed_moves_are_rolled_back() {
    let there = There::new();
    there.place(&[bytes("a", "old"), bytes("b", "old")]);
    let root = there.folder.path().join(FOLDER);
    let begin = || {
        let mut journal = Journal::new(&root);
        ["a", "c", "d"].iter().for_each(|name| journal.write(name, b"new").unwrap());
        journal.remove("b");
        journal
    };
    let is_as_before = |there: &There| {
        let texts = ["a", "b", "c"].map(|name| there.text(name));
        texts == [Some("old".into()), Some("old".into()), None] && !root.join("commit").exists()
    };
    std::fs::create_dir(there.folder.path().join("d")).unwrap();
    let error = begin().commit(there.folder.path(), &root, &[]).unwrap_err().to_string();
    assert!(error.contains("/d: "), "{error}");
    assert!(is_as_before(&there) && there.folder.path().join("d").is_dir());
    // A damaged list: the files that were moved aside are restored.
    let begun = begin();
    std::fs::create_dir_all(root.join("commit/old")).unwrap();
    std::fs::rename(there.folder.path().join("b"), root.join("commit/old/b")).unwrap();
    std::fs::write(root.join("commit/list"), "damaged").unwrap();
    std::mem::forget(begun);
    there.open();
    assert!(is_as_before(&there));
    // Killed during the rollback, after one file was moved back.
    let begun = begin();
    std::fs::create_dir_all(root.join("commit/old")).unwrap();
    std::fs::write(root.join("commit/back"), write_record(&(vec!["a", "c", "d"], vec!["b"]))).unwrap();
    let path = |name: &str| there.folder.path().join(name);
    for (from, to) in [("a", "commit/old/a"), ("b", "commit/old/b")] {
        std::fs::rename(path(from), root.join(to)).unwrap();
    }
    std::fs::rename(root.join("commit/new/c"), path("c")).unwrap();
    std::mem::forget(begun);
    assert!(OutputFolder::is_unfinished(there.folder.path()));
    there.open();
    assert!(is_as_before(&there));
}

/// Names that the file system rejects fail before any file moves.
#[test]
fn names_that_are_too_long_change_nothing() {
    let there = There::new();
    there.place(&[bytes("a", "old")]);
    let long = "x".repeat(300);
    let files = vec![bytes("a", "new"), bytes(&long, "new")];
    let error = there.open().place(&there.store, &(), |_| Ok(files)).unwrap_err().to_string();
    assert!(error.contains(&long), "{error}");
    assert_eq!(there.text("a").as_deref(), Some("old"));
    assert_eq!(there.place(&[bytes("a", "newer")]).written, ["a"]);
}

/// Killed at any moment: before the list is written, nothing changes; after that, the next process completes all moves.
#[test]
fn the_next_process_completes_listed_moves() {
    let there = There::new();
    there.place(&[bytes("a", "old"), bytes("b", "old"), bytes("report.json", "old")]);
    let root = there.folder.path().join(FOLDER);
    let mut begun = Journal::new(&root);
    begun.write("a", b"new").unwrap();
    std::mem::forget(begun);
    there.open();
    assert_eq!(there.text("a").as_deref(), Some("old"), "no list");
    assert!(!root.join("commit").exists());

    // A list with its files, one of which has already been moved.
    ["commit/new", "commit/old"].iter().for_each(|name| std::fs::create_dir_all(root.join(name)).unwrap());
    std::fs::write(root.join("commit/new/report.json"), "new").unwrap();
    let moves = (vec!["a", "report.json", "../outside"], vec!["b", "../../passwd"]);
    std::fs::write(root.join("commit/list"), write_record(&moves)).unwrap();
    let mut placements = Placements::default();
    placements.files.insert("a".to_owned(), Placed { digest: Digest::of(b"new"), stamp: None });
    placements.files.insert("c".to_owned(), Placed { digest: Digest::of(b"c"), stamp: None });
    std::fs::write(root.join("commit").join(PLACED), write_record(&placements)).unwrap();
    there.write("c", "c");
    assert!(OutputFolder::is_unfinished(there.folder.path()));
    // Files that were just placed belong to the build: the next one may replace them.
    there.open().refuse_foreign(["a", "c"], false).unwrap();
    let texts = ["a", "b", "report.json"].map(|name| there.text(name));
    assert_eq!(texts, [Some("old".into()), None, Some("new".into())]);
    assert!(!root.join("commit").exists() && !there.folder.path().parent().unwrap().join("outside").exists());
}

/// An error after all moves states that the files are in place.
#[test]
fn cleanup_errors_are_not_failed_moves() {
    let there = There::new();
    there.place(&[bytes("a", "old")]);
    let root = there.folder.path().join(FOLDER);
    let mut journal = Journal::new(&root);
    journal.write("b", b"new").unwrap();
    journal.list(&write_record(&Placements::default())).unwrap();
    std::mem::forget(journal);
    // A file cannot be removed as a folder.
    std::fs::remove_dir(root.join("commit/old")).unwrap();
    std::fs::write(root.join("commit/old"), "").unwrap();
    let error = OutputFolder::open(there.folder.path(), &there.store, &()).unwrap_err();
    assert!(error.to_string().ends_with("the files of the folder are in place"), "{error}");
    assert_eq!(there.text("b").as_deref(), Some("new"));
}

/// A link has no stamp, because its target may change without it.
#[cfg(unix)]
#[test]
fn links_are_not_placed_files() {
    let folder = tempfile::tempdir().unwrap();
    let [file, link] = ["file", "a"].map(|name| folder.path().join(name));
    std::fs::write(&file, "1").unwrap();
    let placed = || placed::Placed { digest: Digest::of(b"1"), stamp: None };
    let files = ["file", "a"].map(|name| (name.to_owned(), placed())).into_iter().collect();
    std::os::unix::fs::symlink(&file, link).unwrap();
    let verified = placed::Placements { files }.verified(folder.path());
    assert_eq!(verified.keys().collect::<Vec<_>>(), ["file"]);
}
