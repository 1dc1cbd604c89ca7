//! Paths and glob patterns of users.

use crate::error::Error;
use crate::write::or_here;
use fast_glob::glob_match;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use walkdir::{DirEntry, WalkDir};

/// A path or a pattern, relative to a folder. Wildcards in the path of the folder have no meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    folder: PathBuf,
    name: OsString,
}

impl Named {
    /// Creates a path or a pattern from the text of the user.
    pub fn new(folder: impl Into<PathBuf>, name: impl Into<OsString>) -> Self {
        Self { folder: folder.into(), name: name.into() }
    }

    /// The full path, with wildcards as ordinary characters.
    pub fn path(&self) -> PathBuf {
        // Joining an empty name would append a slash.
        if self.name.is_empty() { self.folder.clone() } else { self.folder.join(&self.name) }
    }

    /// Returns true if the name has wildcards and no file or link of that name exists.
    pub fn is_pattern(&self) -> bool {
        has_wildcards(&self.name) && self.path().symlink_metadata().is_err()
    }

    /// The folder that contains all matching files. Also returns true if they can be in its subfolders.
    pub fn base(&self) -> (PathBuf, bool) {
        let (base, rest) = self.split();
        (base, rest.len() > 1)
    }

    /// Splits the path before the first part with a wildcard.
    fn split(&self) -> (PathBuf, Vec<&OsStr>) {
        let parts: Vec<&OsStr> = Path::new(&self.name).iter().collect();
        let plain = parts.iter().take_while(|part| !has_wildcards(part)).count();
        let mut base = self.folder.clone();
        base.extend(&parts[..plain]);
        (base, parts[plain..].to_vec())
    }

    /// Finds all matching files, sorted. `*` and `?` do not match `/` or a leading dot. `**` matches any number of
    /// folders, except hidden folders and links. Dangling links match like files, so that their readers report them.
    ///
    /// # Errors
    /// Returns an error if the pattern is invalid, or if a folder cannot be read.
    pub fn files(&self) -> Result<Vec<PathBuf>, Error> {
        let (base, rest) = self.split();
        let pattern = Pattern::new(&rest, &self.path())?;
        let root = or_here(&base);
        // Links to folders are followed only in patterns of fixed depth: with `**`, a link upwards would repeat all
        // files.
        let walk = WalkDir::new(root).min_depth(1).max_depth(pattern.depth()).follow_links(!pattern.is_deep);
        let mut files = Vec::new();
        let leads_on = |entry: &DirEntry| pattern.may_lead_on(entry.file_name(), entry.depth());
        for entry in walk.into_iter().filter_entry(leads_on) {
            let path = match &entry {
                Ok(entry) => entry.path(),
                Err(error) => match (error.path(), error.io_error()) {
                    (Some(path), Some(error)) if path.is_dir() => return Err(Error::read(path, error)),
                    // A dangling link, a cyclic link that is not a folder, or a missing folder.
                    (Some(path), _) if pattern.may_lead_on(path.file_name().unwrap_or_default(), error.depth()) => path,
                    _ => continue,
                },
            };
            let below = path.strip_prefix(root).unwrap_or(path);
            let matches = glob_match(&pattern.whole, below.as_os_str().as_encoded_bytes());
            if matches && (path.is_file() || is_lost(path)) {
                files.push(base.join(below));
            }
        }
        files.sort();
        Ok(files)
    }
}

/// Returns true for a link that leads to a missing file or to itself.
pub fn is_lost(path: &Path) -> bool {
    path.is_symlink() && path.metadata().is_err()
}

fn has_wildcards(name: &OsStr) -> bool {
    name.to_string_lossy().contains(['*', '?', '[', '{'])
}

/// A pattern below a folder.
struct Pattern {
    whole: String,
    /// For each level before the first `**`: the pattern of a name, and true if the name may begin with a dot.
    levels: Vec<(String, bool)>,
    is_deep: bool,
}

impl Pattern {
    fn new(parts: &[&OsStr], path: &Path) -> Result<Self, Error> {
        let texts: Option<Vec<&str>> = parts.iter().map(|part| part.to_str()).collect();
        let wrong = |what: &str| Error::usage(format!("{}: {what}", path.display()));
        let no_text = || wrong("the pattern is not UTF-8; name files or a folder");
        let texts = texts.ok_or_else(no_text)?;
        let of_parts = texts.iter().find_map(|text| problem(text));
        let back = texts.contains(&"..").then_some(".. after the first wildcard");
        if let Some(problem) = back.or(of_parts) {
            return Err(wrong(&format!("invalid pattern: {problem}; expected a pattern such as scans/*.binary")));
        }
        let plain = texts.iter().take_while(|text| **text != "**");
        let levels: Vec<_> = plain.map(|text| ((*text).to_owned(), text.starts_with('.'))).collect();
        Ok(Self { whole: texts.join("/"), is_deep: levels.len() < texts.len(), levels })
    }

    fn depth(&self) -> usize {
        if self.is_deep { usize::MAX } else { self.levels.len() }
    }

    /// Returns true if an entry with this name at this depth, or a file below it, can match.
    fn may_lead_on(&self, name: &OsStr, depth: usize) -> bool {
        let is_hidden = name.as_encoded_bytes().starts_with(b".");
        match depth.checked_sub(1).map(|level| self.levels.get(level)) {
            None => true,
            Some(None) => !is_hidden,
            Some(Some((level, dotted))) => glob_match(level, name.as_encoded_bytes()) && (*dotted || !is_hidden),
        }
    }
}

