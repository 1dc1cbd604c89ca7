//! File kinds and their magic bytes.

/// A kind of file that is recognised by its first bytes.
#[derive(Debug)]
pub struct FileKind {
    /// Description with an article, and advice.
    pub description: &'static str,
    /// Extensions of files that are read, in lower case; the usual extension first.
    pub extensions: &'static [&'static str],
    /// Start of the files.
    pub begins: Begins,
}

/// Start of files of one kind.
#[derive(Debug)]
pub enum Begins {
    /// One of these byte sequences.
    With(&'static [&'static [u8]]),
    /// Bytes that fit a file of the given length.
    Fitting(fn(&[u8], u64) -> bool),
    /// Text that this function accepts.
    Text(fn(&str) -> bool),
}

impl FileKind {
    /// Returns true if a file of `length` bytes that begins with `start`, which may be `text`, is of this kind.
    pub(crate) fn is_of(&self, start: &[u8], length: u64, text: Option<&str>) -> bool {
        match self.begins {
            Begins::With(signatures) => signatures.iter().any(|signature| start.starts_with(signature)),
            Begins::Fitting(fits) => fits(start, length),
            Begins::Text(is_of) => text.is_some_and(is_of),
        }
    }
}

/// Returns true if a line of text begins with one of these words.
pub(crate) fn begins_with(line: &str, words: &[&str]) -> bool {
    words.iter().any(|word| line.starts_with(word))
}

/// The first line of text that is neither blank nor a comment.
pub(crate) fn first_line(text: &str) -> &str {
    text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or("")
}
