//! Rules of the Khronos validator, checked here on the raw bytes, because its binary is not available everywhere.

use crate::cube_maps::cube_maps;
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::wavelet::WaveletPack;
use std::collections::BTreeMap;

/// Key of the index map of a wavelet pack.
const IMAGE: &str = "brdfc.image.wavelet_brdf_index";

struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn u16(&self, at: usize) -> u32 {
        u32::from(u16::from_le_bytes(self.0[at..at + 2].try_into().unwrap()))
    }

    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.0[at..at + 4].try_into().unwrap())
    }

    fn u64(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.0[at..at + 8].try_into().unwrap())
    }
}

/// Expected representation of a texture in a file.
#[derive(Clone)]
struct Expected {
    vk_format: u32,
    type_size: u32,
    /// Width, height, depth, layer count and face count of the header.
    fields: [u32; 5],
    texel_bytes: u32,
    levels: u32,
    samples: Vec<Sample>,
}

/// Bit offset, bits, channel with qualifiers, lower and upper limit.
type Sample = (u32, u32, u8, u32, u32);

const ONE: u32 = 0x3f80_0000;
const MINUS_ONE: u32 = 0xbf80_0000;
/// Float, signed.
const FLOAT: u8 = 0xc0;
/// Red, green, blue, alpha.
const CHANNELS: [u8; 4] = [0, 1, 2, 15];

fn unorm(components: u32, bits: u32) -> Vec<Sample> {
    (0..components).map(|k| (k * bits, bits, CHANNELS[k as usize], 0, (1 << bits) - 1)).collect()
}

fn float(components: u32, bits: u32) -> Vec<Sample> {
    (0..components).map(|k| (k * bits, bits, CHANNELS[k as usize] | FLOAT, MINUS_ONE, ONE)).collect()
}

fn integers(components: u32) -> Vec<Sample> {
    (0..components).map(|k| (32 * k, 32, CHANNELS[k as usize], 0, 1)).collect()
}

/// A mantissa and the shared exponent, biased by 15, for each channel. 8448 is 2^13 + 2^8, which the validator of the
/// Khronos tools requires.
fn shared_exponent() -> Vec<Sample> {
    const EXPONENT: u8 = 0x20;
    (0..3u8).flat_map(|k| [(9 * u32::from(k), 9, k, 0, 8448), (27, 5, k | EXPONENT, 15, 31)]).collect()
}

/// Three components of 10 bits and one of 2.
fn ten_bits() -> Vec<Sample> {
    (0..4)
        .map(|k| (10 * k, if k == 3 { 2 } else { 10 }, CHANNELS[k as usize], 0, if k == 3 { 3 } else { 1023 }))
        .collect()
}

fn expected(pack: &WaveletPack) -> Expected {
    let (components, vk_formats) = if pack.header.channels == 1 { (1, [9, 70]) } else { (4, [37, 91]) };
    let wide = usize::from(pack.header.bits > 8);
    let component_bytes = [1, 2][wide];
    let grid = 1 << pack.header.levels;
    let [width, height] = pack.crop.map_or([grid, grid], |crop| crop.window.size);
    Expected {
        vk_format: vk_formats[wide],
        type_size: component_bytes,
        fields: [width, height, pack.scales.len() as u32, 0, 1],
        texel_bytes: components * component_bytes,
        levels: 1,
        samples: unorm(components, 8 * component_bytes),
    }
}

