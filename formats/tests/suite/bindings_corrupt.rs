//! Bindings of packs: round trips, violations of each rule of the list and of the data that it names, and detection of
//! any flipped bit.

use brdfc_formats::bindings::{Binding, Bindings, MAX_BINDINGS, PackFile, Texels};
use brdfc_formats::container::{Extent, PackedTexture, TexelFormat, Texture};
use brdfc_formats::{FormatError, Pack, PackKind};
use brdfc_testing::codecs::tested;
use brdfc_testing::packs::{BINDINGS_ENTRY, change_image, read_texture, rebind, sealed};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Bindings of a fictitious codec: a block, textures of all storage kinds and dimensions, a sampler.
fn marble() -> Bindings<'static> {
    const SAMPLER: &str = "marble_sampler";
    let veins = Texels::new(TexelFormat::R8Unorm, Extent::D2([4, 2]), (0..11).collect::<Vec<u8>>());
    let words = Texels::new(TexelFormat::R32Uint, Extent::D2Array([2, 1, 2]), (0..16).collect::<Vec<u8>>());
    let curve = Texels::new(TexelFormat::Rgba16Float, Extent::D2([3, 1]), vec![60; 24]);
    let sky = Texels::new(TexelFormat::R8Unorm, Extent::Cube(2), (0..30).collect::<Vec<u8>>()).with_levels(2);
    let all = [
        Binding::frame(),
        Binding::uniform(40, "marble_sizes", vec![7; 32]),
        Binding::texture(41, "marble_veins", veins.with_levels(3).of_file().sampled(SAMPLER)),
        Binding::texture(42, "marble_words", words),
        Binding::texture(43, "marble_curve", curve.sampled(SAMPLER)),
        Binding::sampler(44, SAMPLER, true),
        Binding::texture(50, "marble_unused", Texels::empty(TexelFormat::Rg8Unorm, Extent::D3([1; 3]))),
        Binding::texture(51, "marble_sky", sky.sampled(SAMPLER)),
        Binding::texture(52, "marble_night", Texels::empty(TexelFormat::Rg8Unorm, Extent::Cube(1))),
    ];
    Bindings::new("marble", 1, all)
}

const WORDS: &str = "brdfc.image.marble_words";

/// Key/value data of the fictitious codec itself.
fn own() -> BTreeMap<String, Vec<u8>> {
    BTreeMap::from([("brdfc.marble".to_owned(), vec![1, 2, 3])])
}

/// The file as a texture whose key/value data tests can change.
fn texture() -> Texture {
    read_texture(&marble().to_file(own(), false)).unwrap()
}

fn refusal(texture: &Texture) -> FormatError {
    let [plain, packed] = [false, true].map(|supercompress| {
        let bytes = sealed(texture.to_bytes(supercompress));
        PackFile::from_bytes(&bytes).expect_err("a broken rule")
    });
    assert_eq!(plain, packed);
    plain
}

#[test]
fn files_round_trip() {
    for supercompress in [false, true] {
        let bytes = marble().to_file(own(), supercompress);
        let read = PackFile::from_bytes(&bytes).unwrap();
        assert_eq!((&read.bindings, &read.entries), (&marble(), &own()));
        assert_eq!(read.bindings.to_file(read.entries, supercompress), bytes);
    }
    let text = String::from_utf8(texture().entries.remove(BINDINGS_ENTRY).unwrap()).unwrap();
    let expected = "decoder marble 1\n\
        0 brdfc_frame frame\n\
        40 marble_sizes uniform 32\n\
        41 marble_veins texture file 2d r8unorm 4 2 1 3 marble_sampler\n\
        42 marble_words texture entry 2d-array r32uint 2 1 2 1 -\n\
        43 marble_curve texture entry 2d rgba16float 3 1 1 1 marble_sampler\n\
        44 marble_sampler sampler repeat\n\
        50 marble_unused texture empty 3d rg8unorm 1 1 1 1 -\n\
        51 marble_sky texture entry cube r8unorm 2 2 6 2 marble_sampler\n\
        52 marble_night texture empty cube rg8unorm 1 1 6 1 -\n\0";
    assert_eq!(text, expected);
}

