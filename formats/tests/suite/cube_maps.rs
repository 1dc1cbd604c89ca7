//! Cube maps in the container: round trips and rejected headers.

use brdfc_formats::container::{Extent, PackedTexture, TexelFormat, Texture};
use brdfc_testing::packs::{Numbers, read_texture};
use std::collections::BTreeMap;

/// A cube map with random texels.
fn cube_map(format: TexelFormat, side: u32, levels: u32) -> Texture {
    let (extent, mut numbers) = (Extent::Cube(side), Numbers::new(u64::from(side + levels)));
    let mut texels = vec![0; extent.texels_of_levels(levels) as usize * format.texel_bytes()];
    texels.fill_with(|| numbers.bits() as u8);
    let entries = BTreeMap::from([("brdfc.note".to_owned(), vec![7; 3])]);
    Texture { format, extent, entries, levels, texels }
}

/// Cube maps of every format, some with mipmap levels.
pub fn cube_maps() -> Vec<(String, Texture)> {
    let of = |format| {
        [(1, 1), (5, 1), (4, 3), (5, 2)].map(|(side, levels)| {
            (format!("{format:?}, cube map of {side}, levels {levels}"), cube_map(format, side, levels))
        })
    };
    TexelFormat::ALL.into_iter().flat_map(of).collect()
}

#[test]
fn cube_maps_round_trip() {
    for (name, texture) in cube_maps() {
        for supercompress in [false, true] {
            let bytes = texture.to_bytes(supercompress);
            let packed = PackedTexture::from_bytes(&bytes).unwrap();
            assert_eq!((packed.extent, packed.levels), (texture.extent, texture.levels), "{name}");
            assert!(read_texture(&bytes).unwrap() == texture, "{name}");
        }
    }
    let largest = Texture { entries: BTreeMap::new(), ..cube_map(TexelFormat::R8Unorm, 2048, 1) };
    assert!(Texture::from_bytes(&largest.to_bytes(false)).unwrap() == largest);
}

/// Width, height, depth, layer count and face count of the header.
#[test]
fn headers_of_cube_maps_are_checked() {
    for supercompress in [false, true] {
        let good = cube_map(TexelFormat::Rgba16Float, 4, 3).to_bytes(supercompress);
        let with = |fields: [u32; 5]| {
            let mut bytes = good.clone();
            bytes[20..40].copy_from_slice(&fields.map(u32::to_le_bytes).concat());
            read_texture(&bytes)
        };
        assert_eq!(with([4, 4, 0, 0, 6]).unwrap().extent, Extent::Cube(4));
        for (fields, expected) in [
            ([2049, 2049, 0, 0, 6], "byte 20, pixelWidth: found 2049, expected 1 to 2048 for a cube map"),
            ([4, 2, 0, 0, 6], "byte 24, pixelHeight: found 2, expected 4, the pixelWidth of a cube map"),
            ([4, 0, 0, 0, 6], "byte 24, pixelHeight: found 0, expected 4, the pixelWidth of a cube map"),
            ([4, 4, 1, 0, 6], "byte 28, pixelDepth: found 1, expected 0 for a cube map"),
            ([4, 4, 0, 1, 6], "byte 32, layerCount: found 1, expected 0 for a cube map"),
            ([4, 4, 0, 2, 6], "byte 32, layerCount: found 2, expected 0 for a cube map"),
            ([4, 4, 0, 0, 2], "byte 36, faceCount: found 2, expected 1, or 6 for a cube map"),
            ([4, 4, 0, 0, 12], "byte 36, faceCount: found 12, expected 1, or 6 for a cube map"),
            ([4, 4, 0, 0, u32::MAX], "byte 36, faceCount: found 4294967295, expected 1, or 6 for a cube map"),
            // The levels have other lengths.
            ([5, 5, 0, 0, 6], "byte 96, uncompressedByteLength: found 768, expected 1200, as format and extent say"),
            ([4, 4, 0, 0, 1], "byte 96, uncompressedByteLength: found 768, expected 128, as format and extent say"),
        ] {
            assert_eq!(with(fields).unwrap_err().to_string(), expected, "{fields:?}");
        }
        // These errors come from the ktx2 crate.
        for fields in [[0, 0, 0, 0, 6], [4, 4, 0, 0, 0]] {
            assert_eq!(with(fields).unwrap_err().field, "container", "{fields:?}");
        }
    }
}