/// From the tables of the Khronos data format specification.
fn expected_texture(texture: &Texture) -> Expected {
    let (vk_format, type_size, texel_bytes, samples) = match texture.format {
        TexelFormat::R8Unorm => (9, 1, 1, unorm(1, 8)),
        TexelFormat::Rg8Unorm => (16, 1, 2, unorm(2, 8)),
        TexelFormat::Rgba8Unorm => (37, 1, 4, unorm(4, 8)),
        TexelFormat::R16Unorm => (70, 2, 2, unorm(1, 16)),
        TexelFormat::R16Float => (76, 2, 2, float(1, 16)),
        TexelFormat::Rgba16Unorm => (91, 2, 8, unorm(4, 16)),
        TexelFormat::Rgba16Float => (97, 2, 8, float(4, 16)),
        TexelFormat::Rg16Float => (83, 2, 4, float(2, 16)),
        TexelFormat::Rgba32Float => (109, 4, 16, float(4, 32)),
        TexelFormat::R32Uint => (98, 4, 4, integers(1)),
        TexelFormat::Rgba32Uint => (107, 4, 16, integers(4)),
        TexelFormat::Rgb9E5 => (123, 4, 4, shared_exponent()),
        TexelFormat::Rgb10A2Unorm => (64, 4, 4, ten_bits()),
    };
    let fields = match texture.extent {
        Extent::D2([width, height]) => [width, height, 0, 0, 1],
        Extent::D2Array([width, height, layers]) => [width, height, 0, layers, 1],
        Extent::D3([width, height, depth]) => [width, height, depth, 0, 1],
        Extent::Cube(side) => [side, side, 0, 0, 6],
    };
    Expected { vk_format, type_size, fields, texel_bytes, levels: texture.levels, samples }
}

fn check_header(file: &Bytes<'_>, expected: &Expected, supercompressed: bool) {
    assert_eq!(file.0[..12], [0xab, 0x4b, 0x54, 0x58, 0x20, 0x32, 0x30, 0xbb, 0x0d, 0x0a, 0x1a, 0x0a], "identifier");
    let [width, height, depth, layers, faces] = expected.fields;
    let fields = [
        (12, "vkFormat", expected.vk_format),
        (16, "typeSize", expected.type_size),
        (20, "pixelWidth", width),
        (24, "pixelHeight", height),
        (28, "pixelDepth", depth),
        (32, "layerCount", layers),
        (36, "faceCount", faces),
        (40, "levelCount", expected.levels),
        (44, "supercompressionScheme", if supercompressed { 2 } else { 0 }),
    ];
    for (at, field, value) in fields {
        assert_eq!(file.u32(at), value, "{field}");
    }
    assert_eq!((file.u64(64), file.u64(72)), (0, 0), "no global data");
}

fn check_descriptor(file: &Bytes<'_>, expected: &Expected) {
    let samples = &expected.samples;
    let start = file.u32(48) as usize;
    let length = file.u32(52);
    assert_eq!(start, 80 + 24 * expected.levels as usize, "the descriptor follows the level index");
    assert_eq!(file.u32(start), length, "dfdTotalSize");
    assert_eq!(length, 4 + 24 + 16 * samples.len() as u32, "one basic block");
    let block = start + 4;
    assert_eq!(file.u32(block), 0, "vendorId Khronos, descriptorType basic");
    assert_eq!(file.u16(block + 4), 2, "versionNumber of the Khronos data format 1.3");
    assert_eq!(file.u16(block + 6), length - 4, "descriptorBlockSize");
    assert_eq!(file.0[block + 8], 1, "colorModel RGBSDA");
    assert_eq!(file.0[block + 9], 1, "colorPrimaries BT.709");
    assert_eq!(file.0[block + 10], 1, "transferFunction linear");
    assert_eq!(file.0[block + 11], 0, "flags: straight alpha");
    assert_eq!(file.0[block + 12..block + 16], [0; 4], "texel block of 1 x 1 x 1 x 1");
    assert_eq!(u32::from(file.0[block + 16]), expected.texel_bytes, "bytesPlane0, also when supercompressed");
    assert_eq!(file.0[block + 17..block + 24], [0; 7], "one plane");
    for (k, (offset, bits, channel, lower, upper)) in samples.iter().enumerate() {
        let sample = block + 24 + 16 * k;
        assert_eq!(file.u16(sample), *offset, "bitOffset");
        assert_eq!(u32::from(file.0[sample + 2]) + 1, *bits, "bitLength");
        assert_eq!(file.0[sample + 3], *channel, "channelType and qualifiers");
        assert_eq!(file.0[sample + 4..sample + 8], [0; 4], "samplePosition");
        assert_eq!(file.u32(sample + 8), *lower, "sampleLower");
        assert_eq!(file.u32(sample + 12), *upper, "sampleUpper");
    }
}

