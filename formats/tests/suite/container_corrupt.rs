//! Corrupt textures of all kinds and formats, before they are interpreted as packs.

use crate::cube_maps::cube_maps;
use brdfc_formats::container::{Extent, MAX_TEXEL_BYTES, PackedTexture, TexelFormat, Texture};
use brdfc_testing::packs::read_texture;
use std::collections::BTreeMap;

/// Header fields, word by word from the width, that a reader accepts or rejects.
#[test]
fn kinds_and_limits_of_textures() {
    let texture = |format, extent: Extent| {
        let texels = vec![0; extent.texels() as usize * TexelFormat::texel_bytes(format)];
        Texture { format, extent, entries: BTreeMap::new(), levels: 1, texels }
    };
    for extent in [
        Extent::D2([8192, 1]),
        Extent::D2([1, 8192]),
        Extent::D2Array([1, 1, 2048]),
        Extent::D2Array([8192, 1, 2]),
        Extent::D3([1, 2048, 1]),
    ] {
        for supercompress in [false, true] {
            let made = texture(TexelFormat::R8Unorm, extent);
            assert!(Texture::from_bytes(&made.to_bytes(supercompress)).unwrap() == made, "{extent}");
        }
    }
    let good = texture(TexelFormat::Rgba32Float, Extent::D2([4, 4])).to_bytes(false);
    for (fields, field) in [
        // This error comes from the ktx2 crate.
        ([0, 4, 0, 0], "container"),
        ([8193, 4, 0, 0], "pixelWidth"),
        // A height of 0 is a 1D texture.
        ([4, 0, 0, 0], "pixelHeight"),
        ([4, 8193, 0, 0], "pixelHeight"),
        ([4, 4, 2049, 0], "pixelDepth"),
        ([2049, 4, 1, 0], "pixelWidth"),
        ([4, 4, 0, 2049], "layerCount"),
        ([4, 4, 1, 1], "layerCount"),
        ([u32::MAX, u32::MAX, u32::MAX, u32::MAX], "pixelWidth"),
        ([8192, 8192, 0, 2048], "texture"),
        ([8192, 8192, 0, 2], "texture"),
        ([8192, 8192, 0, 0], "uncompressedByteLength"),
        ([4, 4, 0, 2], "uncompressedByteLength"),
    ] {
        let mut bytes = good.clone();
        for (k, value) in fields.into_iter().enumerate() {
            bytes[20 + 4 * k..24 + 4 * k].copy_from_slice(&u32::to_le_bytes(value));
        }
        assert_eq!(Texture::from_bytes(&bytes).unwrap_err().field, field, "{fields:?}");
    }
    // An array with one layer is valid, and is a different file than one without layers.
    let one = texture(TexelFormat::R8Unorm, Extent::D2Array([4, 4, 1]));
    assert!(one.to_bytes(false) != texture(TexelFormat::R8Unorm, Extent::D2([4, 4])).to_bytes(false));
}

/// 5 x 3, 2 x 1 and 1 x 1 texels of one byte.
fn three_levels() -> Texture {
    let (format, extent) = (TexelFormat::R8Unorm, Extent::D2([5, 3]));
    Texture { format, extent, entries: BTreeMap::new(), levels: 3, texels: (0..18).collect() }
}

fn with(bytes: &[u8], offset: usize, value: &[u8]) -> Vec<u8> {
    [&bytes[..offset], value, &bytes[offset + value.len()..]].concat()
}

