//! Broken and hostile parts of factored flat BTFs: each is refused with a reason, or is part of an asset that decodes to
//! numbers.

use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::flat_btf::factored::{BasisMap, FactoredFlatBtf, ShadowFormat, ShadowMap, WeightMap, WeightRange};
use brdfc_testing::flat_btf::{Factors, SMALL, factored, factored_example, factored_files, factored_survives};
use brdfc_testing::packs::read_texture;

fn read(part: &str, bytes: &[u8]) -> Result<(), FormatError> {
    match part {
        "basis" => BasisMap::from_bytes(bytes).map(drop),
        "weights" => WeightMap::from_bytes(bytes).map(drop),
        _ => ShadowMap::from_bytes(bytes).map(drop),
    }
}

#[test]
fn every_truncation_is_an_error() {
    for supercompress in [false, true] {
        for (part, bytes) in factored_files(supercompress) {
            assert!(factored_survives(&bytes), "{part}");
            for length in 0..bytes.len() {
                assert!(read(part, &bytes[..length]).is_err(), "{part}: {length} of {}", bytes.len());
            }
        }
    }
}

#[test]
fn no_single_changed_byte_is_harmful() {
    for supercompress in [false, true] {
        for (part, bytes) in factored_files(supercompress) {
            let mut broken = bytes.clone();
            let (mut valid, mut refused) = (0, 0);
            for offset in 0..bytes.len() {
                for pattern in [1, 4, 16, 64, 128, 0xff, 0x7f] {
                    broken[offset] = bytes[offset] ^ pattern;
                    let survives = factored_survives(&broken);
                    assert!(!survives || read(part, &broken).is_ok(), "{part}: read one way, not the other");
                    *if survives { &mut valid } else { &mut refused } += 1;
                }
                broken[offset] = bytes[offset];
            }
            println!("{part}, Zstandard {supercompress}: {valid} read, {refused} refused");
            assert!(valid > 0 && refused > 0, "{part}: texels may change, lengths may not");
        }
    }
}

/// The largest numbers that files may hold, all at once.
#[test]
fn the_largest_numbers_decode_to_numbers() {
    let asset = factored_example();
    for (step, scale, low) in [
        (f32::MAX, 1.0, 1.0),
        (1.0, f32::MAX, f32::MAX),
        (f32::MAX, f32::MAX, f32::MIN),
        (f32::MAX, f32::MIN, f32::MIN),
        (f32::MIN_POSITIVE, f32::MAX, 0.0),
    ] {
        let mut header = asset.header().clone();
        header.steps = header.steps.map(|steps| vec![step; steps.len()]);
        let basis = BasisMap::new(header, asset.basis().words().to_vec()).unwrap();
        let weights = asset.weights();
        let ranges = vec![WeightRange { scale, low }; weights.ranges().len()];
        let weights = WeightMap::new(weights.size(), weights.levels(), ranges, weights.texels().to_vec()).unwrap();
        assert!(factored_survives(&basis.to_bytes(false)) && factored_survives(&weights.to_bytes(false)));
        let both = FactoredFlatBtf::new(basis, weights, asset.shadow().cloned());
        let both = both.unwrap();
        for k in 0..144 {
            let value = both.texel([k % 4, k / 4 % 4]).value(k / 48, k / 16 % 3);
            assert!(value.iter().all(|c| (0.0..3e5).contains(c)), "{step} {scale} {low}: {value:?}");
        }
    }
}

/// A file of the example with another container around its texels.
fn changed(part: &str, change: impl FnOnce(&mut Texture)) -> String {
    let (_, bytes) = factored_files(false).into_iter().find(|(name, _)| *name == part).expect("one of three");
    let mut texture = read_texture(&bytes).unwrap();
    change(&mut texture);
    let bytes = texture.to_bytes(true);
    assert!(!factored_survives(&bytes));
    read(part, &bytes).unwrap_err().to_string()
}

