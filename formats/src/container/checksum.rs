//! Checksum of a pack under the key `brdfc.checksum`. It detects damage anywhere in the file.

use crate::FormatError;

/// CRC-32 (the polynomial of zip and PNG) of the whole file, with these four bytes taken as zero.
pub(crate) const ENTRY: &str = "brdfc.checksum";

/// Size of the value, bytes.
pub(crate) const BYTES: usize = 4;

/// Updates the checksum of a pack in place, if it has one. For tools that modify files, and for tests of the other
/// checks.
pub fn seal(bytes: &mut [u8]) {
    if let Some(at) = place(bytes) {
        let sum = sum(bytes, at);
        bytes[at..at + BYTES].copy_from_slice(&sum.to_le_bytes());
    }
}

/// Compares a file with its checksum.
///
/// # Errors
/// Returns an error if the checksum is missing or does not match.
pub(super) fn check(bytes: &[u8], stored: Option<&[u8]>) -> Result<(), FormatError> {
    let (Some(stored), Some(at)) = (stored.and_then(|stored| stored.first_chunk::<BYTES>()), place(bytes)) else {
        return Err(FormatError::whole(ENTRY, "missing or too short", "a value of 4 bytes").problem());
    };
    let (found, stored) = (sum(bytes, at), u32::from_le_bytes(*stored));
    if found == stored {
        return Ok(());
    }
    let allowed = format!("{stored:08x}, as {ENTRY} says; the file is damaged");
    Err(FormatError::whole("checksum of the file", format!("{found:08x}"), allowed))
}

fn sum(bytes: &[u8], at: usize) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..at]);
    hasher.update(&[0; BYTES]);
    hasher.update(&bytes[at + BYTES..]);
    hasher.finalize()
}

/// Offset of the value in the file.
fn place(bytes: &[u8]) -> Option<usize> {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize);
    let (mut at, mut left) = (word(56)?, word(60)?);
    let key = [ENTRY.as_bytes(), &[0]].concat();
    while left >= 4 {
        let length = word(at)?;
        let entry = bytes.get(at + 4..)?.get(..length)?;
        if entry.starts_with(&key) && length == key.len() + BYTES {
            return Some(at + 4 + key.len());
        }
        let step = length.checked_next_multiple_of(4)?.checked_add(4)?;
        at = at.checked_add(step)?;
        left = left.checked_sub(step)?;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bindings::PackFile;
    use crate::importance::{ImportanceHeader, ImportancePack};

    #[test]
    fn every_flipped_bit_is_detected() {
        let header = ImportanceHeader { polar: 2, azimuths: 1, samples: 2 };
        let pack = ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 4]).unwrap();
        for supercompress in [false, true] {
            let bytes = pack.to_bytes(supercompress);
            assert!(PackFile::from_bytes(&bytes).is_ok());
            for bit in 0..8 * bytes.len() {
                let mut flipped = bytes.clone();
                flipped[bit / 8] ^= 1 << (bit % 8);
                assert!(PackFile::from_bytes(&flipped).is_err(), "bit {} of byte {}", bit % 8, bit / 8);
            }
            let mut sealed = bytes.clone();
            seal(&mut sealed);
            assert_eq!(sealed, bytes);
        }
    }
}