/// Violations of each rule of the list, and their messages.
#[test]
fn lines_out_of_rule_are_named() {
    let long = "x".repeat(65);
    let name = |name: &str| format!("42 {name} texture");
    for (old, new, expected) in [
        // The first line.
        ("decoder marble 1", "decoder marble", "line 1: found decoder marble, expected 'decoder'"),
        ("decoder marble 1", "codec marble 1", "line 1: found codec marble 1, expected 'decoder'"),
        ("decoder marble 1", "decoder Marble 1", "line 1: found decoder Marble 1, expected 'decoder'"),
        ("decoder marble 1", "decoder marble 0", "line 1: found 0, expected 1 to 4294967295"),
        ("decoder marble 1", "decoder marble 01", "line 1: found 01, expected 1 to"),
        ("decoder marble 1", "decoder marble 1 ", "line 1: found decoder marble 1 , expected"),
        // Words of a line.
        ("\n0 brdfc_frame frame", "\n", "line 2: found , expected a slot, a name and a resource"),
        ("\n0 brdfc_frame frame", "\n0 brdfc_frame", "line 2: found 0 brdfc_frame, expected a slot, a name"),
        (
            "0 brdfc_frame frame",
            "0 brdfc_frame frame\r",
            "line 2: found 0 brdfc_frame frame\r, expected frame, uniform",
        ),
        ("0 brdfc_frame frame", "1 brdfc_frame frame", "line 2: found 1, expected slot 0 for a frame"),
        ("0 brdfc_frame frame", "0 brdfc_frame frame 16", "line 2: found 0 brdfc_frame frame 16, expected frame"),
        ("sampler repeat", "buffer 16", "line 7: found 44 marble_sampler buffer 16, expected frame, uniform, texture"),
        ("sampler repeat", "sampler", "line 7: found 44 marble_sampler sampler, expected"),
        ("sampler repeat", "sampler mirror", "line 7: found mirror, expected clamp or repeat"),
        (" 32\n", "  32\n", "line 3: found 40 marble_sizes uniform  32, expected"),
        // Slots.
        ("40 marble", "1000 marble", "line 3: found 1000, expected 0 to 999"),
        ("40 marble", "-1 marble", "line 3: found -1, expected 0 to 999"),
        ("40 marble", "+40 marble", "line 3: found +40, expected 0 to 999"),
        ("40 marble", "4294967336 marble", "line 3: found 4294967336, expected 0 to 999"),
        ("42 marble", "41 marble", "line 5: found slot 41, expected slots in ascending order, each once"),
        ("42 marble", "3 marble", "line 5: found slot 3, expected slots in ascending order, each once"),
        // Names.
        ("42 marble_words texture", &name("marble words"), "line 5: found 42 marble words"),
        ("42 marble_words texture", &name("Marble"), "line 5: found Marble, expected a name of a to z"),
        ("42 marble_words texture", &name("../marble"), "line 5: found ../marble, expected a name of a to z"),
        ("42 marble_words texture", &name("marble\0"), "line 5: found marble\0, expected a name of a to z"),
        ("42 marble_words texture", &name("märble"), "line 5: found märble, expected a name of a to z"),
        ("42 marble_words texture", &name(""), "line 5: found , expected a name of a to z"),
        ("42 marble_words texture", &name(&long), "line 5: found xxx"),
        ("42 marble_words texture", &name("marble_sizes"), "line 5: found marble_sizes, expected a unique name"),
        // Uniform blocks.
        ("uniform 32", "uniform 0", "line 3: found 0, expected 16 to 16384"),
        ("uniform 32", "uniform 20", "line 3: found 20, expected a multiple of 16"),
        ("uniform 32", "uniform 16400", "line 3: found 16400, expected 16 to 16384"),
        ("uniform 32", "uniform", "line 3: found 40 marble_sizes uniform, expected"),
        // Textures.
        ("texture entry 2d-array", "texture there 2d-array", "line 5: found there, expected file, entry or empty"),
        ("entry 2d-array", "entry 1d", "line 5: found 1d of [2, 1, 2], expected 2d, 2d-array, 3d or cube"),
        ("entry 2d-array", "entry 2d", "line 5: found 2d of [2, 1, 2], expected 2d, 2d-array, 3d or cube"),
        ("r8unorm 2 2 6 2", "r8unorm 2 1 6 2", "line 9: found cube of [2, 1, 6], expected 2d, 2d-array, 3d or cube"),
        ("r8unorm 2 2 6 2", "r8unorm 2 2 5 2", "line 9: found cube of [2, 2, 5], expected 2d, 2d-array, 3d or cube"),
        ("r8unorm 2 2 6 2", "r8unorm 2 2 12 2", "line 9: found cube of [2, 2, 12], expected 2d, 2d-array, 3d or cube"),
        ("r8unorm 2 2 6 2", "r8unorm 2049 2049 6 2", "line 9: found cube of [2049, 2049, 6], expected 2d, 2d-array"),
        ("r8unorm 2 2 6 2", "r8unorm 2 2 6 3", "line 9: found 3, expected 1 to 2"),
        ("r32uint", "r32float", "line 5: found r32float, expected a texel format that packs support"),
        ("r32uint", "r8unorm-srgb", "line 5: found r8unorm-srgb, expected a texel format that packs support"),
        ("r32uint 2 1 2", "r32uint 0 1 2", "line 5: found 0, expected 1 to"),
        ("r32uint 2 1 2", "r32uint 2 8193 2", "line 5: found 2d-array of [2, 8193, 2], expected 2d, 2d-array"),
        ("r32uint 2 1 2", "r32uint 2 1 2049", "line 5: found 2d-array of [2, 1, 2049], expected 2d, 2d-array"),
        (
            "r32uint 2 1 2",
            "r32uint 4294967295 4294967295 4294967295",
            "line 5: found 2d-array of [4294967295, 4294967295, 4294967295], expected",
        ),
        ("2 1 2 1 -", "2 1 2 0 -", "line 5: found 0, expected 1 to 2"),
        ("2 1 2 1 -", "2 1 2 3 -", "line 5: found 3, expected 1 to 2"),
        ("2 1 2 1 -", "2 1 2 1", "line 5: found 42 marble_words texture"),
        ("rg8unorm 1 1 1 1", "rg8unorm 2 1 1 1", "line 8: found [2, 1, 1], expected one texel for an empty texture"),
        ("rg8unorm 1 1 6", "rg8unorm 2 2 6", "line 10: found [2, 2, 6], expected one texel for an empty texture"),
        ("rg8unorm 1 1 6", "rg8unorm 1 1 1", "line 10: found cube of [1, 1, 1], expected 2d, 2d-array, 3d or cube"),
        // Samplers of textures.
        (
            "1 1 marble_sampler",
            "1 1 marble_curve",
            "line 6: found marble_curve, expected the name of a sampler in the list, or -",
        ),
        (
            "1 1 marble_sampler",
            "1 1 sampler",
            "line 6: found sampler, expected the name of a sampler in the list, or -",
        ),
        (
            "2 1 2 1 -",
            "2 1 2 1 marble_sampler",
            "line 5: found marble_sampler, expected -, because integers are not filtered",
        ),
        // The file's own texture.
        (
            "veins texture file 2d r8unorm 4 2 1 3",
            "veins texture empty 2d r8unorm 1 1 1 1",
            ": found 0 bindings of the",
        ),
        ("words texture entry", "words texture file", ": found 2 bindings of the file's own texture, expected one"),
    ] {
        println!("{old:?} -> {new:?}");
        let mut texture = texture();
        rebind(&mut texture, old, new);
        let error = refusal(&texture).to_string();
        let expected = format!("{BINDINGS_ENTRY}{}{expected}", if expected.starts_with(':') { "" } else { " " });
        assert!(error.starts_with(&expected), "{error}\n{expected}");
    }
}

