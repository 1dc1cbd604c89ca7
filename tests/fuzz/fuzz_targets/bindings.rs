//! Arbitrary bytes, a committed pack with edits, or one with edits in its list of bindings: returns an error, or bindings that can
//! be written and read again, for any codec.
#![no_main]

mod edits;

use brdfc_formats::bindings::PackFile;
use brdfc_testing::golden::corpus;
use brdfc_testing::golden::lists::codecs;
use brdfc_testing::packs::{BINDINGS_ENTRY, read_texture, sealed};
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

/// The committed packs.
static COMMITTED: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let files = codecs().into_iter().flat_map(|codec| corpus::packs(codec).into_values());
    files.filter(|bytes| PackFile::from_bytes(bytes).is_ok()).collect()
});

fuzz_target!(|data: &[u8]| {
    let [choice, low, high, rest @ ..] = data else { return };
    let mut bytes = COMMITTED[usize::from(u16::from_le_bytes([*low, *high])) % COMMITTED.len()].clone();
    match choice % 3 {
        0 => bytes = rest.to_vec(),
        1 => edits::edit(&mut bytes, rest),
        _ => {
            let mut texture = read_texture(&bytes).expect("a committed pack");
            let Some(list) = texture.entries.get_mut(BINDINGS_ENTRY) else { return };
            edits::edit(list, rest);
            bytes = texture.to_bytes(false);
        }
    }
    let Ok(read) = PackFile::from_bytes(&sealed(bytes)) else {
        assert!(choice % 3 == 0 || rest.len() >= 4, "the edits are lost on a file that was never valid");
        return;
    };
    let written = read.bindings.to_file(read.entries.clone(), true);
    assert_eq!(PackFile::from_bytes(&written).expect("what is written is read"), read);
});