#[test]
fn entries_of_other_lengths_are_refused() {
    for (part, entry, long, short) in [
        ("basis", "brdfc.flat-btf.factored", "157 bytes; allowed 156 bytes, as groups says", "60 bytes or more"),
        ("weights", "brdfc.flat-btf.weights", "137 bytes; allowed 136 bytes", "3 bytes; allowed 8 bytes or more"),
        ("shadow", "brdfc.flat-btf.shadow", "5 bytes; allowed 4 bytes", "3 bytes; allowed 4 bytes"),
    ] {
        let resized = |length: Option<usize>| {
            changed(part, |texture| {
                let value = texture.entries.get_mut(entry).unwrap();
                value.resize(length.unwrap_or(value.len() + 1), 0);
            })
        };
        let error = resized(None);
        assert!(error.starts_with(entry) && error.ends_with(long), "{error}");
        let error = resized(Some(3));
        assert!(error.contains(short), "{error}");
        let error = changed(part, |texture| drop(texture.entries.remove(entry)));
        assert!(error.starts_with(entry), "{error}");
    }
}

/// Containers that are sound, around textures that are not what the entries say.
#[test]
fn other_textures_are_refused() {
    let resized = |part: &str, extent: Extent, levels: u32| {
        changed(part, |texture| {
            (texture.extent, texture.levels) = (extent, levels);
            texture.texels.resize(extent.texels_of_levels(levels) as usize * texture.format.texel_bytes(), 7);
        })
    };
    for (part, extent, levels, expected) in [
        ("basis", Extent::D2([9, 47]), 1, "size of the part basis: found 9 x 47; allowed a 2D texture of 9 x 46"),
        ("basis", Extent::D2([9, 46]), 2, "byte 40, levelCount: found 2; allowed 1"),
        ("weights", Extent::D2([4, 4]), 3, "size of the part weights: found 4 x 4; allowed a 2D array of equal sides"),
        (
            "weights",
            Extent::D2Array([4, 2, 2]),
            1,
            "size of the part weights: found 2 layers of 4 x 2; allowed a 2D array",
        ),
        (
            "weights",
            Extent::D2Array([4, 4, 3]),
            1,
            "size of the part weights: found 3 layers of 4 x 4; allowed 4 layers, as",
        ),
        ("shadow", Extent::D3([4, 4, 3]), 1, "size of the part shadow: found 4 x 4 x 3; allowed a 2D array"),
        (
            "shadow",
            Extent::D2Array([4, 8, 3]),
            1,
            "size of the part shadow: found 3 layers of 4 x 8; allowed a 2D array",
        ),
    ] {
        let error = resized(part, extent, levels);
        assert!(error.starts_with(expected), "{error}");
    }
    for part in ["basis", "weights", "shadow"] {
        let error = changed(part, |texture| {
            texture.texels = vec![0; texture.texels.len() / texture.format.texel_bytes() * 2];
            texture.format = TexelFormat::R16Unorm;
        });
        assert!(error.starts_with(&format!("texels of the part {part}: found R16Unorm; allowed R")), "{error}");
    }
    // Parts of another asset are read, and no asset is made of them.
    for (part, extent) in [("weights", Extent::D2Array([2, 2, 4])), ("shadow", Extent::D2Array([4, 4, 2]))] {
        let (_, bytes) = factored_files(false).into_iter().find(|(name, _)| *name == part).unwrap();
        let mut texture = read_texture(&bytes).unwrap();
        (texture.extent, texture.levels) = (extent, 1);
        texture.texels.resize(extent.texels() as usize * texture.format.texel_bytes(), 7);
        let bytes = texture.to_bytes(false);
        assert!(read(part, &bytes).is_ok() && !factored_survives(&bytes), "{part}");
    }
}