#[test]
fn the_list_ends_with_a_zero_byte() {
    let with_list = |list: &[u8]| {
        let mut texture = texture();
        texture.entries.insert(BINDINGS_ENTRY.to_owned(), list.to_vec());
        refusal(&texture).to_string()
    };
    let good = texture().entries[BINDINGS_ENTRY].clone();
    for list in
        [&[][..], b"\0", b"\n\0", &good[..good.len() - 1], &good[..good.len() - 2], &[&good[..], b"\0"].concat()]
    {
        let error = with_list(list);
        assert!(error.starts_with(BINDINGS_ENTRY), "{error}");
    }
    let latin = [&good[..20], &[0xe4], &good[20..]].concat();
    assert!(with_list(&latin).ends_with("expected lines of UTF-8 text that end with a zero byte"));
    assert!(with_list(b"decoder marble 1\n\0").starts_with("brdfc.bindings: no bindings; expected 1 to 32"));
}

/// A pack with a texture of its own and these bindings.
fn crowd(others: impl Iterator<Item = Binding<'static>>) -> Result<PackFile, FormatError> {
    let texels = Texels::new(TexelFormat::R8Unorm, Extent::D2([1, 1]), vec![0]).of_file();
    let all = [Binding::texture(0, "first", texels)].into_iter().chain(others);
    PackFile::from_bytes(&Bindings::new("crowd", 1, all).to_file(BTreeMap::new(), false))
}

