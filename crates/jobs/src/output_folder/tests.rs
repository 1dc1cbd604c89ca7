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
fn the_folder_becomes_what_is_listed() {
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
        Ok(vec![("b".to_owned(), Contents::Kept(there["b"])), bytes("c", "3")])
    };
    let kept = there.open().place(&there.store, &(), keep).unwrap();
    assert_eq!(
        (kept.written, kept.removed, there.text("b").as_deref()),
        (vec![], vec!["report.json".into()], Some("2"))
    );
    // What was kept is still ours.
    assert_eq!(there.place(&[bytes("c", "3")]).removed, ["b"]);
}

#[test]
fn what_a_person_changed_is_left_and_what_broke_is_mended() {
    let there = There::new();
    there.place(&[bytes("a", "1"), bytes("b", "2")]);
    there.write("a", "edited by a person");
    there.write("b", "bro");
    let changes = there.place(&[bytes("b", "2")]);
    assert_eq!((changes.written, changes.left), (vec!["b".to_owned()], vec!["a".to_owned()]));
    assert_eq!(there.text("a").as_deref(), Some("edited by a person"));
    let error = there.open().refuse_foreign(["b", "a"], false).unwrap_err().to_string();
    assert!(error.contains("a: found a file that no build wrote"), "a is a person's now: {error}");
    there.open().refuse_foreign(["a"], true).unwrap();
    std::fs::create_dir(there.folder.path().join("c")).unwrap();
    assert!(there.open().refuse_foreign(["c"], true).is_err(), "no folder is replaced");
}

#[test]
fn a_report_says_what_is_ours_where_the_store_was_deleted() {
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

/// On systems to which two names are one file that differ in case alone, the new file is not to be removed as the old one.
#[test]
fn old_files_go_before_new_ones_come() {
    let there = There::new();
    there.place(&[bytes("a", "1")]);
    let root = there.folder.path().join(FOLDER);
    let mut journal = Journal::new(&root);
    journal.write("a", b"2").unwrap();
    journal.remove("a");
    journal.commit(there.folder.path(), &root, &write_record(&Placements::default())).unwrap();
    assert_eq!(there.text("a").as_deref(), Some("2"));
}

/// A folder in the way of the last of three files: the first two are taken back, by the same run and, where that was killed, by the
/// next.
#[test]
fn what_cannot_be_moved_is_taken_back() {
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
    // A list that cannot be read: what stood aside comes back.
    let begun = begin();
    std::fs::create_dir_all(root.join("commit/old")).unwrap();
    std::fs::rename(there.folder.path().join("b"), root.join("commit/old/b")).unwrap();
    std::fs::write(root.join("commit/list"), "damaged").unwrap();
    std::mem::forget(begun);
    there.open();
    assert!(is_as_before(&there));
    // Killed when the list had become that of what is to be taken back, and one file was.
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

/// What a file system does not take is refused before anything moves.
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

/// Killed at any moment: before the list stands nothing has changed, after that everything will.
#[test]
fn what_was_listed_is_finished_by_the_next() {
    let there = There::new();
    there.place(&[bytes("a", "old"), bytes("b", "old"), bytes("report.json", "old")]);
    let root = there.folder.path().join(FOLDER);
    let mut begun = Journal::new(&root);
    begun.write("a", b"new").unwrap();
    std::mem::forget(begun);
    there.open();
    assert_eq!(there.text("a").as_deref(), Some("old"), "no list");
    assert!(!root.join("commit").exists());

    // A list with its files, one of which was moved already.
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
    // What was just placed is ours: the next build may replace it.
    there.open().refuse_foreign(["a", "c"], false).unwrap();
    let texts = ["a", "b", "report.json"].map(|name| there.text(name));
    assert_eq!(texts, [Some("old".into()), None, Some("new".into())]);
    assert!(!root.join("commit").exists() && !there.folder.path().parent().unwrap().join("outside").exists());
}

/// A failure after all files were moved says that they were.
#[test]
fn what_cannot_be_cleaned_up_is_no_failed_move() {
    let there = There::new();
    there.place(&[bytes("a", "old")]);
    let root = there.folder.path().join(FOLDER);
    let mut journal = Journal::new(&root);
    journal.write("b", b"new").unwrap();
    journal.list(&write_record(&Placements::default())).unwrap();
    std::mem::forget(journal);
    // No folder, so it is not removed as one.
    std::fs::remove_dir(root.join("commit/old")).unwrap();
    std::fs::write(root.join("commit/old"), "").unwrap();
    let error = OutputFolder::open(there.folder.path(), &there.store, &()).unwrap_err();
    assert!(error.to_string().ends_with("the files of the folder are in place"), "{error}");
    assert_eq!(there.text("b").as_deref(), Some("new"));
}
