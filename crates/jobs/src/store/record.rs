//! Small files of our own: `bincode` behind a checksum over all that they say.

use super::digest::Digest;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Changes with the layout of any record.
const MAGIC: [u8; 8] = *b"brdfc r2";
/// Bytes of a checksum.
const CHECKSUM: usize = 32;
/// More is no record of ours. Memory is asked for within that.
const LIMIT: usize = 64 << 20;

/// The value of a record: `None` where there is none, or where it is broken, truncated or of another layout.
pub fn read_record<T: DeserializeOwned>(path: &Path) -> Option<T> {
    if std::fs::metadata(path).ok()?.len() > LIMIT as u64 {
        return None;
    }
    parsed(&std::fs::read(path).ok()?)
}

fn parsed<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let (checksum, said) = bytes.split_at_checked(CHECKSUM)?;
    if Digest::of(said).bytes() != checksum {
        return None;
    }
    let body = said.strip_prefix(&MAGIC)?;
    let config = bincode::config::standard().with_limit::<LIMIT>();
    let (value, length) = bincode::serde::decode_from_slice(body, config).ok()?;
    (length == body.len()).then_some(value)
}

/// The bytes of a record.
pub fn write_record(value: &impl Serialize) -> Vec<u8> {
    let mut said = MAGIC.to_vec();
    said.extend(bincode::serde::encode_to_vec(value, bincode::config::standard()).expect("records are plain data"));
    [&Digest::of(&said).bytes()[..], &said].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_flipped_bit_and_any_cut_is_seen() {
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
    fn lengths_that_lie_ask_for_no_memory() {
        let mut said = MAGIC.to_vec();
        said.extend([253, 255, 255, 255, 255, 255, 255, 255, 127]);
        let bytes = [&Digest::of(&said).bytes()[..], &said].concat();
        assert_eq!(parsed::<Vec<u8>>(&bytes), None);
    }
}
