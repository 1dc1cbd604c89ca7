//! Records: small internal files in `bincode`, with a checksum over the contents.

use super::digest::Digest;
use brdfc_source::read::read_regular_file;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Identifies the layout of records; it changes when the layout of any record changes.
const MAGIC: [u8; 8] = *b"brdfc r4";
/// Length of a checksum, bytes.
const CHECKSUM: usize = 32;
/// Largest record, bytes. It also bounds the allocations of the decoder.
const LIMIT: usize = 64 << 20;

/// Reads a record; `None` if it is missing, damaged, truncated or of another layout.
pub fn read_record<T: DeserializeOwned>(path: &Path) -> Option<T> {
    parsed(&read_regular_file(path, LIMIT as u64).ok()?)
}

fn parsed<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let (checksum, contents) = bytes.split_at_checked(CHECKSUM)?;
    if Digest::of(contents).bytes() != checksum {
        return None;
    }
    let body = contents.strip_prefix(&MAGIC)?;
    let config = bincode::config::standard().with_limit::<LIMIT>();
    let (value, length) = bincode::serde::decode_from_slice(body, config).ok()?;
    (length == body.len()).then_some(value)
}

/// Returns the bytes of a record.
pub fn write_record(value: &impl Serialize) -> Vec<u8> {
    let mut contents = MAGIC.to_vec();
    contents.extend(bincode::serde::encode_to_vec(value, bincode::config::standard()).expect("records are plain data"));
    [&Digest::of(&contents).bytes()[..], &contents].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_flipped_bit_and_any_truncation_is_detected() {
        let value = (String::from("ratio"), vec![0.5f64, 4.0]);
        let bytes = write_record(&value);
        assert_eq!(parsed::<(String, Vec<f64>)>(&bytes), Some(value));
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(parsed::<(String, Vec<f64>)>(&flipped), None, "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert_eq!(parsed::<(String, Vec<f64>)>(&bytes[..length]), None, "{length} bytes");
        }
        assert_eq!(parsed::<(String, Vec<f64>)>(&[&bytes[..], b"x"].concat()), None);
    }

    #[test]
    fn wrong_lengths_allocate_no_memory() {
        let mut contents = MAGIC.to_vec();
        contents.extend([253, 255, 255, 255, 255, 255, 255, 255, 127]);
        let bytes = [&Digest::of(&contents).bytes()[..], &contents].concat();
        assert_eq!(parsed::<Vec<u8>>(&bytes), None);
    }
}
