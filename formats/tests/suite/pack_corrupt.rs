//! Corrupt and malicious packs: each is rejected, or decodes to finite numbers. None panics or allocates memory that
//! its own size does not justify.

use std::collections::BTreeMap;

use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::{SliceScale, WaveletPack};
use brdfc_testing::codecs::wavelet::survives;
use brdfc_testing::packs::{change_image, sealed};

/// One small pack of each texel format.
fn small_packs() -> Vec<WaveletPack> {
    [(1, 8), (3, 8), (1, 12), (3, 16)]
        .into_iter()
        .map(|(channels, bits)| {
            brdfc_testing::codecs::wavelet::pack(
                brdfc_testing::codecs::wavelet::header(Parameterisation::HalfDifference, 2, channels, bits),
                3,
                u64::from(bits),
            )
        })
        .collect()
}

fn texels_start(bytes: &[u8]) -> usize {
    u64::from_le_bytes(bytes[80..88].try_into().unwrap()) as usize
}

#[test]
fn every_truncation_is_an_error() {
    for pack in small_packs() {
        for supercompress in [false, true] {
            let bytes = pack.to_bytes(supercompress);
            for length in 0..bytes.len() {
                assert!(!survives(&bytes[..length]), "{length} of {} bytes", bytes.len());
            }
            assert!(survives(&bytes));
        }
    }
}

#[test]
fn no_single_corrupt_byte_panics() {
    for pack in small_packs() {
        for supercompress in [false, true] {
            let bytes = pack.to_bytes(supercompress);
            let start = texels_start(&bytes);
            let mut broken = bytes.clone();
            let mut valid = 0;
            for offset in 0..bytes.len() {
                // All patterns before the texels and in compressed data; texels can hold anything.
                let patterns: &[u8] = match offset {
                    _ if offset < start || supercompress => &[1, 2, 4, 8, 16, 32, 64, 128, 0xff, 0x7f],
                    _ => &[0x80],
                };
                for pattern in patterns {
                    broken[offset] = bytes[offset] ^ pattern;
                    valid += usize::from(survives(&broken));
                }
                broken[offset] = bytes[offset];
            }
            assert!(valid > 0, "the numbers of an error summary may change");
        }
    }
}

#[test]
fn values_of_the_header_fields_at_their_limits_do_not_panic() {
    let bytes = brdfc_testing::codecs::wavelet::example().to_bytes(false);
    for offset in (12..104).step_by(4) {
        for value in [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_fff0, u32::MAX] {
            let mut broken = bytes.clone();
            broken[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
            survives(&broken);
            if offset % 8 == 0 {
                broken[offset + 4..offset + 8].copy_from_slice(&u32::MAX.to_le_bytes());
                survives(&broken);
            }
        }
    }
}

/// The example as a texture whose key/value data tests can change.
fn texture() -> Texture {
    Texture::from_bytes(&brdfc_testing::codecs::wavelet::example().to_bytes(false)).unwrap()
}

fn refusal(texture: &Texture) -> FormatError {
    let [plain, packed] = [false, true].map(|supercompress| {
        let bytes = sealed(texture.to_bytes(supercompress));
        WaveletPack::from_bytes(&bytes).unwrap_err()
    });
    assert_eq!(plain, packed);
    plain
}

/// Error after 4 bytes of a value were replaced.
fn with_word(key: &str, offset: usize, word: [u8; 4]) -> FormatError {
    let mut texture = texture();
    texture.entries.get_mut(key).unwrap()[offset..offset + 4].copy_from_slice(&word);
    refusal(&texture)
}

#[test]
fn header_fields_out_of_range_are_named() {
    for (offset, field, values) in [
        (0, "version", vec![0, 1, 3, u32::MAX]),
        (4, "parameterisation", vec![2, u32::MAX]),
        (8, "levels", vec![0, 7, 32, u32::MAX]),
        (12, "stored levels", vec![2, u32::MAX]),
        (16, "channels", vec![0, 2, 4]),
        (20, "bits", vec![0, 7, 9, 17, u32::MAX]),
        (24, "slices", vec![0, 1, 2049, u32::MAX]),
        (36, "energy-preserving", vec![2, u32::MAX]),
    ] {
        for value in values {
            let error = with_word("brdfc.wavelet", offset, value.to_le_bytes());
            assert_eq!(error.field, format!("brdfc.wavelet {field}"), "{value}");
            assert_eq!(error.found, value.to_string());
        }
    }
    for (offset, field) in [(28, "mean"), (32, "bias")] {
        for value in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE / 2.0] {
            let error = with_word("brdfc.wavelet", offset, value.to_le_bytes());
            assert_eq!(error.field, format!("brdfc.wavelet {field}"), "{value}");
        }
    }
}