#[test]
fn level_counts_are_checked_against_the_extent() {
    for supercompress in [false, true] {
        let bytes = three_levels().to_bytes(supercompress);
        for count in [0u32, 4, 32, u32::MAX] {
            let error = read_texture(&with(&bytes, 40, &count.to_le_bytes())).unwrap_err();
            assert_eq!(error.to_string(), format!("byte 40, levelCount: found {count}, expected 1 to 3"));
        }
        // A count that is too small leaves level 0 in place; packs with one level still require a count of 1.
        let fewer = read_texture(&with(&bytes, 40, &[2])).unwrap();
        assert_eq!((fewer.levels, &fewer.texels[..]), (2, &three_levels().texels[..17]));
        assert_eq!(Texture::from_bytes(&with(&bytes, 40, &[1])).unwrap().texels, three_levels().texels[..15]);
        let error = Texture::from_bytes(&bytes).unwrap_err().to_string();
        assert_eq!(error, "byte 40, levelCount: found 3, expected 1");
    }
    let single = Texture { levels: 1, extent: Extent::D2Array([1, 1, 18]), ..three_levels() }.to_bytes(false);
    let error = read_texture(&with(&single, 40, &[2])).unwrap_err().to_string();
    assert_eq!(error, "byte 40, levelCount: found 2, expected 1");
}

#[test]
fn all_levels_together_are_checked_against_the_limit() {
    for supercompress in [false, true] {
        let bytes = three_levels().to_bytes(supercompress);
        let unpacked = |limit| PackedTexture::from_bytes(&bytes).unwrap().unpack_levels(limit);
        assert_eq!(PackedTexture::from_bytes(&bytes).unwrap().texel_bytes(), 18);
        assert!(unpacked(18).unwrap() == three_levels());
        let error = unpacked(17).unwrap_err().to_string();
        assert_eq!(error, "byte 20, texture: found 18 bytes of texels, expected at most 17");
    }
    // Level 0 alone is at the limit of any texture; the next level exceeds it.
    let mut bytes = three_levels().to_bytes(false);
    for (offset, value) in [(20, 8192u32), (24, 8192), (32, 16)] {
        bytes = with(&bytes, offset, &value.to_le_bytes());
    }
    let packed = PackedTexture::from_bytes(&bytes).unwrap();
    assert!(packed.extent.texels() == MAX_TEXEL_BYTES && packed.texel_bytes() > MAX_TEXEL_BYTES);
    assert_eq!(packed.unpack_levels(u64::MAX).unwrap_err().field, "texture");
}

#[test]
fn levels_that_contradict_the_index_are_rejected() {
    let entry = |level: usize| 80 + 24 * level;
    for supercompress in [false, true] {
        let bytes = three_levels().to_bytes(supercompress);
        let offset = |level: usize| u64::from_le_bytes(*bytes[entry(level)..].first_chunk().unwrap());
        let refused = |broken: &[u8]| read_texture(broken).unwrap_err();
        // Two exchanged records.
        let [first, second] = [0, 1].map(|level| &bytes[entry(level)..entry(level + 1)]);
        let swapped = with(&bytes, entry(0), &[second, first].concat());
        assert_eq!(refused(&swapped).field, "uncompressedByteLength");
        for (level, size) in [(0, 15), (1, 2), (2, 1)] {
            let error = refused(&with(&bytes, entry(level) + 16, &[size + 1]));
            let place = entry(level) + 16;
            let found = format!("found {}, expected {size}, as format and extent say", size + 1);
            assert_eq!(error.to_string(), format!("byte {place}, uncompressedByteLength: {found}"));
        }
        // A level within the bytes of another, from its first or its last on.
        for (coarse, fine) in [(1, 0), (2, 0), (2, 1)] {
            let length = u64::from(bytes[entry(fine) + 8]);
            for shift in [0, length - 1] {
                let place = offset(fine) + shift;
                let error = refused(&with(&bytes, entry(coarse), &place.to_le_bytes()));
                // The last byte of level 0 is the last of the file, so longer levels exceed it.
                let passes = error.field == "container" && shift > 0;
                assert!(error.field == "byteOffset" || passes, "{coarse} {fine} {shift}: {error}");
            }
        }
        let overlapping = with(&bytes, entry(2), &offset(1).to_le_bytes());
        let error = refused(&overlapping).to_string();
        let allowed = "expected an offset outside the bytes of level 1";
        assert_eq!(error, format!("byte 128, byteOffset: found {}, {allowed}", offset(1)));
        // Past the end of the file, and past all offsets.
        for place in [bytes.len() as u64, u64::MAX] {
            assert_eq!(refused(&with(&bytes, entry(1), &place.to_le_bytes())).field, "container");
        }
        // The index ends with the file.
        assert_eq!(refused(&bytes[..entry(3) - 1]).field, "data format descriptor");
    }
    // The order of levels in the file and their alignment are not checked.
    let texture = three_levels();
    let bytes = texture.to_bytes(false);
    let end = bytes.len() as u64;
    let mut moved = [&bytes[..], &[16, 15, 16, 17]].concat();
    for (level, place) in [(1, end + 1), (2, end + 3)] {
        moved = with(&moved, entry(level), &place.to_le_bytes());
    }
    assert!(read_texture(&moved).unwrap() == texture);
}