/// Keys and values, after checks of their order, lengths and padding.
fn entries(file: &Bytes<'_>) -> Vec<(String, Vec<u8>)> {
    let (start, length) = (file.u32(56) as usize, file.u32(60) as usize);
    assert_eq!(start as u32, file.u32(48) + file.u32(52), "entries follow the descriptor");
    assert_eq!(start % 4, 0);
    let end = start + length;
    let mut entries: Vec<(String, Vec<u8>)> = Vec::new();
    let mut at = start;
    while at < end {
        let pair = &file.0[at + 4..][..file.u32(at) as usize];
        let nul = pair.iter().position(|byte| *byte == 0).expect("a key ends with NUL");
        let key = std::str::from_utf8(&pair[..nul]).expect("a key is UTF-8");
        assert!(!key.is_empty() && !key.starts_with('\u{feff}'));
        if let Some((last, _)) = entries.last() {
            assert!(last.chars().lt(key.chars()), "{last} before {key}: sorted by code point and unique");
        }
        at += 4 + pair.len();
        let padding = at.next_multiple_of(4);
        assert!(file.0[at..padding].iter().all(|byte| *byte == 0), "padding after {key}");
        at = padding;
        entries.push((key.to_owned(), pair[nul + 1..].to_vec()));
    }
    assert_eq!(at, end, "kvdByteLength includes the last padding");
    entries
}

/// The index begins with level 0, the finest; the file begins with the coarsest level.
fn check_levels(file: &Bytes<'_>, expected: &Expected, supercompressed: bool) {
    let [width, height, depth, layers, faces] = expected.fields.map(|n| n.max(1));
    assert!(1 << (expected.levels - 1) <= width.max(height).max(depth), "levelCount: halved below one texel");
    let texel = u64::from(expected.texel_bytes);
    let alignment = if supercompressed { 1 } else { (1..).map(|k| k * texel).find(|n| n % 4 == 0).unwrap() };
    let mut end = u64::from(file.u32(56) + file.u32(60));
    for level in (0..expected.levels).rev() {
        let entry = 80 + 24 * level as usize;
        let (offset, length, uncompressed) = (file.u64(entry), file.u64(entry + 8), file.u64(entry + 16));
        let sides = [width, height, depth].map(|side| u64::from((side >> level).max(1)));
        let size = sides.into_iter().product::<u64>() * u64::from(layers * faces) * texel;
        assert_eq!(uncompressed, size, "uncompressedByteLength of level {level}");
        assert_eq!(
            offset,
            end.next_multiple_of(alignment),
            "level {level}: aligned to lcm(texel size, 4), or to nothing"
        );
        assert!(file.0[end as usize..offset as usize].iter().all(|byte| *byte == 0), "padding before level {level}");
        assert!(supercompressed || length == uncompressed, "byteLength of level {level}");
        end = offset + length;
    }
    assert_eq!(end, file.0.len() as u64, "the file ends with level 0");
}

/// Runs all checks and returns the key/value data.
fn check(bytes: &[u8], expected: &Expected, supercompressed: bool) -> Vec<(String, Vec<u8>)> {
    let file = Bytes(bytes);
    check_header(&file, expected, supercompressed);
    check_descriptor(&file, expected);
    let entries = entries(&file);
    check_levels(&file, expected, supercompressed);
    let flat = expected.fields[2] == 0;
    assert_eq!(entries[0], ("KTXorientation".to_owned(), if flat { b"rd\0".to_vec() } else { b"rdi\0".to_vec() }));
    assert_eq!(entries[1], ("KTXwriter".to_owned(), b"brdfc\0".to_vec()));
    entries
}

