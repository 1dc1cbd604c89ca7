//! Broken and hostile table packs: each is refused, or is a pack that decodes to numbers.

use brdfc_formats::FormatError;
use brdfc_formats::container::Texture;
use brdfc_formats::table::{Curve, TableDecoder, TablePack};
use brdfc_testing::packs::{pairs, tables};

/// The smallest packs: of both texel formats, with one layer and more, plain and factored.
fn small_packs() -> Vec<TablePack> {
    let names =
        ["symmetry 2, layers 1", "symmetry 1, layers 3", "symmetry 3, layers 1, curve", "symmetry 0, layers 1, curve"];
    tables().into_iter().filter(|(name, _)| names.contains(&name.as_str())).map(|(_, pack)| pack).collect()
}

/// Whether bytes are a pack; then `f_r` is a number wherever it is looked up.
fn survives(bytes: &[u8]) -> bool {
    let Ok(pack) = TablePack::from_bytes(bytes) else { return false };
    let decoder = TableDecoder::new(&pack);
    for pair in pairs(4, 5) {
        let value = decoder.eval_at(pair, 1.3);
        assert!(value.iter().all(|v| v.is_finite() && *v >= 0.0), "{value:?}");
    }
    true
}

#[test]
fn every_truncation_is_an_error() {
    let packs = small_packs();
    assert_eq!(packs.len(), 4);
    for bytes in packs.iter().flat_map(|pack| [pack.to_bytes(false), pack.to_bytes(true)]) {
        assert!((0..bytes.len()).all(|length| TablePack::from_bytes(&bytes[..length]).is_err()));
        assert!(survives(&bytes));
    }
}

#[test]
fn no_single_corrupt_byte_panics() {
    for pack in small_packs() {
        let bytes = pack.to_bytes(false);
        let mut broken = bytes.clone();
        let mut valid = 0;
        for offset in 0..bytes.len() {
            for pattern in [1, 4, 16, 64, 128, 0xff, 0x7f] {
                broken[offset] = bytes[offset] ^ pattern;
                valid += usize::from(survives(&broken));
            }
            broken[offset] = bytes[offset];
        }
        assert!(valid > 0, "the numbers of an error summary may change");
    }
}

fn curve_changed(change: impl Fn(&mut Vec<u8>)) -> FormatError {
    let pack = small_packs().into_iter().find(|pack| pack.curve().is_some()).unwrap();
    let mut texture = Texture::from_bytes(&pack.to_bytes(false)).unwrap();
    change(texture.entries.get_mut("brdfc.table.curve").unwrap());
    TablePack::from_bytes(&texture.to_bytes(false)).unwrap_err()
}

#[test]
fn curves_out_of_range_are_named() {
    let with_word =
        |offset: usize, word: [u8; 4]| curve_changed(|entry| entry[offset..offset + 4].copy_from_slice(&word));
    for nodes in [0, 1, 257, u32::MAX] {
        let error = with_word(0, nodes.to_le_bytes());
        assert_eq!(error.field, "brdfc.table.curve", "{error}");
        assert!(error.allowed.contains(&format!("{nodes} nodes")), "{error}");
    }
    // Halves that are no numbers.
    for halves in [0x7c00_7c00u32, 0xffff_ffff] {
        assert_eq!(with_word(8, halves.to_le_bytes()).field, "brdfc.table.curve texel");
    }
    for levels in [16, u32::MAX] {
        assert_eq!(with_word(4, levels.to_le_bytes()).field, "brdfc.table.curve levels");
    }
    assert_eq!(with_word(4, 1u32.to_le_bytes()).field, "brdfc.table.curve");
    assert_eq!(curve_changed(|entry| entry.truncate(7)).field, "brdfc.table.curve");
    let one_node = curve_changed(|entry| {
        entry[..4].copy_from_slice(&1u32.to_le_bytes());
        entry[4..8].copy_from_slice(&0u32.to_le_bytes());
        entry.truncate(16);
    });
    assert_eq!(format!("{} {}", one_node.field, one_node.found), "brdfc.table.curve nodes 1");
    // A curve of fewer channels than the table has.
    let plain = small_packs().into_iter().find(|pack| pack.curve().is_none() && pack.header().channels == 3).unwrap();
    let grey = Curve::new(1, 0, &[[0.0; 3], [1.0; 3]]).unwrap();
    assert_eq!(plain.with_curve(grey).unwrap_err().field, "brdfc.table.curve");
}
