//! Broken textures of every kind and format, before any pack looks at them.

use brdfc_formats::container::{Extent, TexelFormat, Texture};
use std::collections::BTreeMap;

/// Fields of the header, word by word from the width, as a reader takes or refuses them.
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
        // The ktx2 crate says this one.
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
    // One layer is an array all the same, and another file than no layers.
    let one = texture(TexelFormat::R8Unorm, Extent::D2Array([4, 4, 1]));
    assert!(one.to_bytes(false) != texture(TexelFormat::R8Unorm, Extent::D2([4, 4])).to_bytes(false));
}

#[test]
fn no_single_corrupt_byte_of_any_kind_of_texture_panics() {
    for (name, texture) in brdfc_testing::packs::textures() {
        for supercompress in [false, true] {
            let bytes = texture.to_bytes(supercompress);
            let mut broken = bytes.clone();
            let mut refused = 0;
            for offset in 0..bytes.len() {
                for pattern in [1, 2, 4, 8, 16, 32, 64, 128, 0xff] {
                    broken[offset] = bytes[offset] ^ pattern;
                    refused += usize::from(Texture::from_bytes(&broken).is_err());
                }
                broken[offset] = bytes[offset];
            }
            assert!(refused > 104 * 4, "{name}: {refused}");
            for length in 0..bytes.len() {
                assert!(Texture::from_bytes(&bytes[..length]).is_err(), "{name}: {length} of {}", bytes.len());
            }
        }
    }
}