#[test]
fn files_follow_the_rules_of_the_validator() {
    for (name, pack) in brdfc_testing::codecs::wavelet::packs() {
        for supercompress in [false, true] {
            println!("{name}, supercompress {supercompress}");
            let entries = check(&pack.to_bytes(supercompress), &expected(&pack), supercompress);
            let keys: Vec<&str> = entries.iter().skip(2).map(|(key, _)| key.as_str()).collect();
            let crop = usize::from(pack.crop.is_none());
            let ours =
                ["brdfc.crop", IMAGE, "brdfc.uniform.wavelet_brdf_parameters", "brdfc.wavelet", "brdfc.wavelet.errors"];
            assert_eq!(keys[..2], ["brdfc.bindings", "brdfc.checksum"]);
            assert_eq!(keys[2..], ours[crop..]);
            // The image stored as key/value data also follows them.
            let image = &entries.iter().find(|(key, _)| key == IMAGE).unwrap().1;
            let texture = brdfc_testing::packs::read_texture(image).unwrap();
            assert_eq!(check(image, &expected_texture(&texture), supercompress).len(), 2);
        }
    }
}

#[test]
fn every_kind_of_texture_follows_the_rules_of_the_validator() {
    let (textures, cube_maps) = (brdfc_testing::packs::textures(), cube_maps());
    assert_eq!((textures.len(), cube_maps.len()), (13 * 11, 13 * 4));
    for (name, texture) in textures.into_iter().chain(cube_maps) {
        for supercompress in [false, true] {
            println!("{name}, supercompress {supercompress}");
            let bytes = texture.to_bytes(supercompress);
            let entries = check(&bytes, &expected_texture(&texture), supercompress);
            assert_eq!(entries.into_iter().skip(2).collect::<BTreeMap<_, _>>(), texture.entries);
            assert!(brdfc_testing::packs::read_texture(&bytes).unwrap() == texture);
            // Another reader.
            let reader = ktx2::Reader::new(&bytes[..]).unwrap();
            let levels = reader
                .levels()
                .map(|level| if supercompress { zstd::decode_all(level.data).unwrap() } else { level.data.to_vec() });
            assert!(levels.collect::<Vec<_>>().concat() == texture.texels);
        }
    }
}

#[test]
fn another_reader_finds_the_same_texels_and_metadata() {
    for (name, pack) in brdfc_testing::codecs::wavelet::packs() {
        for supercompress in [false, true] {
            println!("{name}, supercompress {supercompress}");
            let bytes = pack.to_bytes(supercompress);
            let reader = ktx2::Reader::new(&bytes[..]).unwrap();
            let level = reader.levels().next().unwrap();
            let texels = match reader.header().supercompression_scheme {
                None => level.data.to_vec(),
                Some(ktx2::SupercompressionScheme::Zstandard) => zstd::decode_all(level.data).unwrap(),
                other => panic!("{other:?}"),
            };
            assert_eq!(texels, pack.texels);
            let found: Vec<_> = reader.key_value_data().map(|(key, value)| (key.to_owned(), value.to_vec())).collect();
            assert_eq!(found, entries(&Bytes(&bytes)));
            check_entries(&pack, |key| &found.iter().find(|(name, _)| name == key).unwrap().1);
        }
    }
}