fn named(slot: u32) -> &'static str {
    format!("x{slot}").leak()
}

#[test]
fn more_bindings_than_devices_support_are_rejected() {
    let empty = || Texels::empty(TexelFormat::R8Unorm, Extent::D2([1, 1]));
    let texture = |slot| Binding::texture(slot, named(slot), empty());
    let sampler = |slot| Binding::sampler(slot, named(slot), false);
    let uniform = |slot| Binding::uniform(slot, named(slot), vec![0; 16]);
    let refused = |result: Result<PackFile, FormatError>| result.unwrap_err().to_string();
    assert_eq!(crowd((1..16).map(texture)).unwrap().bindings.all.len(), 16);
    assert_eq!(refused(crowd((1..17).map(texture))), "brdfc.bindings textures: found 17, expected at most 16");
    assert!(crowd((1..17).map(sampler)).is_ok());
    assert_eq!(refused(crowd((1..18).map(sampler))), "brdfc.bindings samplers: found 17, expected at most 16");
    assert!(crowd((1..13).map(uniform)).is_ok());
    assert_eq!(refused(crowd((1..14).map(uniform))), "brdfc.bindings uniform blocks: found 13, expected at most 12");
    let mixed = |count: u32| crowd((1..count).map(|slot| if slot < 16 { texture(slot) } else { sampler(slot) }));
    assert_eq!(mixed(31).unwrap().bindings.all.len(), 31);
    let many = crowd((1..=MAX_BINDINGS as u32).map(|slot| match slot {
        1..16 => texture(slot),
        16..30 => sampler(slot),
        _ => uniform(slot),
    }));
    assert_eq!(refused(many), "brdfc.bindings bindings: found more than 32, expected 1 to 32");
}

#[test]
fn keys_are_those_that_bindings_name() {
    for (key, line) in [("brdfc.uniform.marble_sizes", 3), (WORDS, 5)] {
        let mut missing = texture();
        missing.entries.remove(key);
        let expected = format!("{key}: missing; expected a key of this name, as brdfc.bindings line {line} says");
        assert_eq!(refusal(&missing).to_string(), expected);
    }
    for (change, found) in [(-16isize, 16), (-1, 31), (1, 33), (16, 48)] {
        let mut resized = texture();
        let block = resized.entries.get_mut("brdfc.uniform.marble_sizes").unwrap();
        block.resize(block.len().saturating_add_signed(change), 0);
        let expected =
            format!("brdfc.uniform.marble_sizes: found {found} bytes, expected 32, as brdfc.bindings line 3 says");
        assert_eq!(refusal(&resized).to_string(), expected);
    }
    // Without a binding, or with a binding of another kind.
    for key in ["brdfc.image.marble", "brdfc.image.marble_sizes", "brdfc.image.", "brdfc.uniform.marble_words"] {
        let mut spare = texture();
        spare.entries.insert(key.to_owned(), spare.entries[WORDS].clone());
        let error = refusal(&spare);
        assert_eq!((&*error.field, &*error.found), (key, "no binding names this key"));
    }
    let mut without = texture();
    without.entries.remove(BINDINGS_ENTRY);
    let error = refusal(&without).to_string();
    assert!(error.starts_with("brdfc.bindings: not among the keys brdfc.checksum, brdfc.image."), "{error}");
    let mut two = texture();
    two.entries.insert("brdfc.bindingz".to_owned(), two.entries[BINDINGS_ENTRY].clone());
    let mut bytes = two.to_bytes(false);
    let at = bytes.windows(15).position(|bytes| bytes == b"brdfc.bindingz\0").unwrap();
    bytes[at + 13] = b's';
    let error = PackFile::from_bytes(&sealed(bytes)).unwrap_err().to_string();
    assert_eq!(error, "brdfc.bindings: duplicate key; expected unique keys");
}

