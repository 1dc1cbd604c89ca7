//! Lists of hashes that pin the written and the decoded data. Tests compare them. With `BRDFC_BLESS` in the environment
//! they write the lists again. The crates of the formats and of the encoders share this.

pub mod corpus;
pub mod encodes;
pub mod foreign;
pub mod lists;
pub mod values;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::PathBuf;

/// Command that writes the lists again.
const COMMAND: &str = "./scripts/bless";
const BLESS: &str = "BRDFC_BLESS";

/// Platforms of hashes that depend only on sums, products, quotients and square roots.
pub const EVERYWHERE: &str = "every platform";
/// Platform of hashes that depend on `ln`, `exp` or trigonometry of the C library.
pub const ONE_PLATFORM: &str = "x86_64-unknown-linux-gnu";

/// Prefix that replaces a hash if a reader refused the pack.
pub const REFUSED: &str = "refused: ";

/// Returns true if a hash is a reader's error.
pub fn is_refusal(hash: &str) -> bool {
    hash.starts_with(REFUSED)
}

/// Folder of a codec's packs and lists, the only place with this path.
pub fn folder(codec: &str) -> PathBuf {
    crate::repository().join("formats/src").join(codec).join("golden")
}

/// Returns true if lists are to be written.
pub fn blessing() -> bool {
    std::env::var_os(BLESS).is_some_and(|value| !value.is_empty() && value != "0")
}

/// Prints a message of blessing on standard error, which tests do not capture.
pub fn tell(text: &str) {
    let _ = writeln!(std::io::stderr(), "golden: {text}");
}

/// A column of hashes, and the platforms on which they are valid.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    pub name: &'static str,
    pub holds_on: &'static str,
}

impl Column {
    pub const fn everywhere(name: &'static str) -> Self {
        Self { name, holds_on: EVERYWHERE }
    }

    pub const fn on_one_platform(name: &'static str) -> Self {
        Self { name, holds_on: ONE_PLATFORM }
    }

    fn holds_here(&self) -> bool {
        const HERE: bool = cfg!(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu"));
        self.holds_on == EVERYWHERE || HERE
    }
}

/// Hashes of one entry by column.
pub type Hashes = BTreeMap<&'static str, String>;
/// Hashes of all entries by name.
pub type Entries = BTreeMap<String, Hashes>;

/// A difference between a hash and the list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    pub entry: String,
    pub column: &'static str,
    pub old: Option<String>,
    pub new: Option<String>,
}

impl Change {
    /// Summary with enough of the hashes to distinguish them.
    fn summary(&self) -> String {
        let short = |hash: &Option<String>| match hash {
            None => "none".to_owned(),
            Some(hash) if hash.len() == 64 => hash[..16].to_owned(),
            Some(text) => text.clone(),
        };
        format!("{} {} -> {}", self.column, short(&self.old), short(&self.new))
    }
}

/// A file of hashes.
pub struct List {
    pub codec: &'static str,
    /// Name of the file in the codec's folder.
    pub file: &'static str,
    /// The comment at its head, a line each.
    pub about: &'static [&'static str],
    pub columns: &'static [Column],
}

const OTHER_PACK: &str = "the pack is not the one that was committed";
/// The table of platforms for each column.
const HOLDS_ON: &str = "holds_on";

impl List {
    /// Name for messages.
    fn name(&self) -> String {
        format!("{}/{}", self.codec, self.file)
    }

    fn path(&self) -> PathBuf {
        folder(self.codec).join(self.file)
    }

    /// Hashes in the file, empty without a file. Ignores columns that no longer exist.
    pub fn read(&self) -> Entries {
        let Ok(text) = std::fs::read_to_string(self.path()) else { return Entries::new() };
        let broken = |what: &str| -> ! { panic!("{}: {what}", self.path().display()) };
        let table: toml::Table = text.parse().unwrap_or_else(|error| broken(&format!("{error}")));
        let hashes = |value: toml::Value| {
            let toml::Value::Table(mut row) = value else { broken("found an entry that is not a table") };
            let hash = |column: &Column| match row.remove(column.name) {
                Some(toml::Value::String(hash)) => Some((column.name, hash)),
                Some(other) => broken(&format!("{}: found {other}, expected a string", column.name)),
                None => None,
            };
            self.columns.iter().filter_map(hash).collect()
        };
        table.into_iter().map(|(name, value)| (name, hashes(value))).collect()
    }

