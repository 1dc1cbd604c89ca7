//! Packs that were cut or changed on the way.

use super::{accepted, bad_file};
use crate::common::cli::Folder;

fn pack(more: &[&str]) -> Vec<u8> {
    let folder = Folder::new();
    folder.run(&[&["encode", "synth:ward", "-o", "p.ktx2", "--grid", "4"][..], more].concat()).succeeded();
    folder.read("p.ktx2")
}

fn word(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

fn with_word(mut bytes: Vec<u8>, at: usize, value: u32) -> Vec<u8> {
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
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
        let keys = ["brdfc.wavelet", "brdfc.wavelet.index", "brdfc.wavelet.scales", "brdfc.wavelet.errors"];
        let values = keys.map(|key| entry(&bytes, key));
        let fixed = [1, 11, 12, 13, 20, 32, 44, 48, 64, 80, 96, 104, descriptor, descriptor + 4, entries, entries + 4];
        for length in fixed.into_iter().chain(values).chain([entries_end, level, level + 1, bytes.len() - 1]) {
            bad_file("p.ktx2", &bytes[..length], &[]);
        }
        assert_eq!(accepted("p.ktx2", &bytes)["kind"], "wavelet-pack");
    }
}

#[test]
fn fields_of_the_container() {
    for (at, value, expected) in [
        (12, 0, "byte 12, vkFormat: found "),
        (12, 43, "byte 12, vkFormat: found 43; allowed 9, 16, 37, "),
        (20, 0, "container: found zero pixel width"),
        (20, u32::MAX, "byte 20, pixelWidth: found 4294967295; allowed 1 to 2048"),
        (20, 8, ""),
        (28, 2048, ""),
        (32, 7, "byte 32, layerCount: found 7; allowed 0"),
        (44, 1, "byte 44, supercompressionScheme: found 1; allowed 0 (none) or 2 (Zstandard)"),
        (80, u32::MAX, ""),
        (88, u32::MAX, ""),
        (96, 5, "uncompressedByteLength: found 5; allowed "),
    ] {
        bad_file("p.ktx2", &with_word(pack(&[]), at, value), &[expected]);
    }
}

#[test]
fn fields_of_the_header() {
    let bytes = pack(&[]);
    let header = entry(&bytes, "brdfc.wavelet");
    for (field, value, expected) in [
        (0, 2, "brdfc.wavelet version: found 2; allowed 1"),
        (1, 9, "parameterisation: found 9; allowed 0 (tangent-pole) or 1"),
        (2, 0, "levels: found 0; allowed 1 to 6"),
        (2, 3, "texture: found "),
        (3, 3, "stored levels: found 3; allowed 0 to the number of levels"),
        (4, 2, "channels: found 2; allowed 1 or 3"),
        (5, 9, "bits: found 9; allowed 8, or 10 to 16"),
        (6, 1, "slices: found 1; allowed 2 to 2048"),
        (6, 6, "texture: found "),
        (7, f32::NAN.to_bits(), "mean: found NaN; allowed a positive number"),
        (7, f32::INFINITY.to_bits(), "mean: found inf; allowed a positive number"),
        (8, (-1f32).to_bits(), "bias: found -1; allowed a positive number"),
        (9, 2, "lifted: found 2; allowed 0, or 1"),
    ] {
        bad_file("p.ktx2", &with_word(bytes.clone(), header + 4 * field, value), &[expected]);
    }
    let index = entry(&bytes, "brdfc.wavelet.index");
    bad_file("p.ktx2", &with_word(bytes.clone(), index, 0), &["entry 0: found 0; allowed 1, the scaling slice"]);
    bad_file("p.ktx2", &with_word(bytes.clone(), index, 1 | 60_000 << 16), &["entry 1: found 60000; allowed 0 or 2"]);
    let scales = entry(&bytes, "brdfc.wavelet.scales");
    bad_file("p.ktx2", &with_word(bytes.clone(), scales, 1f32.to_bits()), &["slice 0: found scale 1"]);
    bad_file("p.ktx2", &with_word(bytes.clone(), scales + 8, f32::NAN.to_bits()), &["slice 1: found scale NaN"]);
    let errors = entry(&bytes, "brdfc.wavelet.errors");
    bad_file("p.ktx2", &with_word(bytes, errors + 4, f32::NAN.to_bits()), &["brdfc.wavelet.errors: found NaN"]);
}

#[test]
fn any_changed_byte_is_refused_or_harmless() {
    let bytes = pack(&["--ratio", "16"]);
    let folder = Folder::new();
    // A spread of bytes; the readers' own tests go through all of them.
    for at in (0..bytes.len()).step_by(23) {
        let mut changed = bytes.clone();
        changed[at] ^= 0xff;
        folder.write("p.ktx2", &changed);
        let ran = folder.run(&["info", "p.ktx2"]);
        assert!([0, 3].contains(&ran.code) && !ran.stderr.contains("panicked"), "byte {at}: {}", ran.stderr);
    }
}
