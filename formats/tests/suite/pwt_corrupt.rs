//! Corrupt and malicious polynomial wavelet trees: each is rejected, or decodes to finite numbers.

use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates, PWT_ENTRY, PwtDecoder, PwtHeader, PwtPack};
use brdfc_formats::{FormatError, Pack};
use brdfc_testing::codecs::pwt::{example, packs, plain, single};
use brdfc_testing::packs::{read_texture, rebind, sealed};
use std::collections::BTreeMap;

const SECOND: &str = "brdfc.image.pwt_texture_1";

/// Returns true if bytes are a pack after their checksum is updated; its values are then finite everywhere.
fn survives(bytes: &[u8]) -> bool {
    let Ok(pack) = PwtPack::from_bytes(&sealed(bytes.to_vec())) else { return false };
    let decoder = PwtDecoder::new(pack);
    for (uv, level) in [([0.1, 0.9], 0.0), ([1.3, -0.2], 0.6), ([0.5, 0.5], 7.0)] {
        let value = decoder.value(uv, level, [0.0, 0.6, 0.8], [0.6, 0.0, 0.8]);
        assert!(value.iter().all(|c| (0.0..=65504.0).contains(c)), "{value:?}");
    }
    if decoder.unpacked_bytes(0) < 1 << 16 {
        let unpacked = decoder.unpacked(0, 0);
        unpacked.rows(0..unpacked.size()[1], &decoder.pack().header().weights([0.6, 0.0, 0.8]));
    }
    true
}

#[test]
fn every_truncation_is_an_error() {
    for (name, pack) in packs() {
        for bytes in [pack.to_bytes(false), pack.to_bytes(true)] {
            assert!((0..bytes.len()).all(|length| !survives(&bytes[..length])), "{name}");
            assert!(survives(&bytes));
        }
    }
}

#[test]
fn no_single_corrupt_byte_panics() {
    for (name, pack) in packs().into_iter().chain([("example", example())]) {
        for bytes in [pack.to_bytes(false), pack.to_bytes(true)] {
            let mut broken = bytes.clone();
            let mut valid = 0;
            for offset in 0..bytes.len() {
                for pattern in [1, 4, 16, 64, 128, 0xff, 0x7f] {
                    broken[offset] = bytes[offset] ^ pattern;
                    valid += usize::from(survives(&broken));
                }
                broken[offset] = bytes[offset];
            }
            assert!(valid > 0, "{name}: measured errors may change");
        }
    }
}

fn changed(pack: &PwtPack, change: impl FnOnce(&mut BTreeMap<String, Vec<u8>>)) -> FormatError {
    let mut texture = file(pack);
    change(&mut texture.entries);
    let bytes = sealed(texture.to_bytes(false));
    let error = PwtPack::from_bytes(&bytes).unwrap_err();
    assert_eq!(Pack::from_bytes(&bytes).err(), Some(error.clone()));
    error
}

/// The file of a pack as its container.
fn file(pack: &PwtPack) -> Texture {
    read_texture(&pack.to_bytes(false)).unwrap()
}

