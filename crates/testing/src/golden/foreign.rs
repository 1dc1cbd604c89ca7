//! Alternative files of the same texture or pack, which `formats/src/container/spec.md` allows but `Texture::to_bytes`
//! never writes.

use crate::packs::sealed;
use std::collections::BTreeMap;

/// Names of the forms of [`form`].
pub const FORMS: [&str; 3] = ["entries", "sections", "zstandard"];

/// The sections of a file, without its Zstandard frame.
struct Sections {
    header: Vec<u8>,
    descriptor: Vec<u8>,
    entries: BTreeMap<String, Vec<u8>>,
    /// Texels of each level, from the finest.
    levels: Vec<Vec<u8>>,
}

const ZSTANDARD: u32 = 2;
/// Offset of the level index, and the size of a level in it, bytes.
const INDEX: usize = 80;
const LEVEL: usize = 24;

fn u32_at(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize
}

impl Sections {
    /// Parses a file of our own writer.
    fn of(bytes: &[u8]) -> Self {
        let section = |at: usize| &bytes[u32_at(bytes, at)..][..u32_at(bytes, at + 4)];
        let is_zstandard = u32_at(bytes, 44) as u32 == ZSTANDARD;
        let level = |k: usize| {
            let at = INDEX + k * LEVEL;
            let level = &bytes[u32_at(bytes, at)..][..u32_at(bytes, at + 8)];
            if is_zstandard { zstd::decode_all(level).expect("our own frame") } else { level.to_vec() }
        };
        let levels = (0..u32_at(bytes, 40)).map(level).collect();
        let mut entries = BTreeMap::new();
        let mut rest = section(56);
        while !rest.is_empty() {
            let pair = &rest[4..][..u32_at(rest, 0)];
            let nul = pair.iter().position(|byte| *byte == 0).expect("a key ends with NUL");
            let key = String::from_utf8(pair[..nul].to_vec()).expect("a key is text");
            entries.insert(key, pair[nul + 1..].to_vec());
            rest = &rest[(4 + pair.len()).next_multiple_of(4)..];
        }
        Self { header: bytes[..48].to_vec(), descriptor: section(48).to_vec(), entries, levels }
    }

    /// Bytes of header and level index.
    fn head_bytes(&self) -> usize {
        INDEX + self.levels.len() * LEVEL
    }

    /// Head of the file for sections at these places: offset and length of descriptor, metadata, global data, and of
    /// each level.
    fn head(&self, scheme: u32, places: [[usize; 2]; 3], levels: &[[usize; 2]]) -> Vec<u8> {
        let [descriptor, entries, global] = places;
        let mut head = self.header.clone();
        head[44..].copy_from_slice(&scheme.to_le_bytes());
        head.extend(descriptor.into_iter().chain(entries).flat_map(|n| (n as u32).to_le_bytes()));
        head.extend(global.into_iter().flat_map(|n| (n as u64).to_le_bytes()));
        for (place, texels) in levels.iter().zip(&self.levels) {
            head.extend(place.iter().chain([&texels.len()]).flat_map(|n| (*n as u64).to_le_bytes()));
        }
        head
    }
}

/// Metadata in this order, with this byte in the padding.
fn entry_bytes(entries: &[(String, Vec<u8>)], padding: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (key, value) in entries {
        bytes.extend(((key.len() + 1 + value.len()) as u32).to_le_bytes());
        bytes.extend(key.as_bytes());
        bytes.push(0);
        bytes.extend(value);
        bytes.resize(bytes.len().next_multiple_of(4), padding);
    }
    bytes
}

/// Writes sections in this order, each at the next free byte after a gap: 0 descriptor, 1 metadata, 2 global data, 3
/// levels, the coarsest first.
fn write(
    sections: &Sections,
    scheme: u32,
    parts: [&[u8]; 3],
    stored: &[Vec<u8>],
    order: [(usize, usize); 4],
) -> Vec<u8> {
    let mut places = [[0; 2]; 3];
    let mut levels = vec![[0; 2]; stored.len()];
    let start = sections.head_bytes();
    let mut body = Vec::new();
    for (part, gap) in order {
        body.resize(body.len() + gap, 0xa5);
        if part == 3 {
            for (level, texels) in stored.iter().enumerate().rev() {
                levels[level] = [start + body.len(), texels.len()];
                body.extend(texels);
            }
            continue;
        }
        // Empty sections have offset 0.
        places[part] = if parts[part].is_empty() { [0; 2] } else { [start + body.len(), parts[part].len()] };
        body.extend(parts[part]);
    }
    [sections.head(scheme, places, &levels), body].concat()
}

/// The file with metadata of other writers in reverse order, no orientation, padding that is not zero, and an entry
/// that violates the layout.
fn other_entries(sections: &Sections) -> Vec<u8> {
    let mut entries = sections.entries.clone();
    entries.remove("KTXorientation");
    entries.insert("KTXwriter".to_owned(), b"another writer 2.1\0".to_vec());
    entries.insert("KTXwriterScParams".to_owned(), b"--zcmp 19\0".to_vec());
    entries.insert("org.example.note".to_owned(), b"not ours".to_vec());
    entries.insert("brdfc.of.a.later.version".to_owned(), vec![1, 2, 3]);
    let entries: Vec<(String, Vec<u8>)> = entries.into_iter().rev().collect();
    // A key without an end.
    let broken = [&7u32.to_le_bytes()[..], b"no end!", &[0xff]].concat();
    let bytes = [entry_bytes(&entries[..2], 0xff), broken, entry_bytes(&entries[2..], 0xff)].concat();
    write(sections, 0, [&sections.descriptor, &bytes, &[]], &sections.levels, [(0, 0), (1, 0), (2, 0), (3, 5)])
}

/// The file with its levels first at an odd byte, arbitrary global data, gaps, and bytes after the end.
fn other_sections(sections: &Sections) -> Vec<u8> {
    let entries: Vec<(String, Vec<u8>)> = sections.entries.clone().into_iter().collect();
    let entries = entry_bytes(&entries, 0);
    let order = [(3, 7), (1, 2), (2, 1), (0, 3)];
    let mut bytes = write(sections, 0, [&sections.descriptor, &entries, b"global"], &sections.levels, order);
    bytes.extend([0x5a; 11]);
    bytes
}

/// The file with a frame of another compression level and a checksum, after a gap.
fn other_frame(sections: &Sections) -> Vec<u8> {
    let entries: Vec<(String, Vec<u8>)> = sections.entries.clone().into_iter().collect();
    let mut compressor = zstd::bulk::Compressor::new(19).expect("a level of Zstandard");
    compressor.include_checksum(true).expect("frames may have checksums");
    let mut frame = |texels: &Vec<u8>| compressor.compress(texels).expect("compression into memory does not fail");
    let frames: Vec<Vec<u8>> = sections.levels.iter().map(&mut frame).collect();
    let parts: [&[u8]; 3] = [&sections.descriptor, &entry_bytes(&entries, 0), &[]];
    write(sections, ZSTANDARD, parts, &frames, [(0, 0), (1, 0), (2, 0), (3, 16)])
}

/// Another file of the same texture: form `k` of [`FORMS`], of a file by our own writer.
pub fn form(k: usize, bytes: &[u8]) -> Vec<u8> {
    let sections = Sections::of(bytes);
    sealed([other_entries, other_sections, other_frame][k](&sections))
}

/// A file by our own writer in every other form, with the name of the form appended.
pub fn foreign_forms(name: &str, bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    FORMS.iter().enumerate().map(|(k, form_name)| (format!("{name}-foreign-{form_name}"), form(k, bytes))).collect()
}