/// Finds a syntax error in one part of a pattern. The matcher does not report such errors: it matches nothing.
fn problem(part: &str) -> Option<&'static str> {
    let (mut class, mut braces, mut letters) = (false, 0usize, part.chars().peekable());
    while let Some(letter) = letters.next() {
        match letter {
            '\\' if letters.next().is_none() => return Some("nothing after \\"),
            ']' if class => class = false,
            '[' if !class => {
                class = true;
                letters.next_if(|next| matches!(next, '!' | '^'));
                // A leading `]` is an ordinary character.
                letters.next_if_eq(&']');
            }
            '{' if !class => braces += 1,
            '}' if !class && braces == 0 => return Some("} without {"),
            '}' if !class => braces -= 1,
            _ => {}
        }
    }
    if class {
        return Some("[ without ]");
    }
    (braces > 0).then_some("{ without }")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        folder
    }

    fn matched(folder: &Path, pattern: &str) -> Vec<String> {
        let files = Named::new(folder, pattern).files().unwrap();
        files.iter().map(|file| file.strip_prefix(folder).unwrap().display().to_string()).collect()
    }

    #[test]
    fn patterns_match_as_in_a_shell() {
        let there =
            folder(&["a.brdf", "b.brdf", ".c.brdf", "x/d.brdf", "x/y/e.brdf", ".z/f.brdf", "x/.git/g.brdf", "n.txt"]);
        let matched = |pattern| matched(there.path(), pattern);
        assert_eq!(matched("*.brdf"), ["a.brdf", "b.brdf"]);
        assert_eq!(matched("[!a].brdf"), ["b.brdf"]);
        assert_eq!(matched("./?.brdf"), ["a.brdf", "b.brdf"]);
        assert_eq!(matched(".*.brdf"), [".c.brdf"]);
        assert_eq!(matched("*/*.brdf"), ["x/d.brdf"]);
        assert_eq!(matched(".?/*.brdf"), [".z/f.brdf"]);
        assert_eq!(matched("x/*/*.brdf"), ["x/y/e.brdf"]);
        assert_eq!(matched("**/*.brdf"), ["a.brdf", "b.brdf", "x/d.brdf", "x/y/e.brdf"]);
        assert_eq!(matched("x/**/e.*"), ["x/y/e.brdf"]);
        assert_eq!(matched("{a,n}.*"), ["a.brdf", "n.txt"]);
        assert!(matched("gone/*.brdf").is_empty() && matched("a.brdf/*").is_empty() && matched("x*").is_empty());
        assert!(
            Named::new(there.path(), "{a,x}.brdf").is_pattern() && !Named::new(there.path(), "a.brdf").is_pattern()
        );
        assert!(Named::new(there.path(), "*/../a.brdf").files().is_err());
        for (pattern, problem) in [
            ("[a", "[ without ]"),
            ("[]", "[ without ]"),
            ("{a,*", "{ without }"),
            ("a*}", "} without {"),
            ("*\\", "nothing after \\"),
        ] {
            let error = Named::new(there.path(), pattern).files().unwrap_err().to_string();
            assert!(error.contains(&format!(": invalid pattern: {problem}; expected ")), "{error}");
        }
        assert_eq!(matched("[]a].br{d,e}f"), ["a.brdf"]);
    }

    #[test]
    #[cfg(unix)]
    fn names_that_are_not_utf8_and_dangling_links() {
        use std::os::unix::ffi::OsStrExt;
        let there = folder(&["a.brdf", "[b]/c.brdf"]);
        let odd = there.path().join(OsStr::from_bytes(b"\xff.brdf"));
        std::fs::write(&odd, "").unwrap();
        for dead in ["dead.brdf", ".dead.brdf", "dead.csv"] {
            std::os::unix::fs::symlink("gone", there.path().join(dead)).unwrap();
        }
        std::os::unix::fs::symlink(there.path(), there.path().join("round")).unwrap();
        std::os::unix::fs::symlink("a.brdf", there.path().join("link.brdf")).unwrap();
        std::os::unix::fs::symlink("ring.brdf", there.path().join("ring.brdf")).unwrap();
        let files = Named::new(there.path(), "*.brdf").files().unwrap();
        let named = ["a.brdf", "dead.brdf", "link.brdf", "ring.brdf"].map(|name| there.path().join(name));
        assert_eq!(files, [&named[..], &[odd]].concat());
        assert_eq!(Named::new(there.path(), "**/*.brdf").files().unwrap().len(), 6);
        std::os::unix::fs::symlink("gone", there.path().join("dead?.brdf")).unwrap();
        assert!(!Named::new(there.path(), "dead?.brdf").is_pattern());
        assert_eq!(Named::new(there.path().join("[b]"), "*.brdf").files().unwrap().len(), 1);
        let below = there.path().join(OsStr::from_bytes(b"\xfe"));
        std::fs::create_dir(&below).unwrap();
        std::fs::write(below.join("d.brdf"), "").unwrap();
        assert_eq!(Named::new("", below.join("*.brdf")).files().unwrap(), [below.join("d.brdf")]);
    }
}