/// Every field of the entries out of its range.
#[test]
fn wrong_headers_are_refused() {
    let two = Factors { levels: 3, groups: 2, wide_groups: 1, shadow: ShadowFormat::R8 };
    let asset = factored(SMALL, two, 3);
    let refusal = |entry: &str, word: usize, value: u32| {
        let mut texture = Texture::from_bytes(&asset.basis().to_bytes(false)).unwrap();
        texture.entries.get_mut(entry).unwrap()[4 * word..][..4].copy_from_slice(&value.to_le_bytes());
        BasisMap::from_texture(&texture).unwrap_err().to_string()
    };
    let [nan, inf] = [f32::NAN, f32::INFINITY].map(f32::to_bits);
    for (word, value, expected) in [
        (0, 2, "brdfc.flat-btf.factored version: found 2; allowed 1"),
        (1, 0, "brdfc.flat-btf.factored size: found 0; allowed 1 to 8192"),
        (2, 4, "brdfc.flat-btf.factored levels: found 4; allowed 1 to 3"),
        (3, 17, "brdfc.flat-btf.factored groups: found 17; allowed 1 to 16"),
        (3, 3, "brdfc.flat-btf.factored length: found 156 bytes; allowed 204 bytes, as groups says"),
        (4, 3, "brdfc.flat-btf.factored wide groups: found 3; allowed 0 to 2, the groups"),
        (5, 2, "brdfc.flat-btf.factored shadow format: found 2; allowed 0 to 1"),
        (6, 0, "brdfc.flat-btf.factored views: found 0; allowed 1 to 2048"),
        (6, 4, "brdfc.views: found 24 bytes; allowed 32 bytes"),
        (7, 4, "brdfc.lights: found 40 bytes; allowed 32 bytes"),
        (1, 8193, "brdfc.flat-btf.factored size: found 8193; allowed 1 to 8192"),
        (2, 0, "brdfc.flat-btf.factored levels: found 0; allowed 1 to 3"),
        (3, 0, "brdfc.flat-btf.factored groups: found 0; allowed 1 to 16"),
        (6, 2049, "brdfc.flat-btf.factored views: found 2049; allowed 1 to 2048"),
        (7, 0, "brdfc.flat-btf.factored lights: found 0; allowed 1 to 2048"),
        (9, nan, "brdfc.flat-btf.factored error: found NaN; allowed a finite number that is not negative"),
        (
            13,
            (-1.0f32).to_bits(),
            "brdfc.flat-btf.factored error: found -1; allowed a finite number that is not negative",
        ),
        (14, 1, "brdfc.flat-btf.factored reserved: found 1; allowed 0"),
        (15, nan, "brdfc.flat-btf.factored step: found NaN; allowed a finite number that is not negative"),
        (38, inf, "brdfc.flat-btf.factored step: found inf; allowed a finite number that is not negative"),
    ] {
        assert_eq!(refusal("brdfc.flat-btf.factored", word, value), expected);
    }
    assert!(refusal("brdfc.lights", 0, nan).starts_with("brdfc.lights direction 0: found NaN"));
    let weights = |word: usize, value: u32| {
        let packed = asset.weights().to_bytes(false);
        let mut texture = read_texture(&packed).unwrap();
        let entry = texture.entries.get_mut("brdfc.flat-btf.weights").unwrap();
        entry[4 * word..][..4].copy_from_slice(&value.to_le_bytes());
        WeightMap::from_texture(texture).unwrap_err().to_string()
    };
    assert_eq!(weights(1, 0), "brdfc.flat-btf.weights numbers: found 0; allowed 1 to 72");
    assert_eq!(weights(1, 73), "brdfc.flat-btf.weights numbers: found 73; allowed 1 to 72");
    assert_eq!(weights(0, 0), "brdfc.flat-btf.weights version: found 0; allowed 1");
    assert_eq!(weights(1, 4), "brdfc.flat-btf.weights: found 136 bytes; allowed 40 bytes");
    assert!(weights(5, nan).starts_with("brdfc.flat-btf.weights range 1"));
    // The base alone is no asset, and its table has a range.
    let range = WeightRange { scale: 1.0, low: 0.0 };
    let refused = WeightMap::new(1, 1, vec![range; 8], vec![0; 8]).unwrap_err().to_string();
    assert_eq!(refused, "numbers of the part weights: found 8; allowed a multiple of 4, 12 at least");
    for (number, told) in [(nan, "NaN"), (inf, "inf"), ((-0.5f32).to_bits(), "-0.5"), (65_537.0f32.to_bits(), "65537")]
    {
        let error = changed("basis", |texture| {
            let entry = 16 * (9 * 3 + 2 * 8 + 5) + 4;
            texture.texels[entry..][..4].copy_from_slice(&number.to_le_bytes());
        });
        assert!(error.starts_with("entry (2, 5) of the base: found [") && error.contains(told), "{error}");
    }
    let versions = changed("shadow", |texture| {
        texture.entries.get_mut("brdfc.flat-btf.shadow").unwrap()[0] = 2;
    });
    assert_eq!(versions, "brdfc.flat-btf.shadow version: found 2; allowed 1");
}
