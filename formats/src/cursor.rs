//! Checked little-endian reads from a byte slice, and conversion of words to bytes.

use crate::FormatError;

/// Little-endian words of a uniform block, padded with zeros to `N` bytes.
pub(crate) fn block_bytes<const N: usize>(words: impl IntoIterator<Item = u32>) -> [u8; N] {
    let mut bytes = [0; N];
    for (target, word) in bytes.chunks_exact_mut(4).zip(words) {
        target.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// Read position in a byte slice. Every read checks the remaining length; errors name the field.
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Cursor<'a> {
    /// Starts at byte 0.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    /// Offset of the next byte.
    pub fn position(&self) -> u64 {
        self.position as u64
    }

    /// Bytes not yet read.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// The next `length` bytes.
    pub fn take(&mut self, length: usize, field: &'static str) -> Result<&'a [u8], FormatError> {
        let rest = &self.bytes[self.position..];
        if rest.len() < length {
            return Err(FormatError::at_byte(
                self.position(),
                field,
                format!("end of data after {} of {length} bytes", rest.len()),
                format!("{length} bytes"),
            )
            .problem());
        }
        self.position += length;
        Ok(&rest[..length])
    }

    fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], FormatError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N, field)?);
        Ok(array)
    }

    /// Reads one byte.
    pub fn u8(&mut self, field: &'static str) -> Result<u8, FormatError> {
        Ok(u8::from_le_bytes(self.array(field)?))
    }

    /// Reads an unsigned integer of 2 bytes, little-endian.
    pub fn u16(&mut self, field: &'static str) -> Result<u16, FormatError> {
        Ok(u16::from_le_bytes(self.array(field)?))
    }

    /// Reads an unsigned integer of 4 bytes, little-endian.
    pub fn u32(&mut self, field: &'static str) -> Result<u32, FormatError> {
        Ok(u32::from_le_bytes(self.array(field)?))
    }

    /// Reads a signed integer of 4 bytes, little-endian.
    pub fn i32(&mut self, field: &'static str) -> Result<i32, FormatError> {
        Ok(i32::from_le_bytes(self.array(field)?))
    }

    /// Reads an unsigned integer of 8 bytes, little-endian.
    pub fn u64(&mut self, field: &'static str) -> Result<u64, FormatError> {
        Ok(u64::from_le_bytes(self.array(field)?))
    }

    /// IEEE 754 single, 4 bytes.
    pub fn f32(&mut self, field: &'static str) -> Result<f32, FormatError> {
        Ok(f32::from_le_bytes(self.array(field)?))
    }

    /// IEEE 754 double, 8 bytes.
    pub fn f64(&mut self, field: &'static str) -> Result<f64, FormatError> {
        Ok(f64::from_le_bytes(self.array(field)?))
    }
}
