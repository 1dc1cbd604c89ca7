use super::*;
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// A cube map of two levels.
fn texture(format: TexelFormat, side: u32, texels: &[Vec<u8>]) -> Texture {
    let mut bytes = texels.concat();
    bytes.resize(bytes.len() + 6 * (side as usize / 2).pow(2) * format.texel_bytes(), 0xff);
    Texture { format, extent: Extent::Cube(side), entries: BTreeMap::new(), levels: 2, texels: bytes }
}

/// Radiances that all formats store exactly. Each texel is of its own.
fn colours(side: u32) -> Vec<[f32; 3]> {
    (0..6 * side * side).map(|at| [(at % 16) as f32 / 16.0, (at / 16) as f32, 0.5]).collect()
}

fn as_halves(colours: &[[f32; 3]]) -> Vec<Vec<u8>> {
    colours.iter().map(|[r, g, b]| [*r, *g, *b, 1.0].map(|c| half::encode(c).to_le_bytes()).concat()).collect()
}

fn file() -> Vec<u8> {
    texture(TexelFormat::Rgba16Float, 4, &as_halves(&colours(4))).to_bytes(false)
}

#[test]
fn all_formats_are_read_with_and_without_compression() {
    let colours = colours(4);
    let singles: Vec<Vec<u8>> =
        colours.iter().map(|[r, g, b]| [*r, *g, *b, f32::NAN].map(f32::to_le_bytes).concat()).collect();
    let shared: Vec<Vec<u8>> = colours.iter().map(|c| rgb9e5::encode(*c).to_le_bytes().to_vec()).collect();
    // The five low bits of an exponent of a half, and the high bits of its mantissa.
    let small = |[r, g, b]: &[f32; 3]| {
        let [r, g, b] = [*r, *g, *b].map(|c| u32::from(half::encode(c)));
        (r >> 4 | g >> 4 << 11 | b >> 5 << 22).to_le_bytes().to_vec()
    };
    let small: Vec<Vec<u8>> = colours.iter().map(small).collect();
    for (format, value, texels) in [
        (TexelFormat::Rgba16Float, 97u32, as_halves(&colours)),
        (TexelFormat::Rgba32Float, 109, singles),
        (TexelFormat::Rgb9E5, 123, shared),
        // Packs do not have this format, which differs only in the number of the format.
        (TexelFormat::Rgb9E5, 122, small),
    ] {
        for supercompress in [false, true] {
            let mut bytes = texture(format, 4, &texels).to_bytes(supercompress);
            bytes[12..16].copy_from_slice(&value.to_le_bytes());
            let found = CubeMap::from_bytes(&bytes).unwrap();
            assert_eq!((found.side(), found.texels()), (4, &colours[..]), "{value} {supercompress}");
        }
    }
}

#[test]
fn packs_are_recognised() {
    let mut texture = texture(TexelFormat::Rgba16Float, 4, &as_halves(&colours(4)));
    assert!(!is_pack(&texture.to_bytes(false)));
    texture.entries.insert("brdfc.environment".to_owned(), vec![1]);
    assert!(is_pack(&texture.to_bytes(true)));
}

#[test]
fn other_textures_and_broken_files_are_rejected() {
    // Offsets as in the specification of KTX2.
    for (at, value, expected) in [
        (0, 0u32, "byte 0, identifier: not the identifier of KTX2; expected a KTX2 file"),
        (12, 0, "byte 12, vkFormat: found 0, expected 97 (R16G16B16A16_SFLOAT), 109 (R32G32B32A32_SFLOAT), 122 ("),
        (12, 37, "byte 12, vkFormat: found 37, expected 97 "),
        (20, 4096, "byte 20, pixelWidth: found 4096, expected 1 to 2048 texels along each side of a face"),
        (20, 0, "byte 20, pixelWidth: found 0, expected 1 to 2048"),
        (24, 8, "byte 24, pixelHeight: found 8, expected the pixelWidth"),
        (28, 4, "byte 28, pixelDepth: found 4, expected 0"),
        (32, 2, "byte 32, layerCount: found 2, expected 0 or 1"),
        (36, 1, "byte 36, faceCount: found 1, expected 6, a cube map"),
        (40, 4, "byte 40, levelCount: found 4, expected at most the levels down to a single texel"),
        (44, 1, "byte 44, supercompressionScheme: found 1, expected 0 (none) or 2 (Zstandard)"),
        (56, 1 << 31, "byte 2147483648, key/value data: end of data; expected a complete file"),
        (84, 1, "level 0: found 768 bytes from byte 4294967"),
        (96, 767, "uncompressedByteLength: found 767, expected 768, as format and extent say"),
    ] {
        let mut bytes = file();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let found = CubeMap::from_bytes(&bytes).unwrap_err().to_string();
        assert!(found.contains(expected), "{at} {value}: {found}");
    }
    let bytes = file();
    for length in 0..bytes.len() {
        assert!(CubeMap::from_bytes(&bytes[..length]).is_err(), "{length}");
    }
    let mut turned = file();
    let at = turned.windows(3).position(|window| window == b"rd\0").unwrap();
    turned[at + 1] = b'u';
    let found = CubeMap::from_bytes(&turned).unwrap_err().to_string();
    assert_eq!(found, "KTXorientation: found \"ru\", expected \"rd\" for a cube map");
}

/// A sun beyond the largest half has become infinite in a file of halves.
#[test]
fn radiance_must_be_finite_and_positive() {
    for (value, name) in [(f32::INFINITY, "inf"), (-1.0, "-1.0"), (f32::NAN, "NaN")] {
        let mut colours = colours(4);
        colours[16 * 2 + 4 + 3] = [1.0, value, 1.0];
        let bytes = texture(TexelFormat::Rgba16Float, 4, &as_halves(&colours)).to_bytes(true);
        let found = CubeMap::from_bytes(&bytes).unwrap_err().to_string();
        let expected = format!(
            "level 0: found [1.0, {name}, 1.0] at texel (3, 1) of face +Y, expected finite values of 0 or more"
        );
        assert_eq!(found, expected);
    }
}

proptest! {
    #[test]
    fn any_bytes_are_safe(edits in prop::collection::vec((0usize..2000, any::<u8>()), 1..8), supercompress: bool) {
        let mut bytes = texture(TexelFormat::Rgba16Float, 4, &as_halves(&colours(4))).to_bytes(supercompress);
        for (at, byte) in edits {
            if let Some(found) = bytes.get_mut(at) {
                *found = byte;
            }
        }
        let _ = is_pack(&bytes);
        if let Ok(found) = CubeMap::from_bytes(&bytes) {
            prop_assert_eq!(found.texels().len(), 6 * (found.side() as usize).pow(2));
        }
    }
}
