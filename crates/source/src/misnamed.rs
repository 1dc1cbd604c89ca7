//! Files whose contents do not match their extensions.

use super::error::InputError;
use super::read::extension_of;
use brdfc_formats::FormatError;
use brdfc_readers::recognise::recognise;
use std::path::Path;

/// Creates the error of a file that violates the layout of its extension, with a hint if its contents look like another
/// kind.
pub(crate) fn wrong_contents(path: &Path, start: &[u8], length: u64, error: FormatError) -> InputError {
    match recognise(start, length) {
        Some(kind) if !kind.extensions.contains(&extension_of(path).as_str()) => InputError::Misnamed {
            name: path.display().to_string(),
            error: Box::new(error),
            looks_like: kind.description,
        },
        _ => InputError::format(path, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misnamed_files_get_a_hint() {
        let message = |name: &str, bytes: &[u8]| {
            let error = FormatError::whole("magic", "x", "y");
            wrong_contents(Path::new(name), bytes, bytes.len() as u64, error).to_string()
        };
        let png = b"\x89PNG\r\n\x1a\n";
        assert_eq!(message("a.binary", png), "a.binary: magic: found x, expected y; it looks like a PNG image (.png)");
        assert_eq!(message("a.PNG", png), "a.PNG: magic: found x, expected y");
        assert!(message("a.brdf", b"theta_i,r\n").ends_with("; it looks like a scan or a list of directions (.csv)"));
        assert!(message("a.binary", b"2\n450 650\n").ends_with("; it looks like a scan as text (.brdf)"));
        // Any text may be meant for any text format.
        assert_eq!(message("a.csv", b"what is this?\n"), "a.csv: magic: found x, expected y");
        assert!(message("a.ktx2", b"what is this?\n").ends_with("; it looks like text"));
        assert_eq!(message("a.ktx2", b"\0\0\0\0"), "a.ktx2: magic: found x, expected y");
    }
}