#[test]
fn header_and_texture_agree() {
    // A size, slice count, channel count or depth that differs from the texture.
    for (offset, value) in [(8, 2), (24, 2), (24, 4), (16, 3), (20, 16)] {
        assert_eq!(with_word("brdfc.wavelet", offset, u32::to_le_bytes(value)).field, "texture");
    }
}

/// The binding of the index map.
const INDEX: &str = "wavelet_brdf_index";

/// Error after the words of coefficients, from the first on, were replaced: slice, scale, offset and share.
fn with_index(coefficients: &[[f32; 4]]) -> FormatError {
    let mut texture = texture();
    change_image(&mut texture, INDEX, |image| {
        let bytes = coefficients.iter().flatten().flat_map(|word| word.to_le_bytes());
        image.texels.splice(..16 * coefficients.len(), bytes);
    });
    refusal(&texture)
}

#[test]
fn the_index_map_counts_slices_in_order() {
    for (slices, field) in [
        ([2.0, 0.0, 1.0, 0.0], " coefficient 0, slice"),
        ([0.0, 0.0, 1.0, 2.0], " coefficient 0, slice"),
        ([f32::NAN, 0.0, 2.0, 0.0], " coefficient 0, slice"),
        ([1.0, 0.0, 3.0, 0.0], " coefficient 2, slice"),
        ([1.0, 0.0, 1.0, 0.0], " coefficient 2, slice"),
        ([1.0, 2.0, 2.0, 0.0], " coefficient 2, slice"),
        ([1.0, 0.0, 1.5, 0.0], " coefficient 2, slice"),
        ([1.0, 0.0, f32::from(u16::MAX), 0.0], " coefficient 2, slice"),
        ([1.0, -0.0, 2.0, 0.0], " coefficient 1, slice"),
        ([1.0, 0.0, 0.0, 0.0], ""),
        ([1.0, 2.0, 3.0, 0.0], ""),
    ] {
        let words = |slice: f32| if slice == 0.0 { [slice, 0.0, 0.0, 0.0] } else { [slice, 0.5, -0.25, 0.0] };
        let error = with_index(&slices.map(words));
        assert_eq!(error.field, format!("{INDEX}{field}"), "{slices:?}");
    }
    // Slices of a level that the header declares as not stored.
    let error = with_word("brdfc.wavelet", 12, [0; 4]).to_string();
    assert_eq!(error, "wavelet_brdf_index coefficient 2, slice: found 2, expected 0, because this level is not stored");
}

#[test]
fn scales_are_finite_and_not_negative() {
    let good = [[1.0, 2.0, -1.0, 0.0], [0.0; 4], [2.0, 0.5, -0.25, 0.0], [0.0; 4]];
    for (coefficient, word, value, field) in [
        // The zero slice has zeros.
        (1, 1, 1.0, "scale and offset"),
        (1, 1, -0.0, "scale and offset"),
        (1, 1, f32::NAN, "scale and offset"),
        (3, 2, 1e-9, "scale and offset"),
        (0, 1, f32::NAN, "scale and offset"),
        (0, 1, -1.0, "scale and offset"),
        (0, 1, f32::INFINITY, "scale and offset"),
        (0, 2, f32::NAN, "scale and offset"),
        (0, 2, f32::NEG_INFINITY, "scale and offset"),
        (2, 2, f32::INFINITY, "scale and offset"),
        (2, 3, 0.5, "fourth component"),
        (0, 3, f32::NAN, "fourth component"),
    ] {
        let mut changed = good;
        changed[coefficient][word] = value;
        let error = with_index(&changed);
        assert_eq!(error.field, format!("{INDEX} coefficient {coefficient}, {field}"), "{word} {value}");
    }
    let error = with_index(&[[1.0, f32::MAX, f32::MAX, 0.0]]);
    assert_eq!(error.field, "wavelet_brdf_index coefficient 0, scale and offset", "the largest coefficient overflows");
}

/// The uniform block repeats the metadata and the index map, because shaders read the one and the CPU reads the others.
#[test]
fn uniform_block_and_metadata_agree() {
    let error = with_index(&[[1.0, 2.0, -0.5, 0.0]]);
    assert_eq!(error.field, "brdfc.uniform.wavelet_brdf_parameters byte 28", "{error}");
    for word in 0..12 {
        let error = with_word("brdfc.uniform.wavelet_brdf_parameters", 4 * word, [7; 4]);
        assert_eq!(error.field, format!("brdfc.uniform.wavelet_brdf_parameters byte {}", 4 * word));
        assert!(error.allowed.ends_with("as the codec's metadata says"), "{error}");
    }
}

#[test]
fn absurd_scales_still_decode_to_numbers() {
    for [scale, offset] in [[f32::MAX, 0.0], [0.0, f32::MAX], [f32::MAX, f32::MIN], [0.0, f32::MIN], [1e30, 1e30]] {
        for slice in [1, 2] {
            let mut pack = brdfc_testing::codecs::wavelet::example();
            pack.scales[slice] = SliceScale { scale, offset };
            assert!(survives(&pack.to_bytes(false)), "scale {scale}, offset {offset}");
        }
    }
}

