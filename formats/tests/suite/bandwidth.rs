//! Bandwidth maps: the dump and the worked value of their page, broken files, the shader.

use brdfc_formats::bandwidth::shader::BANDWIDTH_WGSL;
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_testing::packs::{Numbers, check_dump, rebind, sealed};
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// The map in the dump of the page.
fn example() -> BandwidthMap {
    let kind = BandwidthKind::Texture { metres: [0.5, 0.25], tiles: true };
    let header = BandwidthHeader { kind, epsilon: 0.01, transformed: [4, 2] };
    BandwidthMap::new(header, [2, 1], &[8.0, 12.5]).unwrap()
}

fn maps() -> Vec<BandwidthMap> {
    let mut numbers = Numbers::new(4);
    let mut map = |kind, size: [u32; 2]| {
        let header = BandwidthHeader { kind, epsilon: 0.02, transformed: [64, 64] };
        let values: Vec<f32> = (0..size[0] * size[1]).map(|_| numbers.between(0.0, 40.0) as f32).collect();
        BandwidthMap::new(header, size, &values).unwrap()
    };
    vec![
        map(BandwidthKind::Brdf, [256; 2]),
        map(BandwidthKind::Environment, [5, 3]),
        map(BandwidthKind::Texture { metres: [2.0, 0.1], tiles: false }, [1, 7]),
        example(),
    ]
}

#[test]
fn maps_round_trip() {
    for map in maps() {
        for supercompress in [false, true] {
            let bytes = map.to_bytes(supercompress);
            let read = BandwidthMap::from_bytes(&bytes).unwrap();
            assert_eq!(read, map);
            assert_eq!(read.to_bytes(supercompress), bytes);
        }
    }
}

#[test]
fn the_dump_on_the_page() {
    let page = include_str!("../../src/bandwidth/spec.md");
    let bytes = example().to_bytes(false);
    assert_eq!(check_dump(page, &bytes), bytes.len().div_ceil(16));
    assert_eq!(example().texture([1.75, 0.5]), 12.5);
}

#[test]
fn truncated_and_corrupt_files_do_not_panic() {
    for map in &maps()[1..] {
        for supercompress in [false, true] {
            let bytes = map.to_bytes(supercompress);
            for length in 0..bytes.len() {
                let cut = sealed(bytes[..length].to_vec());
                assert!(BandwidthMap::from_bytes(&cut).is_err(), "{length} of {}", bytes.len());
            }
            let mut broken = bytes.clone();
            for offset in 0..bytes.len() {
                for pattern in [1, 4, 64, 128, 0x7f, 0xff] {
                    broken[offset] = bytes[offset] ^ pattern;
                    if let Ok(map) = BandwidthMap::from_bytes(&sealed(broken.clone())) {
                        let found = [
                            map.brdf([0.6, 0.0, 0.8], [0.0, -0.6, 0.8]),
                            map.environment([1.0, -2.0, -3.0]),
                            map.texture([-7.3, 2.2]),
                        ];
                        assert!(found.iter().chain(&map.values()).all(|v| v.is_finite() && *v >= 0.0), "{offset}");
                    }
                }
                broken[offset] = bytes[offset];
            }
        }
    }
}

fn refusal(texture: &Texture) -> String {
    BandwidthMap::from_bytes(&sealed(texture.to_bytes(false))).unwrap_err().to_string()
}

