//! Words of text before binary data, as `.ptm` and `.rti` files have them.

use super::scan::{number, quoted};
use brdfc_formats::FormatError;

/// Maximum width and height, pixels.
pub(crate) const MAX_SIZE: u32 = 1 << 16;

/// Words of a header, separated by white space, and the bytes after it.
pub(crate) struct Words<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) at: usize,
    pub(crate) line: u64,
    /// Description of a complete header, for errors.
    pub(crate) whole: &'static str,
}

impl<'a> Words<'a> {
    /// Longest word, bytes. No header has longer ones.
    const LONGEST: usize = 256;

    /// Reads the next word.
    ///
    /// # Errors
    /// Returns an error at the end of the data, and for a word that is too long or not ASCII.
    pub(crate) fn word(&mut self, field: &'static str) -> Result<&'a str, FormatError> {
        while let Some(byte) = self.bytes.get(self.at).filter(|byte| byte.is_ascii_whitespace()) {
            self.line += u64::from(*byte == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let word = rest.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        if word.is_empty() {
            return Err(self.wrong(field, "end of data", self.whole).problem());
        }
        self.at += word.len();
        let text = std::str::from_utf8(&word[..word.len().min(Self::LONGEST)]).ok();
        let text = text.filter(|text| text.len() == word.len() && text.bytes().all(|byte| byte.is_ascii_graphic()));
        text.ok_or_else(|| self.wrong(field, "no text", "a word of ASCII characters").problem())
    }

    /// Reads a whole number in decimal digits, in a range.
    ///
    /// # Errors
    /// Same as [`Self::word`]. Also returns an error for any other word.
    pub(crate) fn digits(
        &mut self,
        field: &'static str,
        range: std::ops::RangeInclusive<u32>,
    ) -> Result<u32, FormatError> {
        let word = self.word(field)?;
        // Parsing accepts a sign.
        let is_digits = word.bytes().all(|byte| byte.is_ascii_digit());
        let number = word.parse::<u32>().ok().filter(|number| is_digits && range.contains(number));
        number.ok_or_else(|| self.wrong(field, quoted(word), format!("{} to {}", range.start(), range.end())))
    }

    /// Reads a whole number of 32 bits. Some programs write whole numbers with decimals.
    ///
    /// # Errors
    /// Same as [`Self::word`]. Also returns an error for any other word.
    pub(crate) fn whole_number(&mut self, field: &'static str) -> Result<i32, FormatError> {
        let word = self.word(field)?;
        let value = number(word, self.line, field)?;
        let whole = value.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&value);
        if whole { Ok(value as i32) } else { Err(self.wrong(field, quoted(word), "a whole number of 32 bits")) }
    }

    /// Returns the bytes after the line end that follows the last word, which `after` describes.
    ///
    /// # Errors
    /// Returns an error if anything else follows the last word.
    pub(crate) fn end(mut self, after: &str) -> Result<&'a [u8], FormatError> {
        while self.bytes.get(self.at).is_some_and(|byte| matches!(byte, b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
        let allowed = format!("a line end after {after}");
        match self.bytes[self.at..].split_first() {
            Some((b'\n', rest)) => Ok(rest),
            Some((byte, _)) => Err(self.wrong("header", format!("byte {byte:#04x}"), allowed)),
            None => Err(self.wrong("header", "end of data", allowed).problem()),
        }
    }

    pub(crate) fn wrong(
        &self,
        field: &'static str,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> FormatError {
        FormatError::at_line(self.line, field, found, allowed)
    }
}

/// Checks a size, and returns the number of pixels.
pub(crate) fn pixel_count(size: [u32; 2]) -> Result<u64, FormatError> {
    for (side, field) in size.into_iter().zip(["width", "height"]) {
        FormatError::check_range(field, side, 1..=MAX_SIZE)?;
    }
    Ok(u64::from(size[0]) * u64::from(size[1]))
}
