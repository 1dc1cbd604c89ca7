//! Packs that were cut or changed on the way.

use super::{accepted, bad_file};
use crate::common::cli::Folder;
use brdfc_formats::container::seal;

fn pack(more: &[&str]) -> Vec<u8> {
    let folder = Folder::new();
    folder.run(&[&["encode", "synth:ward", "-o", "p.ktx2", "--grid", "4"][..], more].concat()).succeeded();
    folder.read("p.ktx2")
}

fn word(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

/// A file with another word, and the checksum that it needs.
fn with_word(mut bytes: Vec<u8>, at: usize, value: u32) -> Vec<u8> {
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    seal(&mut bytes);
    bytes
}

/// Byte offset of the value of an entry.
fn entry(bytes: &[u8], key: &str) -> usize {
    let needle = [key.as_bytes(), &[0]].concat();
    bytes.windows(needle.len()).position(|window| window == needle).unwrap() + needle.len()
}

#[test]
fn packs_cut_at_every_boundary() {
    for more in [&[][..], &["--no-supercompression"]] {
        let bytes = pack(more);
        let [descriptor, entries] = [48, 56].map(|at| word(&bytes, at));
        let entries_end = entries + word(&bytes, 60);
        let level = word(&bytes, 80);
        let keys = ["brdfc.bindings", "brdfc.checksum", "brdfc.image.wavelet_brdf_index", "brdfc.wavelet.errors"];
        let values = keys.map(|key| entry(&bytes, key));
        let fixed = [1, 11, 12, 13, 20, 32, 44, 48, 64, 80, 96, 104, descriptor, descriptor + 4, entries, entries + 4];
        for length in fixed.into_iter().chain(values).chain([entries_end, level, level + 1, bytes.len() - 1]) {
            let mut cut = bytes[..length].to_vec();
            bad_file("p.ktx2", &cut, &[]);
            seal(&mut cut);
            bad_file("p.ktx2", &cut, &[]);
        }
        assert_eq!(accepted("p.ktx2", &bytes)["kind"], "wavelet-pack");
    }
}

#[test]
fn fields_of_the_container() {
    for (at, value, expected) in [
        (12, 0, "byte 12, vkFormat: found "),
        (12, 43, "byte 12, vkFormat: found 43, expected 9, 16, 37, "),
        (20, 0, "container: zero pixel width"),
        (20, u32::MAX, "byte 20, pixelWidth: found 4294967295, expected 1 to 2048"),
        (20, 8, ""),
        (28, 2048, ""),
        (32, 7, "byte 32, layerCount: found 7, expected 0"),
        (44, 1, "byte 44, supercompressionScheme: found 1, expected 0 (none) or 2 (Zstandard)"),
        (80, u32::MAX, ""),
        (88, u32::MAX, ""),
        (96, 5, "uncompressedByteLength: found 5, expected "),
    ] {
        bad_file("p.ktx2", &with_word(pack(&[]), at, value), &[expected]);
    }
}

#[test]
fn fields_of_the_header() {
    let bytes = pack(&[]);
    let header = entry(&bytes, "brdfc.wavelet");
    for (field, value, expected) in [
        (0, 1, "brdfc.wavelet version: found 1, expected 2"),
        (1, 9, "parameterisation: found 9, expected 0 (tangent-pole) or 1"),
        (2, 0, "levels: found 0, expected 1 to 6"),
        (2, 3, "texture: found "),
        (3, 3, "stored levels: found 3, expected 0 to the number of levels"),
        (4, 2, "channels: found 2, expected 1 or 3"),
        (5, 9, "bits: found 9, expected 8, or 10 to 16"),
        (6, 1, "slices: found 1, expected 2 to 2048"),
        (6, 6, "texture: found "),
        (7, f32::NAN.to_bits(), "mean: found NaN, expected a positive number"),
        (7, f32::INFINITY.to_bits(), "mean: found inf, expected a positive number"),
        (8, (-1f32).to_bits(), "bias: found -1, expected a positive number"),
        (9, 2, "energy-preserving: found 2, expected 0, or 1"),
    ] {
        bad_file("p.ktx2", &with_word(bytes.clone(), header + 4 * field, value), &[expected]);
    }
    let errors = entry(&bytes, "brdfc.wavelet.errors");
    bad_file("p.ktx2", &with_word(bytes, errors + 4, f32::NAN.to_bits()), &["brdfc.wavelet.errors: found NaN"]);
}

#[test]
fn texels_of_the_index_map() {
    let bytes = pack(&["--no-supercompression"]);
    let image = entry(&bytes, "brdfc.image.wavelet_brdf_index");
    let texels = image + word(&bytes, image + 80);
    for (at, value, expected) in [
        (0, 0.0, "coefficient 0, slice: found 0, expected 1, the scaling slice"),
        (4, f32::NAN, "coefficient 0, scale and offset: found NaN and"),
        (16, 60_000.0, "coefficient 1, slice: found 60000, expected 0 or 2"),
    ] {
        let expected = format!("wavelet_brdf_index {expected}");
        bad_file("p.ktx2", &with_word(bytes.clone(), texels + at, f32::to_bits(value)), &[&expected]);
    }
}

#[test]
fn any_changed_byte_is_refused_or_harmless() {
    let bytes = pack(&["--ratio", "16"]);
    let folder = Folder::new();
    let code = |changed: &[u8]| {
        folder.write("p.ktx2", changed);
        let ran = folder.run(&["info", "p.ktx2"]);
        assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
        ran.code
    };
    // A spread of bytes; the readers' own tests go through all of them.
    for at in (0..bytes.len()).step_by(23) {
        let mut changed = bytes.clone();
        changed[at] ^= 0xff;
        assert_eq!(code(&changed), 3, "byte {at}");
        seal(&mut changed);
        assert!([0, 3].contains(&code(&changed)), "byte {at}, sealed");
    }
}