#[test]
fn fields_out_of_range_are_named() {
    let texture = |map: &BandwidthMap| Texture::from_bytes(&map.to_bytes(false)).unwrap();
    let [environment, cloth] = [&maps()[1], &example()].map(texture);
    let with = |texture: &Texture, word: usize, value: u32| {
        let mut changed = texture.clone();
        changed.entries.get_mut("brdfc.bandwidth").unwrap()[4 * word..4 * word + 4]
            .copy_from_slice(&value.to_le_bytes());
        refusal(&changed)
    };
    let bits = f32::to_bits;
    for (word, value, expected) in [
        (0, 2, "brdfc.bandwidth version: found 2, expected 1"),
        (1, 3, "brdfc.bandwidth kind: found 3, expected 0 (brdf), 1 (environment) or 2 (texture)"),
        (1, 1, "brdfc.bandwidth unit: found 1, expected 0 (cycles per radian) for the kind environment"),
        (2, 0, "brdfc.bandwidth unit: found 0, expected 1 (cycles per metre) for the kind texture"),
        (3, 0, "brdfc.bandwidth epsilon: found 0, expected a positive number of at most 1"),
        (3, bits(f32::NAN), "brdfc.bandwidth epsilon: found NaN, expected"),
        (3, bits(1.5), "brdfc.bandwidth epsilon: found 1.5, expected"),
        (4, 0, "brdfc.bandwidth transformed size: found 0, expected 1 to 65536"),
        (5, 65_537, "brdfc.bandwidth transformed size: found 65537"),
        (6, bits(-1.0), "brdfc.bandwidth metres: found -1, expected a positive number"),
        (7, bits(f32::INFINITY), "brdfc.bandwidth metres: found inf"),
        (8, 2, "brdfc.bandwidth tiles: found 2, expected 0 or 1"),
        (9, bits(3.0), "brdfc.bandwidth scale: found 3, expected a power of two from 1 to 2^112"),
        (9, bits(0.5), "brdfc.bandwidth scale: found 0.5"),
        (9, bits(2f32.powi(113)), "brdfc.bandwidth scale: found"),
    ] {
        let found = with(&cloth, word, value);
        assert!(found.starts_with(expected), "{found}");
    }
    assert!(with(&environment, 8, 1).starts_with("brdfc.bandwidth metres: found 0 x 0 metres, tiles 1"));
    assert_eq!(with(&environment, 1, 0), "size of a bandwidth map: found 5 x 3, expected 256 x 256 for a BRDF");
    let mut entryless = cloth.clone();
    entryless.entries.remove("brdfc.bandwidth");
    assert!(refusal(&entryless).starts_with("brdfc.bandwidth: no brdfc keys"));
    let mut long = cloth.clone();
    long.entries.get_mut("brdfc.bandwidth").unwrap().push(0);
    assert_eq!(refusal(&long), "brdfc.bandwidth: found 41 bytes, expected 40 bytes");
}

#[test]
fn invalid_texels_and_shapes() {
    let good = Texture::from_bytes(&example().to_bytes(false)).unwrap();
    for bad in [0x7c00u16, 0x7e00, 0x8000, 0xbc00, 0xffff] {
        let mut changed = good.clone();
        changed.texels[2..4].copy_from_slice(&bad.to_le_bytes());
        assert!(refusal(&changed).starts_with("bandwidth texel (1, 0): found "), "{bad:#x}");
    }
    // Another shape, declared by its bindings.
    let reshaped = |format: TexelFormat, extent: Extent| {
        let texels = vec![0; extent.texels() as usize * format.texel_bytes()];
        let mut changed = Texture { format, extent, texels, ..good.clone() };
        let [width, height, depth] = extent.size();
        let shape = format!("texture file {} {} {width} {height} {depth} ", extent.dimension(), format.name());
        rebind(&mut changed, "texture file 2d r16float 2 1 1 ", &shape);
        refusal(&changed)
    };
    let flat = reshaped(TexelFormat::R16Unorm, Extent::D2([2, 1]));
    assert_eq!(flat, "texels of a bandwidth map: found R16Unorm, expected R16Float");
    for extent in [Extent::D2Array([2, 1, 1]), Extent::D3([2, 1, 1])] {
        assert!(reshaped(TexelFormat::R16Float, extent).ends_with("expected a 2D texture"), "{extent}");
    }
    let wide = reshaped(TexelFormat::R16Float, Extent::D2([513, 1]));
    assert_eq!(wide, "size of a bandwidth map: found 513 x 1, expected 1 to 512 on each side");
    // A kind that differs from its bindings.
    let mut other = good.clone();
    rebind(&mut other, "33 bandwidth_texture_parameters", "31 bandwidth_texture_parameters");
    let expected = "brdfc.bindings line 2: found 31 bandwidth_texture_parameters uniform 16, expected 33 ";
    assert!(refusal(&other).starts_with(expected), "{}", refusal(&other));
}

fn validates(source: &str) -> bool {
    naga::front::wgsl::parse_str(source)
        .is_ok_and(|module| Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).is_ok())
}

#[test]
fn the_shader_validates() {
    assert!(validates(BANDWIDTH_WGSL));
    let broken = BANDWIDTH_WGSL.replace("let half_turn =", "let half_turn: u32 =");
    assert!(broken != BANDWIDTH_WGSL && !validates(&broken));
    assert!(!BANDWIDTH_WGSL.contains("textureSample("));
}

#[test]
fn the_uniform_block_is_the_one_that_rust_writes() {
    let module = naga::front::wgsl::parse_str(BANDWIDTH_WGSL).unwrap();
    let block = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("BandwidthParameters")).unwrap().1;
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("not a struct") };
    assert_eq!(*span as usize, BandwidthMap::UNIFORM_SIZE);
    let names: Vec<_> = members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset)).collect();
    assert_eq!(names, [("scale", 0), ("tiles", 4), ("reserved_0", 8), ("reserved_1", 12)]);
    assert_eq!(example().uniform(), [0, 0, 0x80, 0x3f, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
}
