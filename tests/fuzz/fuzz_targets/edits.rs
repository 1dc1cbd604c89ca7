//! Turns fuzz data into edits of a valid file, so that broken files get past magic numbers and lengths.

/// Applies edits of four bytes each: operation, position (two bytes, wrapped into the file), and byte.
pub fn edit(file: &mut Vec<u8>, edits: &[u8]) {
    for &[what, low, high, byte] in edits.as_chunks::<4>().0 {
        if file.is_empty() {
            return;
        }
        let at = usize::from(u16::from_le_bytes([low, high])) % file.len();
        match what % 8 {
            0 => file.truncate(at),
            1 => file.insert(at, byte),
            2 => drop(file.remove(at)),
            3 => file[at] ^= 1 << (byte % 8),
            _ => file[at] = byte,
        }
    }
}