    /// The file's text.
    fn text(&self, entries: &Entries) -> String {
        let mut text: String = self.about.iter().map(|line| format!("# {line}\n")).collect();
        text += &format!("# Written by {COMMAND}; docs/goldens.md says more.\n");
        let mut table = |name: &str, hashes: &Hashes| {
            let is_bare = name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c));
            text += &if is_bare { format!("\n[{name}]\n") } else { format!("\n[\"{name}\"]\n") };
            hashes.iter().for_each(|(column, hash)| text += &format!("{column} = \"{hash}\"\n"));
        };
        table(HOLDS_ON, &entries[HOLDS_ON]);
        entries.iter().filter(|(name, _)| *name != HOLDS_ON).for_each(|(name, hashes)| table(name, hashes));
        text
    }

    /// Entries to be listed: those found, except that columns of other platforms retain their listed values.
    fn expected(&self, listed: &Entries, mut found: Entries) -> Entries {
        for column in self.columns.iter().filter(|column| !column.holds_here()) {
            for (name, hashes) in &mut found {
                hashes.remove(column.name);
                let hash = listed.get(name).and_then(|hashes| hashes.get(column.name));
                hashes.extend(hash.map(|hash| (column.name, hash.clone())));
            }
        }
        let platforms = self.columns.iter().map(|column| (column.name, column.holds_on.to_owned()));
        found.insert(HOLDS_ON.to_owned(), platforms.collect());
        found
    }

    /// Compares hashes with the list, or writes the list. `more` adds to the message of a failure.
    pub fn check(&self, found: Entries, more: impl FnOnce(&[Change]) -> String) {
        let elsewhere = self.columns.iter().filter(|column| !column.holds_here());
        let elsewhere: Vec<&str> = elsewhere.map(|column| column.name).collect();
        if !elsewhere.is_empty() {
            println!("skipped: {}: {} of {ONE_PLATFORM} alone", self.name(), elsewhere.join(", "));
        }
        let listed = self.read();
        let expected = self.expected(&listed, found);
        let changes = changes(&listed, &expected);
        if blessing() {
            self.bless(&expected, &changes);
        } else if !changes.is_empty() {
            panic!("{}{}\nIf the change is intended, run {COMMAND}\n", self.explain(&changes), more(&changes));
        }
    }

    fn bless(&self, expected: &Entries, changes: &[Change]) {
        let name = self.name();
        if let Some(change) = changes.iter().find(|change| change.new.as_deref().is_some_and(is_refusal)) {
            panic!("{name}: {} cannot be blessed: {}", change.entry, change.summary());
        }
        let is_other = |change: &&Change| change.column == "file" && change.old.is_some() && change.new.is_some();
        if let Some(change) = changes.iter().filter(|_| self.is_of_committed_packs()).find(is_other) {
            panic!("{name}: {} cannot be blessed: {OTHER_PACK}; give it another name", change.entry);
        }
        let text = self.text(expected);
        // The comment alone may have changed.
        if std::fs::read_to_string(self.path()).is_ok_and(|old| old == text) {
            return tell(&format!("{name}: no change"));
        }
        changes.iter().for_each(|change| tell(&format!("{name}: {}: {}", change.entry, change.summary())));
        std::fs::create_dir_all(folder(self.codec)).expect("the codec's folder can be made");
        std::fs::write(self.path(), text).unwrap_or_else(|error| panic!("{}: {error}", self.path().display()));
        tell(&match changes.len() {
            0 => format!("{name}: no hash changed; other text did"),
            count => format!("{name}: hashes that changed: {count}"),
        });
    }

    /// Describes the changed entries, and whether the encoder or the decoder changed.
    pub fn explain(&self, changes: &[Change]) -> String {
        let mut moved: BTreeMap<&str, Vec<&Change>> = BTreeMap::new();
        changes.iter().for_each(|change| moved.entry(&change.entry).or_default().push(change));
        let mut text = format!("{}: changed entries: {}\n", self.path().display(), moved.len());
        for (entry, changes) in moved {
            text += &format!("  {entry}: {}\n", self.verdict(&changes));
            changes.iter().for_each(|change| text += &format!("      {}\n", change.summary()));
        }
        text
    }

    /// Conclusion from the changed columns of one entry.
    ///
    /// `contents` is the data that an encoder stores. If it is unchanged, so is the encoder. `file` has more: measured
    /// errors, which depend on the decoder, and the container. Committed packs have no `contents`, since their files do
    /// not change.
    fn verdict(&self, changes: &[&Change]) -> &'static str {
        let moved = |column: &str| changes.iter().any(|change| change.column == column);
        let values = moved("values") || moved("reflectances");
        if changes[0].entry == HOLDS_ON {
            "the columns or their platforms changed"
        } else if changes.iter().all(|change| change.old.is_none()) {
            "not in the list"
        } else if changes.iter().all(|change| change.new.is_none()) {
            "only in the list"
        } else if self.is_of_committed_packs() && moved("file") {
            OTHER_PACK
        } else if moved("contents") && values {
            "bytes and values changed: the encoder stores other data"
        } else if moved("contents") {
            "bytes changed, values did not: the encoder stores the same values in another way"
        } else if values {
            "values changed, stored data did not: the decoder changed"
        } else if moved("errors") {
            "measured errors changed, stored data and values did not"
        } else {
            "bytes of the file changed, stored data and values did not: the container or Zstandard changed"
        }
    }

    fn is_of_committed_packs(&self) -> bool {
        self.columns.iter().all(|column| column.name != "contents")
    }
}

/// All differences.
pub fn changes(listed: &Entries, found: &Entries) -> Vec<Change> {
    let names: BTreeSet<&String> = listed.keys().chain(found.keys()).collect();
    let mut changes = Vec::new();
    for name in names {
        let hashes = |entries: &Entries| entries.get(name).cloned().unwrap_or_default();
        let (old, new) = (hashes(listed), hashes(found));
        let columns: BTreeSet<&'static str> = old.keys().chain(new.keys()).copied().collect();
        for column in columns.into_iter().filter(|column| old.get(column) != new.get(column)) {
            let (old, new) = (old.get(column).cloned(), new.get(column).cloned());
            changes.push(Change { entry: name.clone(), column, old, new });
        }
    }
    changes
}

/// The hash of bytes.
pub fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}
