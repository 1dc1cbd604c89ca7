//! Checks of text files.

use brdfc_formats::FormatError;
use std::borrow::Cow;

/// Longest line and longest record of a table, bytes.
pub(crate) const MAX_LINE_BYTES: usize = 16 << 20;

/// Decodes text, without the byte order mark that some editors write.
///
/// # Errors
/// Returns an error for UTF-16 with a byte order mark, NUL bytes, which mean a binary file, invalid UTF-8, and a line of more
/// than [`MAX_LINE_BYTES`].
pub(crate) fn checked(bytes: &[u8]) -> Result<&str, FormatError> {
    let line_of = |at: usize| 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count() as u64;
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(FormatError::whole("text", "UTF-16", "UTF-8"));
    }
    if let Some(at) = bytes.iter().position(|byte| *byte == 0) {
        let found = format!("NUL byte at byte {at} of the file");
        return Err(FormatError::at_line(line_of(at), "text", found, "text without NUL bytes").problem());
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        FormatError::at_line(line_of(at), "text", format!("byte {:#04x}", bytes[at]), "UTF-8")
    })?;
    let mut start = 0;
    for line in bytes.split(|byte| matches!(byte, b'\n' | b'\r')) {
        if line.len() > MAX_LINE_BYTES {
            return Err(too_long_at(line_of(start)));
        }
        start += line.len() + 1;
    }
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// Characters of the bytes 0x80 to 0x9f in Windows-1252; the unassigned ones are control characters.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}', '‘', '’',
    '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

/// Decodes text as people have it: Windows-1252 if it is not UTF-8, with a Ctrl-Z at its end, and with lines that end with CR
/// alone.
///
/// # Errors
/// Returns the errors of [`checked`] except for invalid UTF-8.
pub(crate) fn of_any_editor(bytes: &[u8]) -> Result<Cow<'_, str>, FormatError> {
    let bytes = bytes.strip_suffix(b"\x1a").unwrap_or(bytes);
    let is_binary = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") || bytes.contains(&0);
    let text = if is_binary || str::from_utf8(bytes).is_ok() {
        Cow::Borrowed(checked(bytes)?)
    } else {
        let of_byte = |byte: &u8| match byte {
            0x80..0xa0 => WINDOWS_1252[usize::from(byte - 0x80)],
            _ => char::from(*byte),
        };
        let text: String = bytes.iter().map(of_byte).collect();
        Cow::Owned(checked(text.as_bytes())?.to_owned())
    };
    let is_alone = |(at, _): (usize, &str)| !text[at + 1..].starts_with('\n');
    if text.match_indices('\r').any(is_alone) {
        return Ok(Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n")));
    }
    Ok(text)
}

/// Decodes text as [`checked`] does, but replaces other bytes than UTF-8 in comments, lines that start with `#`: programs
/// write the names of people and samples there, often in Latin-1.
///
/// # Errors
/// Returns the errors of [`checked`].
pub(crate) fn checked_but_comments(bytes: &[u8]) -> Result<Cow<'_, str>, FormatError> {
    if std::str::from_utf8(bytes).is_ok() || bytes.contains(&0) {
        return checked(bytes).map(Cow::Borrowed);
    }
    let mut repaired = Vec::with_capacity(bytes.len());
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        if line.trim_ascii_start().starts_with(b"#") {
            repaired.extend(String::from_utf8_lossy(line).as_bytes());
        } else {
            repaired.extend(line);
        }
    }
    checked(&repaired).map(|text| Cow::Owned(text.to_owned()))
}

/// Error of a line that is too long.
pub(crate) fn too_long_at(line: u64) -> FormatError {
    FormatError::at_line(line, "text", too_long("line"), allowed_length()).problem()
}

/// Describes a line or a record that is too long, for errors.
pub(crate) fn too_long(what: &str) -> String {
    format!("{what} of more than {}", brdfc_formats::memory::summary(MAX_LINE_BYTES as u64))
}

/// Describes the valid length, for errors.
pub(crate) fn allowed_length() -> String {
    format!("at most {MAX_LINE_BYTES} bytes")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binary_files_are_no_text() {
        let message = |bytes: &[u8]| checked(bytes).unwrap_err().to_string();
        let expected = "line 2, text: NUL byte at byte 3 of the file; expected text without NUL bytes";
        assert_eq!(message(b"a\nb\0\xff"), expected);
        assert_eq!(
            message(b"a\n\xff\0").split_once("; expected").unwrap().0,
            "line 2, text: NUL byte at byte 3 of the file"
        );
        assert_eq!(message(b"a\n\n\xff"), "line 3, text: found byte 0xff, expected UTF-8");
        assert_eq!(checked(b"\xef\xbb\xbfa\r\nb"), Ok("a\r\nb"));
        for bytes in [&b"\xff\xfe1\0\n\0"[..], b"\xfe\xff\x001\0\n"] {
            assert_eq!(message(bytes), "text: found UTF-16, expected UTF-8");
        }
        assert_eq!(message(b"\xff\xd8"), "line 1, text: found byte 0xff, expected UTF-8");
    }

    #[test]
    fn text_of_other_editors() {
        let read = |bytes: &[u8]| of_any_editor(bytes).unwrap().into_owned();
        assert_eq!(read(b"\xef\xbb\xbfa \xc3\xa9\r\nb\x1a"), "a é\r\nb");
        assert_eq!(read(b"Donn\xe9es \x80\n"), "Données €\n");
        assert_eq!(read(b"2\ra\rb"), "2\na\nb");
        assert_eq!(read(b"2\r\na\rb"), "2\na\nb");
        assert_eq!(read(b""), "");
        let message = |bytes: &[u8]| of_any_editor(bytes).unwrap_err().to_string();
        assert_eq!(message(b"\xff\xfe1\0\n\0"), "text: found UTF-16, expected UTF-8");
        assert!(message(b"\xe9\n\0").contains("NUL byte at byte 2"));
    }

    #[test]
    fn comments_may_be_latin_1() {
        let text = checked_but_comments(b"  # Caf\xe9\n1 2\n").unwrap();
        assert_eq!(text, "  # Caf\u{fffd}\n1 2\n");
        assert_eq!(checked_but_comments("# Café\n1".as_bytes()).unwrap(), "# Café\n1");
        let message = |bytes: &[u8]| checked_but_comments(bytes).unwrap_err().to_string();
        assert_eq!(message(b"# \xe9\n1 \xe9\n"), "line 2, text: found byte 0xe9, expected UTF-8");
        assert!(message(b"# \xe9\n\0").starts_with("line 2, text: NUL byte at byte 4"));
        assert!(message(b"\xff\xfe#\0\n\0").contains("UTF-16"));
    }

    #[test]
    fn lines_have_an_end() {
        let mut bytes = vec![b' '; MAX_LINE_BYTES + 2];
        bytes[0] = b'\n';
        let expected = "line 2, text: line of more than 16.00 MiB; expected at most 16777216 bytes";
        assert_eq!(checked(&bytes).unwrap_err().to_string(), expected);
        bytes.truncate(MAX_LINE_BYTES + 1);
        assert!(checked(&bytes).is_ok());
    }
}