/// Images match their lines, whether stored as key/value data or as the file itself.
#[test]
fn images_match_their_bindings() {
    let with_words = |change: &dyn Fn(&mut Texture)| {
        let mut texture = texture();
        change_image(&mut texture, "marble_words", change);
        refusal(&texture).to_string()
    };
    let says = "expected 1 levels of 2 layers of 2 x 1 texels of r32uint, as brdfc.bindings line 5 says";
    let resize = |image: &mut Texture| {
        image.texels.resize(image.extent.texels_of_levels(image.levels) as usize * image.format.texel_bytes(), 0);
    };
    for (extent, format, levels) in [
        (Extent::D2Array([2, 1, 3]), TexelFormat::R32Uint, 1),
        (Extent::D2Array([1, 2, 2]), TexelFormat::R32Uint, 1),
        (Extent::D3([2, 1, 2]), TexelFormat::R32Uint, 1),
        (Extent::D2([2, 2]), TexelFormat::R32Uint, 1),
        (Extent::Cube(2), TexelFormat::R32Uint, 1),
        (Extent::D2Array([2, 1, 2]), TexelFormat::Rgba8Unorm, 1),
        (Extent::D2Array([2, 1, 2]), TexelFormat::R32Uint, 2),
    ] {
        let error = with_words(&|image| {
            (image.extent, image.format, image.levels) = (extent, format, levels);
            resize(image);
        });
        let found = format!("found {levels} levels of {extent} texels of {}", format.name());
        assert_eq!(error, format!("{WORDS}: {found}, {says}"));
    }
    // The file itself.
    let mut file = texture();
    (file.extent, file.levels) = (Extent::D2([2, 4]), 3);
    resize(&mut file);
    let error = refusal(&file).to_string();
    let expected = "texture: found 3 levels of 2 x 4 texels of r8unorm, expected 3 levels of 4 x 2 texels of r8unorm";
    assert!(error.starts_with(expected), "{error}");
    // An image is not a pack.
    for key in [BINDINGS_ENTRY, "brdfc.checksum", "brdfc.note"] {
        let error = with_words(&|image| drop(image.entries.insert(key.to_owned(), vec![0; 4])));
        assert_eq!(error, format!("{WORDS}, keys: found {key}, expected no brdfc keys"));
    }
    // No file, or the beginning of one.
    let image = texture().entries[WORDS].clone();
    let with_bytes = |bytes: &[u8]| {
        let mut texture = texture();
        texture.entries.insert(WORDS.to_owned(), bytes.to_vec());
        refusal(&texture)
    };
    for length in 0..image.len() {
        let error = with_bytes(&image[..length]);
        assert!(error.field.starts_with(&format!("{WORDS}, ")), "{length}: {error}");
    }
    assert_eq!(with_bytes(&[7; 200]).field, format!("{WORDS}, identifier"));
}

/// Sizes are checked against the file's bytes before memory is allocated.
#[test]
fn huge_images_are_rejected_before_decompression() {
    // All images together.
    let mut texture = texture();
    rebind(&mut texture, "r32uint 2 1 2 1 -", "r32uint 8192 8192 4 1 -");
    let error = refusal(&texture).to_string();
    let expected =
        "brdfc.bindings line 5: found 1073741824 more bytes of texels, expected at most 1073741824 for all images";
    assert_eq!(error, expected);
    // A frame that declares what its line says, in a few bytes.
    rebind(&mut texture, "r32uint 8192 8192 4 1 -", "r32uint 8192 8192 3 1 -");
    let size = 3u64 << 28;
    let mut image = read_texture(&texture.entries[WORDS]).unwrap().to_bytes(true);
    let at = u64::from_le_bytes(*image[80..].first_chunk().unwrap()) as usize;
    image.truncate(at);
    image.extend([0x28, 0xb5, 0x2f, 0xfd, 0xa0]);
    image.extend((size as u32).to_le_bytes());
    image.extend([0; 32]);
    image[88..96].copy_from_slice(&41u64.to_le_bytes());
    image[96..104].copy_from_slice(&size.to_le_bytes());
    for (field, side) in [(20, 8192u32), (24, 8192), (32, 3)] {
        image[field..field + 4].copy_from_slice(&side.to_le_bytes());
    }
    texture.entries.insert(WORDS.to_owned(), image);
    let error = refusal(&texture);
    assert_eq!((&*error.field, &*error.found), (&*format!("{WORDS}, level 0"), "too short: 41 bytes"));
}

