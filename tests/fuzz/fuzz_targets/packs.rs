//! Arbitrary bytes, or a valid pack with edits: returns an error, or a pack whose values are finite at every level and filter. The
//! valid packs include the committed packs of all kinds.
#![no_main]

mod edits;

use brdfc_formats::container::seal;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::WaveletPack;
use brdfc_testing::codecs::{flat_btf, of_pack, wavelet};
use brdfc_testing::golden::corpus;
use brdfc_testing::golden::lists::codecs;
use brdfc_testing::packs::sealed;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

/// The committed packs with their names.
static COMMITTED: LazyLock<Vec<(String, Vec<u8>)>> =
    LazyLock::new(|| codecs().into_iter().flat_map(corpus::packs).collect());

fn valid(choice: u8) -> Vec<u8> {
    let parameterisation = Parameterisation::NAMES[usize::from(choice & 1)].1;
    let channels = if choice & 2 == 0 { 1 } else { 3 };
    let bits = if choice & 4 == 0 { 8 } else { 12 };
    let levels = 1 + u32::from(choice >> 3 & 1);
    wavelet::pack(wavelet::header(parameterisation, levels, channels, bits), 3, 1).to_bytes(choice & 16 != 0)
}

fuzz_target!(|data: &[u8]| {
    let Some((choice, rest)) = data.split_first() else { return };
    if choice & 0xc0 == 0x40 {
        // There are more of them than one byte can select.
        let Some((more, rest)) = rest.split_first() else { return };
        let (_, bytes) = &COMMITTED[usize::from(u16::from_le_bytes([*more, choice & 0x3f])) % COMMITTED.len()];
        let mut bytes = bytes.clone();
        edits::edit(&mut bytes, rest);
        // After the checksum.
        seal(&mut bytes);
        let _ = of_pack(&bytes);
        flat_btf::survives(&bytes);
        return;
    }
    let bytes = if choice & 0x80 == 0 {
        let mut bytes = valid(*choice);
        edits::edit(&mut bytes, rest);
        bytes
    } else {
        rest.to_vec()
    };
    let bytes = sealed(bytes);
    let survives = wavelet::survives(&bytes);
    assert!(survives || choice & 0x80 != 0 || rest.len() >= 4, "the edits are lost on a file that was never valid");
    if survives {
        let pack = WaveletPack::from_bytes(&bytes).expect("it was read before");
        let again = WaveletPack::from_bytes(&pack.to_bytes(true)).expect("what is written is read");
        assert_eq!(pack.to_bytes(false), again.to_bytes(false));
    }
});