/// Each level is one frame of the declared length; bytes of its neighbours do not extend it.
#[test]
fn frames_of_levels_have_their_own_size() {
    let texture = three_levels();
    let frame = |texels: &[u8]| zstd::bulk::compress(texels, 3).unwrap();
    let good = [frame(&texture.texels[..15]), frame(&texture.texels[15..17]), frame(&texture.texels[17..])];
    let file = |frames: &[Vec<u8>; 3]| {
        let mut bytes = texture.to_bytes(true);
        for (level, frame) in frames.iter().enumerate() {
            let place = [(bytes.len() as u64).to_le_bytes(), (frame.len() as u64).to_le_bytes()].concat();
            bytes = with(&bytes, 80 + 24 * level, &place);
            bytes.extend_from_slice(frame);
        }
        bytes
    };
    assert!(read_texture(&file(&good)).unwrap() == texture);
    for level in 0..3 {
        let own = &good[level];
        for (name, broken) in [
            ("of another length", frame(&[7; 3])),
            ("followed by another frame", [&own[..], &frame(&[7])].concat()),
            ("followed by bytes", [&own[..], &[0; 3]].concat()),
            ("cut short", own[..own.len() - 1].to_vec()),
            ("no frame", vec![7; 9]),
            ("empty", Vec::new()),
        ] {
            let mut frames = good.clone();
            frames[level] = broken;
            let error = read_texture(&file(&frames)).unwrap_err();
            assert_eq!(error.field, format!("level {level}"), "{name}: {error}");
        }
    }
    // A coarse level that declares a huge size is rejected before the fine ones are decompressed.
    let mut frames = good.clone();
    frames[0] = vec![0x28, 0xb5, 0x2f, 0xfd, 0x20, 15];
    frames[2] = [&[0x28, 0xb5, 0x2f, 0xfd, 0xa0][..], &u32::MAX.to_le_bytes()].concat();
    let error = read_texture(&file(&frames)).unwrap_err().to_string();
    assert_eq!(error, "level 2: found a frame of 4294967295 bytes, expected Zstandard data of 1 bytes");
}

#[test]
fn no_single_corrupt_byte_of_any_kind_of_texture_panics() {
    for (name, texture) in brdfc_testing::packs::textures().into_iter().chain(cube_maps()) {
        for supercompress in [false, true] {
            let bytes = texture.to_bytes(supercompress);
            let mut broken = bytes.clone();
            let mut refused = 0;
            for offset in 0..bytes.len() {
                for pattern in [1, 2, 4, 8, 16, 32, 64, 128, 0xff] {
                    broken[offset] = bytes[offset] ^ pattern;
                    refused += usize::from(read_texture(&broken).is_err());
                }
                broken[offset] = bytes[offset];
            }
            assert!(refused > (80 + 24 * texture.levels as usize) * 4, "{name}: {refused}");
            for length in 0..bytes.len() {
                assert!(read_texture(&bytes[..length]).is_err(), "{name}: {length} of {}", bytes.len());
            }
        }
    }
}