/// The checksum covers all bytes, with its own four taken as zero.
#[test]
fn files_without_their_checksum_are_rejected() {
    let bytes = marble().to_file(own(), true);
    assert_eq!(sealed(bytes.clone()), bytes);
    for value in [Vec::new(), vec![0; 3], vec![0; 5], vec![0; 8]] {
        let mut texture = texture();
        texture.entries.insert("brdfc.checksum".to_owned(), value);
        assert_eq!(refusal(&texture).to_string(), "brdfc.checksum: missing or too short; expected a value of 4 bytes");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    let error = PackFile::from_bytes(&longer).unwrap_err().to_string();
    assert!(error.starts_with("checksum of the file: found ") && error.ends_with("the file is damaged"), "{error}");
    assert!(PackFile::from_bytes(&sealed(longer)).is_ok(), "bytes behind the end mean nothing");
    // Only packs have one.
    let plain = Texture { entries: BTreeMap::new(), ..texture() }.to_bytes(false);
    assert_eq!(sealed(plain.clone()), plain);
    for length in [0, 3, 59, 63, 80, bytes.len() / 2] {
        sealed(bytes[..length].to_vec());
    }
}

/// A small pack of each codec and of the fictitious one.
fn small_packs() -> Vec<(&'static str, Vec<u8>)> {
    let of = |supercompress| {
        let packs = PackKind::ALL.map(|kind| (kind.name(), tested(kind).small_pack(supercompress)));
        packs.into_iter().chain([("marble", marble().to_file(own(), supercompress))])
    };
    of(false).chain(of(true)).collect()
}

#[test]
fn every_flipped_bit_and_every_truncation_is_detected() {
    for (codec, bytes) in small_packs() {
        let whole = PackFile::from_bytes(&bytes).unwrap();
        assert_eq!(whole.bindings.decoder, codec);
        let mut broken = bytes.clone();
        for bit in 0..8 * bytes.len() {
            broken[bit / 8] ^= 1 << (bit % 8);
            assert!(PackFile::from_bytes(&broken).is_err(), "{codec}: bit {} of byte {}", bit % 8, bit / 8);
            broken[bit / 8] = bytes[bit / 8];
        }
        for length in 0..bytes.len() {
            assert!(PackFile::from_bytes(&bytes[..length]).is_err(), "{codec}: {length} of {}", bytes.len());
            let error = PackFile::from_bytes(&sealed(bytes[..length].to_vec()));
            assert!(error.is_err(), "{codec}: {length} of {}, sealed", bytes.len());
        }
    }
}

/// With a valid checksum: an error, or a pack that round-trips and that the reader of its codec may reject.
#[test]
fn no_single_corrupt_byte_panics() {
    for (codec, bytes) in small_packs() {
        let mut broken = bytes.clone();
        for offset in 0..bytes.len() {
            for pattern in [1, 4, 16, 64, 128, 0xff] {
                broken[offset] = bytes[offset] ^ pattern;
                let changed = sealed(broken.clone());
                if let Ok(read) = PackFile::from_bytes(&changed) {
                    let again = PackFile::from_bytes(&read.bindings.to_file(read.entries.clone(), false));
                    assert_eq!(again.as_ref(), Ok(&read), "{codec}: byte {offset}");
                }
                let _ = Pack::from_bytes(&changed);
            }
            broken[offset] = bytes[offset];
        }
    }
}

/// Partial reads: key/value data and levels are at the offsets in the header, for any codec.
#[test]
fn parts_are_found_by_their_offsets() {
    let bytes = marble().to_file(own(), false);
    let word = |at: usize| u32::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize;
    let (mut at, end) = (word(56), word(56) + word(60));
    let mut found = BTreeMap::new();
    while at < end {
        let pair = &bytes[at + 4..][..word(at)];
        let (key, value) = pair.split_at(pair.iter().position(|byte| *byte == 0).unwrap());
        found.insert(String::from_utf8(key.to_vec()).unwrap(), value[1..].to_vec());
        at += 4 + pair.len().next_multiple_of(4);
    }
    found.retain(|key, _| key.starts_with("brdfc."));
    assert_eq!(found, PackedTexture::from_bytes(&bytes).unwrap().entries);
    let words = Texture::from_bytes(&found[WORDS]).unwrap();
    assert_eq!(words.texels, (0..16).collect::<Vec<u8>>());
}

/// Any bindings that the rules allow.
fn any_bindings() -> impl Strategy<Value = Bindings<'static>> {
    let texels = (0..13usize, 0..4u32, [1u32..5, 1..4, 1..4], 0..2u32, any::<bool>(), any::<bool>());
    let image = texels.prop_map(|(format, dimension, [width, height, depth], levels, stored, sampled)| {
        let format = TexelFormat::ALL[format];
        let extent = match dimension {
            0 => Extent::D2([width, height]),
            1 => Extent::D2Array([width, height, depth]),
            2 => Extent::D3([width, height, depth]),
            _ => Extent::Cube(width),
        };
        let levels = (1 + levels).min(extent.most_levels());
        let bytes = vec![7; extent.texels_of_levels(levels) as usize * format.texel_bytes()];
        let texels = match stored {
            true => Texels::new(format, extent, bytes).with_levels(levels),
            false => {
                Texels::empty(format, Extent::from_dimension(extent.dimension(), [1; 3]).unwrap_or(Extent::Cube(1)))
            }
        };
        if sampled && !format.is_integer() { texels.sampled("s") } else { texels }
    });
    let others = proptest::collection::vec((1u32..60, image), 0..10);
    let blocks = proptest::collection::vec(1usize..20, 0..8);
    (others, blocks, any::<bool>(), 1..u32::MAX).prop_map(|(images, blocks, repeats, version)| {
        let own = Texels::new(TexelFormat::R8Unorm, Extent::D2([2, 2]), vec![1, 2, 3, 4]).of_file();
        let mut all = vec![Binding::frame(), Binding::sampler(1, "s", repeats), Binding::texture(2, "own", own)];
        let mut slot = 2;
        for (step, texels) in images {
            slot += step;
            all.push(Binding::texture(slot, named(slot), texels));
        }
        for blocks in blocks {
            slot += 1;
            all.push(Binding::uniform(slot, named(slot), vec![9; 16 * blocks]));
        }
        Bindings { decoder: "any-codec".into(), version, all }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_bindings_round_trip(bindings in any_bindings(), supercompress: bool) {
        let bytes = bindings.to_file(own(), supercompress);
        let read = PackFile::from_bytes(&bytes).unwrap();
        prop_assert_eq!(&read.bindings, &bindings);
        prop_assert_eq!(read.entries, own());
    }

    /// The list has a canonical form: text that is read is written unchanged.
    #[test]
    fn any_text_is_rejected_or_read_unchanged(edits in proptest::collection::vec((any::<u16>(), 0u8..4, "[a-z0-9 \n-]{0,3}"), 1..4)) {
        let mut texture = texture();
        let mut text = String::from_utf8(texture.entries[BINDINGS_ENTRY].clone()).unwrap();
        for (place, cut, put) in edits {
            let from = usize::from(place) % text.len();
            let to = (from + usize::from(cut)).min(text.len());
            text.replace_range(from..to, &put);
            if text.is_empty() {
                break;
            }
        }
        texture.entries.insert(BINDINGS_ENTRY.to_owned(), text.clone().into_bytes());
        if let Ok(read) = PackFile::from_bytes(&sealed(texture.to_bytes(false))) {
            let again = read.bindings.to_file(read.entries, false);
            let found = &PackedTexture::from_bytes(&again).unwrap().entries[BINDINGS_ENTRY];
            prop_assert_eq!(found, text.as_bytes());
        }
    }
}