/// Field and value found, after one word of the header of the example was replaced.
fn with_word(offset: usize, word: u32) -> String {
    let error = changed(&example(), |entries| {
        entries.get_mut(PWT_ENTRY).unwrap()[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
    });
    format!("{}: {}", error.field, error.found)
}

/// Offsets are those of `formats/src/pwt/spec.md`.
#[test]
fn errors_name_the_field() {
    let nan = f32::NAN.to_bits();
    let infinite = f32::NEG_INFINITY.to_bits();
    for (offset, word, expected) in [
        (0, 1, "brdfc.pwt version: 1"),
        (4, 0, "brdfc.pwt size: 0"),
        (8, 8193, "brdfc.pwt size: 8193"),
        (8, u32::MAX, "brdfc.pwt size: 4294967295"),
        (12, 4, "brdfc.pwt extent: 4"),
        (16, 0, "brdfc.pwt extent: 0"),
        (16, u32::MAX, "brdfc.pwt extent: 4294967295"),
        (20, 2, "brdfc.pwt repeats: 2"),
        (24, 13, "brdfc.pwt levels: 13"),
        (24, 2, "brdfc.pwt extent: 2 x 2"),
        (24, u32::MAX, "brdfc.pwt levels: 4294967295"),
        (28, 4, "brdfc.pwt coordinates: 4"),
        (100, 4, "brdfc.pwt side of the light map: 4"),
        (32, 6, "brdfc.pwt degree: 6"),
        (32, u32::MAX, "brdfc.pwt degree: 4294967295"),
        (36, 4, "brdfc.pwt domain: 4"),
        (40, 0, "brdfc.pwt textures: 0"),
        (40, 9, "brdfc.pwt textures: 9"),
        (40, 3, "brdfc.pwt texture level: end of data after 0 of 4 bytes"),
        (44, 1, "brdfc.pwt epsilon: 0.000000000000000000000000000000000000000000001"),
        (36, 3, "brdfc.pwt epsilon: 0"),
        (48, nan, "brdfc.pwt colour: NaN"),
        (80, infinite, "brdfc.pwt colour: -inf"),
        (88, nan, "brdfc.pwt psnr: NaN"),
        (92, infinite, "brdfc.pwt held-out psnr: -inf"),
        (96, (-1f32).to_bits(), "brdfc.pwt delta E: -1"),
        (104, 0, "brdfc.pwt views: 0"),
        (104, 257, "brdfc.pwt views: 257"),
        (104, 5, "direction_mesh_words: no texels"),
        (108, nan, "brdfc.pwt triangle: NaN"),
        (128, infinite, "brdfc.pwt triangle: -inf"),
        (132, 2, "brdfc.pwt texture level: 2"),
        (136, 3, "brdfc.pwt texture channels: 3"),
        (136, 0, "brdfc.pwt texture channels: 0"),
        (140, 129, "brdfc.pwt components: 129"),
        (144, 3, "brdfc.pwt component channel: 3"),
        (148, 3, "brdfc.pwt component term: 3"),
        (152, nan, "brdfc.pwt component scale: NaN"),
        (184, infinite, "brdfc.pwt component low: -inf"),
    ] {
        assert_eq!(with_word(offset, word), expected, "byte {offset}, {word}");
    }
    // Degree 0 has one term, and the term of the second texture does not exist.
    assert!(with_word(32, 0).starts_with("brdfc.pwt "));
    // Valid changes.
    for (offset, word) in [(84, u32::MAX), (88, 0), (24, 1)] {
        let mut texture = file(&example());
        texture.entries.get_mut(PWT_ENTRY).unwrap()[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
        assert!(survives(&texture.to_bytes(false)), "byte {offset}, {word}");
    }
    // A component that differs from the uniform block.
    assert_eq!(with_word(184, 0), "brdfc.uniform.pwt byte 2908: [00, 00, 80, be]");
    let cut = |length: usize| changed(&example(), |entries| entries.get_mut(PWT_ENTRY).unwrap().truncate(length));
    assert_eq!(cut(99).to_string(), "brdfc.pwt length: found 99 bytes, expected 108 bytes or more");
    assert_eq!(cut(187).to_string(), "brdfc.pwt component low: end of data after 3 of 4 bytes; expected 4 bytes");
    let longer = changed(&example(), |entries| entries.get_mut(PWT_ENTRY).unwrap().push(0));
    assert_eq!(longer.to_string(), "brdfc.pwt length: found 189 bytes, expected 188 bytes, as its fields say");
}

/// Learned terms need their map, of the side that the header has.
#[test]
fn the_light_map_follows_from_the_header() {
    const MAP: &str = "brdfc.image.pwt_light_map";
    let all = packs();
    let (_, pack) = all.iter().find(|(name, _)| *name == "image-learned-display").unwrap();
    let missing = changed(pack, |entries| drop(entries.remove(MAP))).to_string();
    assert!(missing.starts_with(MAP), "{missing}");
    for (side, expected) in [
        (0, "brdfc.pwt side of the light map: found 0, expected 4 to 64"),
        (65, "brdfc.pwt side of the light map: found 65, expected 4 to 64"),
        (8, "pwt_light_map: found 6 layers of 4 x 4 texels of Rgba16Float, expected 6 layers of 8 x 8"),
    ] {
        let error = changed(pack, |entries| entries.get_mut(PWT_ENTRY).unwrap()[100] = side).to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn textures_follow_from_the_header() {
    let second = file(&example()).entries[SECOND].clone();
    let missing = changed(&example(), |entries| drop(entries.remove(SECOND)));
    assert_eq!(
        missing.to_string(),
        format!("{SECOND}: missing; expected a key of this name, as brdfc.bindings line 5 says")
    );
    let fourth = "brdfc.image.pwt_texture_3";
    let spare = changed(&example(), |entries| drop(entries.insert(fourth.to_owned(), second.clone())));
    assert_eq!((&*spare.field, &*spare.found), (fourth, "no binding names this key"));
    // Additions of later versions are ignored.
    let mut later = file(&example());
    later.entries.insert("brdfc.later".to_owned(), second.clone());
    assert_eq!(PwtPack::from_bytes(&sealed(later.to_bytes(false))).unwrap(), example());
    let broken = changed(&example(), |entries| entries.get_mut(SECOND).unwrap().truncate(70));
    assert_eq!(broken.field, format!("{SECOND}, container"), "{broken}");

    let with_second = |texture: &Texture| {
        changed(&example(), |entries| drop(entries.insert(SECOND.to_owned(), texture.to_bytes(false)))).to_string()
    };
    let texture = Texture::from_bytes(&second).unwrap();
    let nested = Texture { entries: BTreeMap::from([(PWT_ENTRY.to_owned(), Vec::new())]), ..texture.clone() };
    assert_eq!(with_second(&nested), format!("{SECOND}, keys: found brdfc.pwt, expected no brdfc keys"));
    let wide = Texture { extent: Extent::D2Array([2, 1, 1]), texels: vec![0; 2], ..texture.clone() };
    let said = with_second(&wide);
    assert!(said.starts_with(&format!("{SECOND}: found 1 levels of 1 layers of 2 x 1")), "{said}");
    let flat = Texture { extent: Extent::D2([1, 1]), ..texture.clone() };
    assert!(with_second(&flat).starts_with(&format!("{SECOND}: ")));
    let other = Texture { format: TexelFormat::Rg8Unorm, texels: vec![0; 2], ..texture };
    assert!(with_second(&other).contains("expected 1 levels of "));
    // Matches its binding but not the header.
    let mut rebound = file(&example());
    rebind(
        &mut rebound,
        "pwt_texture_1 texture entry 2d-array r8unorm 1 ",
        "pwt_texture_1 texture entry 2d-array r8unorm 2 ",
    );
    rebound.entries.insert(SECOND.to_owned(), wide.to_bytes(false));
    let error = PwtPack::from_bytes(&sealed(rebound.to_bytes(false))).unwrap_err();
    assert!(error.field == "pwt_texture_1" && error.allowed.ends_with("as brdfc.pwt says"), "{error}");
    // The file's own texture.
    let mut short = file(&example());
    (short.levels, short.texels) = (1, vec![0; 4]);
    let error = PwtPack::from_bytes(&sealed(short.to_bytes(false))).unwrap_err();
    assert!(error.field == "texture" && error.found.starts_with("1 levels"), "{error}");
    // Another kind, or no header.
    let error = changed(&example(), |entries| drop(entries.insert(PWT_ENTRY.to_owned(), Vec::new())));
    assert_eq!(&*error.field, "brdfc.pwt length");
    let error = changed(&example(), |entries| drop(entries.remove(PWT_ENTRY))).to_string();
    assert_eq!(error, "brdfc.pwt: no brdfc keys; expected the keys of a polynomial wavelet tree");
}

/// Sizes that a header can declare but memory cannot hold are rejected before allocation.
#[test]
fn large_headers_are_rejected_early() {
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 0 };
    let header = plain([8192, 8192], [8192, 8192], 0, basis);
    let mut texture = single(0, 0, 1.0, 0.0);
    texture.components = vec![texture.components[0]; 17];
    let error = PwtPack::new(PwtHeader { textures: vec![texture], ..header }, vec![Vec::new()]).unwrap_err();
    assert_eq!(error.to_string(), "brdfc.pwt textures: found 1140850688 bytes of texels, expected at most 1073741824");
    // A file of a few bytes can be a large image; the memory for its decompression is known.
    let coarse = PwtHeader { textures: vec![single(12, 0, 1.0, 0.0)], ..plain([8192; 2], [8192; 2], 12, basis) };
    let pack = PwtPack::new(coarse, vec![vec![255; 4]]).unwrap();
    let bytes = pack.to_bytes(false);
    assert!(bytes.len() < 7000 && survives(&bytes));
    assert_eq!(PwtDecoder::new(pack).unpacked_bytes(0), 4 << 26);
}

#[test]
fn headers_in_memory_are_checked_alike() {
    let good = example().header().clone();
    let refused = |header: PwtHeader| PwtPack::new(header, example_texels()).unwrap_err().to_string();
    for (header, expected) in [
        (PwtHeader { textures: Vec::new(), ..good.clone() }, "brdfc.pwt textures: found 0, expected 1 to 8"),
        (
            PwtHeader { triangle: vec![1.0; 5], ..good.clone() },
            "brdfc.pwt triangle: found 5 numbers, expected 6, as degree requires",
        ),
        (
            PwtHeader { domain: Domain::Logarithm { epsilon: -1.0 }, ..good.clone() },
            "brdfc.pwt epsilon: found -1, expected a positive normal number",
        ),
        (PwtHeader { size: [1, 2], ..good.clone() }, "brdfc.pwt extent: found 2, expected 1 to 1"),
    ] {
        assert_eq!(refused(header), expected);
    }
    let [first, second] = [0, 1].map(|k| example_texels()[k].clone());
    let error = PwtPack::new(good.clone(), vec![first.clone()]).unwrap_err().to_string();
    assert_eq!(error, "textures: found 1, expected 2, as the header says");
    let error = PwtPack::new(good, vec![first, [second.clone(), second].concat()]).unwrap_err().to_string();
    assert_eq!(error, "bytes of texture 1: found 2, expected 1, as the header says");
}

fn example_texels() -> Vec<Vec<u8>> {
    (0..2).map(|k| example().texels(k).to_vec()).collect()
}