#[test]
fn errors_are_not_negative() {
    for offset in (4..40).chain(44..80).step_by(4).filter(|offset| offset % 40 != 0) {
        for value in [-1.0, f32::NAN, f32::INFINITY] {
            let error = with_word("brdfc.wavelet.errors", offset, f32::to_le_bytes(value));
            assert_eq!(error.field, "brdfc.wavelet.errors", "{offset} {value}");
        }
    }
}

#[test]
fn every_key_is_required_once_and_has_its_length() {
    let keys: Vec<String> = texture().entries.into_keys().collect();
    assert_eq!(keys.len(), 6, "{keys:?}");
    for key in &keys {
        let mut missing = texture();
        missing.entries.remove(key);
        assert_eq!(&refusal(&missing).field, key);
        // Values other than text and files have a fixed length.
        if ["brdfc.bindings", "brdfc.checksum", "brdfc.image.wavelet_brdf_index"].contains(&key.as_str()) {
            continue;
        }
        for change in [-40isize, -4, -1, 1, 4] {
            let mut resized = texture();
            let value = resized.entries.get_mut(key).unwrap();
            value.resize(value.len().saturating_add_signed(change), 0);
            let error = refusal(&resized);
            assert!(error.field == *key && error.found.ends_with(" bytes"), "{key} {change}: {error}");
        }
    }
    let empty = Texture { entries: BTreeMap::new(), ..texture() };
    assert_eq!(refusal(&empty).found, "no brdfc keys");

    // A key similar to another, of the same length: `brdfc.wavelet` has a NUL in place of its last character.
    let mut twice = texture();
    twice.entries.insert("brdfc.wavelez".into(), twice.entries["brdfc.wavelet"].clone());
    let mut bytes = twice.to_bytes(false);
    let at = bytes.windows(14).position(|w| w == b"brdfc.wavelez\0").unwrap();
    bytes[at + 12] = b't';
    let error = WaveletPack::from_bytes(&sealed(bytes)).unwrap_err();
    assert_eq!((error.field.as_ref(), error.found.as_str()), ("brdfc.wavelet", "duplicate key"));
}

#[test]
fn other_keys_are_ignored() {
    let mut more = texture();
    more.entries.insert("brdfc.note".into(), vec![1, 2, 3]);
    let bytes = sealed(more.to_bytes(true));
    assert_eq!(WaveletPack::from_bytes(&bytes).unwrap(), brdfc_testing::codecs::wavelet::example());
}

#[test]
fn the_zero_slice_is_zero() {
    for offset in 0..4 {
        let mut texture = texture();
        texture.texels[offset] = 1;
        assert_eq!(refusal(&texture).field, "slice 0");
    }
}

/// A supercompressed file of the example with other bytes as its level.
fn with_level(level: &[u8], uncompressed: u64) -> Vec<u8> {
    let mut bytes = brdfc_testing::codecs::wavelet::example().to_bytes(true);
    bytes.truncate(texels_start(&bytes));
    bytes.extend_from_slice(level);
    bytes[88..96].copy_from_slice(&(level.len() as u64).to_le_bytes());
    bytes[96..104].copy_from_slice(&uncompressed.to_le_bytes());
    sealed(bytes)
}

#[test]
fn compressed_data_with_wrong_lengths_are_rejected() {
    let texels = brdfc_testing::codecs::wavelet::example().texels;
    let frame = |bytes: &[u8]| zstd::bulk::compress(bytes, 3).unwrap();
    assert!(survives(&with_level(&frame(&texels), 12)));
    let bomb = frame(&vec![0; 1 << 26]);
    assert!(bomb.len() < 1 << 14);
    // A frame header: magic, a descriptor for a single segment with 4 bytes of content size, the size.
    let declares = |size: u32| {
        let whole = frame(&texels);
        assert_eq!(whole[4..6], [0x20, 12], "single segment, content size in one byte");
        [&whole[..4], &[0xa0], &size.to_le_bytes(), &whole[6..]].concat()
    };
    assert!(survives(&with_level(&declares(12), 12)), "the hand-made frame is valid");
    let streamed = zstd::stream::encode_all(&texels[..], 3).unwrap();
    for (name, level, uncompressed) in [
        ("longer than the extent", bomb.clone(), 12),
        ("longer, and the index says so", bomb.clone(), 1 << 26),
        ("shorter", frame(&texels[..11]), 12),
        ("declares more than it holds", declares(13), 12),
        ("declares a huge size", declares(u32::MAX), 12),
        ("declares less than it holds", declares(11), 12),
        ("a second frame", [frame(&texels), bomb].concat(), 12),
        ("a second frame of the right size", [frame(&texels), frame(&texels)].concat(), 12),
        ("bytes after the frame", [frame(&texels), vec![0; 3]].concat(), 12),
        ("without a content size", streamed, 12),
        ("not a frame", texels.clone(), 12),
        ("empty", Vec::new(), 12),
    ] {
        let error = WaveletPack::from_bytes(&with_level(&level, uncompressed)).expect_err(name);
        assert!(["level 0", "uncompressedByteLength", "container"].contains(&error.field.as_ref()), "{name}: {error}");
    }
}