/// Compares all key/value data with the original pack, at the offsets in `formats/src/wavelet/spec.md`.
fn check_entries<'a>(pack: &WaveletPack, entry: impl Fn(&str) -> &'a [u8]) {
    let header = Bytes(entry("brdfc.wavelet"));
    let h = &pack.header;
    let words = [
        2,
        h.parameterisation.code(),
        h.levels,
        h.stored_levels,
        h.channels,
        h.bits,
        pack.scales.len() as u32,
        h.mean.to_bits(),
        h.bias.to_bits(),
        u32::from(h.energy_preserving),
    ];
    assert_eq!(header.0.len(), 40);
    for (k, word) in words.into_iter().enumerate() {
        assert_eq!(header.u32(4 * k), word, "word {k}");
    }
    let index = brdfc_testing::packs::read_texture(entry(IMAGE)).unwrap();
    assert_eq!(
        (index.format, index.texels.len()),
        (TexelFormat::Rgba32Float, 16 * pack.index.len().next_multiple_of(h.grid()))
    );
    for (k, slice) in pack.index.iter().enumerate() {
        let scale = pack.scales[usize::from(*slice)];
        let expected = [f32::from(*slice), scale.scale, scale.offset].map(f32::to_bits);
        assert_eq!([0, 4, 8].map(|word| Bytes(&index.texels[16 * k..]).u32(word)), expected, "coefficient {k}");
    }
    let errors = Bytes(entry("brdfc.wavelet.errors"));
    assert_eq!(errors.0.len(), 80);
    for (start, e) in [(0, pack.on_grid), (40, pack.off_grid)] {
        assert_eq!(errors.u32(start), e.samples);
        let ratios = [
            e.rms,
            e.relative_mean,
            e.relative_p95,
            e.relative_p99,
            e.relative_max,
            e.log_rms,
            e.cosine_log_rms,
            e.albedo_max_difference,
            e.reciprocity,
        ];
        for (k, ratio) in ratios.into_iter().enumerate() {
            assert_eq!(errors.u32(start + 4 * (k + 1)), ratio.to_bits(), "ratio {k}");
        }
    }
}

#[test]
fn packs_round_trip() {
    for (name, pack) in brdfc_testing::codecs::wavelet::packs() {
        for supercompress in [false, true] {
            let read = WaveletPack::from_bytes(&pack.to_bytes(supercompress)).unwrap();
            assert_eq!(read, pack, "{name}");
            // Equal numbers can have different bits; files cannot.
            assert_eq!(read.to_bytes(false), pack.to_bytes(false), "{name}");
        }
    }
}

/// Negative control: the checks above detect broken files.
#[test]
fn the_checks_detect_broken_files() {
    let pack = brdfc_testing::codecs::wavelet::example();
    // One sample, like the pack, and three levels with padding between them.
    let texture = Texture {
        format: TexelFormat::R8Unorm,
        extent: Extent::D2([5, 3]),
        entries: BTreeMap::new(),
        levels: 3,
        texels: (0..18).collect(),
    };
    for (good, expected) in
        [(pack.to_bytes(false), expected(&pack)), (texture.to_bytes(false), expected_texture(&texture))]
    {
        let noticed = |bytes: &[u8]| {
            let (bytes, expected) = (bytes.to_vec(), expected.clone());
            std::panic::catch_unwind(move || check(&bytes, &expected, false)).is_err()
        };
        assert!(!noticed(&good));
        for offset in 0..80 + 24 * expected.levels as usize + 44 {
            let mut broken = good.clone();
            broken[offset] ^= 1;
            assert!(noticed(&broken), "byte {offset}");
        }
        let mut longer = good;
        longer.push(0);
        assert!(noticed(&longer));
    }
    // Levels in the other order: the finest first in the file, or the coarsest first in the index.
    let good = texture.to_bytes(false);
    let texels = good.len() - 23;
    assert_eq!(good[texels..texels + 8], [17, 0, 0, 0, 15, 16, 0, 0], "the two coarse levels and their padding");
    let entry = |level: usize| 80 + 24 * level..104 + 24 * level;
    let swapped = [&good[..80], &good[entry(2)], &good[entry(1)], &good[entry(0)], &good[152..]].concat();
    let coarse = &good[texels..texels + 6];
    let mut finest_first = [&good[..texels], &good[texels + 8..], &[0], coarse].concat();
    for (level, place) in [(0, 0), (1, 20), (2, 16)] {
        let offset = (texels + place) as u64;
        finest_first[80 + 24 * level..88 + 24 * level].copy_from_slice(&offset.to_le_bytes());
    }
    for broken in [swapped, finest_first] {
        let expected = expected_texture(&texture);
        assert!(std::panic::catch_unwind(move || check(&broken, &expected, false)).is_err());
    }
}