#[test]
fn a_few_bytes_that_declare_a_gibibyte_are_rejected_early() {
    let mut level = vec![0x28, 0xb5, 0x2f, 0xfd, 0xa0];
    level.extend_from_slice(&(1u32 << 30).to_le_bytes());
    level.extend_from_slice(&[0; 32]);
    let mut bytes = with_level(&level, 1 << 30);
    for (offset, size) in [(20, 2048u32), (24, 2048), (28, 256)] {
        bytes[offset..offset + 4].copy_from_slice(&size.to_le_bytes());
    }
    assert_eq!(Texture::from_bytes(&bytes).unwrap_err().found, "too short: 41 bytes");
    let error = WaveletPack::from_bytes(&sealed(bytes)).unwrap_err().to_string();
    let expected =
        "texture: found 1 levels of 2048 x 2048 x 256 texels of r8unorm, expected 1 levels of 2 x 2 x 3 texels";
    assert!(error.starts_with(expected), "{error}");
}

/// The limit above does not reject the most compressible contents.
#[test]
fn a_large_texture_of_one_value_is_read() {
    let texels = vec![0; 1 << 26];
    let texture = Texture {
        format: TexelFormat::R8Unorm,
        extent: Extent::D3([256, 256, 1024]),
        entries: BTreeMap::new(),
        levels: 1,
        texels,
    };
    assert!(Texture::from_bytes(&texture.to_bytes(true)).unwrap() == texture);
}

#[test]
fn extents_beyond_the_limits_are_rejected_before_allocation() {
    for extent in [[2048; 3], [2048, 2048, 512], [2049, 1, 1], [1, 2049, 1], [1, 1, 2049], [u32::MAX; 3], [0, 1, 1]] {
        for supercompress in [false, true] {
            let mut bytes = brdfc_testing::codecs::wavelet::example().to_bytes(supercompress);
            for (axis, size) in extent.into_iter().enumerate() {
                bytes[20 + 4 * axis..24 + 4 * axis].copy_from_slice(&size.to_le_bytes());
            }
            let size = extent.into_iter().map(u128::from).product::<u128>() as u64;
            bytes[96..104].copy_from_slice(&size.to_le_bytes());
            assert!(!survives(&bytes), "{extent:?}");
        }
    }
}

#[test]
fn other_textures_are_rejected() {
    let bytes = brdfc_testing::codecs::wavelet::example().to_bytes(false);
    for (offset, value, field) in [
        (0, 0, "identifier"),
        (12, 10, "vkFormat"),
        (12, 37, "data format descriptor"),
        (16, 2, "typeSize"),
        (32, 1, "layerCount"),
        (36, 2, "faceCount"),
        (36, 6, "pixelDepth"),
        (40, 0, "levelCount"),
        (40, 2, "levelCount"),
        (44, 1, "supercompressionScheme"),
        (44, 3, "supercompressionScheme"),
        // The block dimension 256 is a special case of the ktx2 crate.
        (104 + 4 + 12, 255, "data format descriptor"),
        (104 + 4 + 10, 2, "data format descriptor"),
        (104 + 4 + 16, 0, "data format descriptor"),
    ] {
        let mut broken = bytes.clone();
        broken[offset] = value;
        let error = Texture::from_bytes(&broken).unwrap_err();
        // A second level index record runs into the descriptor before its count is checked.
        let whole = field == "levelCount" && error.field == "container";
        assert!(error.field == field || whole, "{offset} {value}: {error}");
    }
}

#[test]
fn a_texture_that_is_not_a_pack_is_rejected() {
    let texture = Texture {
        format: TexelFormat::Rgba16Unorm,
        extent: Extent::D3([3, 1, 2]),
        entries: BTreeMap::from([("brdfc.other".to_owned(), vec![7])]),
        levels: 1,
        texels: (0..48).collect(),
    };
    for supercompress in [false, true] {
        let bytes = texture.to_bytes(supercompress);
        assert_eq!(Texture::from_bytes(&bytes).unwrap(), texture);
        let error = WaveletPack::from_bytes(&bytes).unwrap_err();
        assert_eq!(error.to_string(), "brdfc.bindings: not among the keys brdfc.other; expected the keys of a pack");
    }
}
