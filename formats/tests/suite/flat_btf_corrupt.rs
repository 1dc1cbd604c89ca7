//! Broken and hostile parts of flat BTFs: each is refused with a reason, or is a part that decodes to numbers.

use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat, Texture, half};
use brdfc_formats::flat_btf::factored::{BasisMap, ShadowFormat, ShadowMap, WeightMap};
use brdfc_formats::flat_btf::{
    DiffuseMap, DisplacementMap, FlatBtfDecoder, FlatBtfParts, FlatHeader, FlatView, IndirectionHeader, IndirectionMap,
    NormalMap, ReferenceMap, SampledDirections, VisibilityMask,
};
use brdfc_testing::flat_btf::{self, Factors, SMALL};
use std::collections::BTreeMap;

/// Every kind of part: its name, a file, and its reader.
type Part = (&'static str, Vec<u8>, fn(&[u8]) -> Result<(), FormatError>);

fn parts(supercompress: bool) -> Vec<Part> {
    let parts = flat_btf::parts(SMALL, 8);
    let factors = Factors { levels: 2, groups: 1, wide_groups: 1, shadow: ShadowFormat::R8 };
    let factored = flat_btf::factored(SMALL, factors, 8);
    let shadow = factored.shadow().expect("it has shadows");
    let directions = SampledDirections::of(&parts.values).unwrap().expect("it has views");
    vec![
        ("directions", directions.to_bytes(supercompress), |b| SampledDirections::from_bytes(b).map(drop)),
        ("basis", factored.basis().to_bytes(supercompress), |b| BasisMap::from_bytes(b).map(drop)),
        ("weights", factored.weights().to_bytes(supercompress), |b| WeightMap::from_bytes(b).map(drop)),
        ("shadow", shadow.to_bytes(supercompress), |b| ShadowMap::from_bytes(b).map(drop)),
        ("normal", parts.normal.to_bytes(supercompress), |b| NormalMap::from_bytes(b).map(drop)),
        ("diffuse", parts.diffuse.to_bytes(supercompress), |b| DiffuseMap::from_bytes(b).map(drop)),
        ("reference", parts.reference.to_bytes(supercompress), |b| ReferenceMap::from_bytes(b).map(drop)),
        ("indirection", parts.indirection.samples().unwrap().to_bytes(supercompress), |b| {
            IndirectionMap::from_bytes(b).map(drop)
        }),
        ("displacement", flat_btf::displacements(SMALL, 1, 8).to_bytes(supercompress), |b| {
            DisplacementMap::from_bytes(b).map(drop)
        }),
        ("mask", flat_btf::mask(SMALL, 1).to_bytes(supercompress), |b| VisibilityMask::from_bytes(b).map(drop)),
        ("flat", parts.values.views()[1].to_bytes(supercompress), |b| FlatView::from_bytes(b).map(drop)),
    ]
}

#[test]
fn no_truncation_and_no_corrupt_byte_panics() {
    for supercompress in [false, true] {
        for (name, bytes, read) in parts(supercompress) {
            assert!(read(&bytes).is_ok(), "{name}");
            for length in 0..bytes.len() {
                assert!(read(&bytes[..length]).is_err(), "{name}: {length} of {}", bytes.len());
            }
            let mut broken = bytes.clone();
            for offset in 0..bytes.len() {
                for pattern in [1, 4, 64, 128, 0x7f, 0xff] {
                    broken[offset] = bytes[offset] ^ pattern;
                    drop(read(&broken));
                }
                broken[offset] = bytes[offset];
            }
        }
    }
}

/// No part is read as another one, but for parts that hold the same kind of texels in the same shape.
#[test]
fn parts_are_not_taken_for_each_other() {
    let all = parts(true);
    for (name, _, read) in &all {
        for (other, bytes, _) in &all {
            assert_eq!(read(bytes).is_ok(), name == other, "{other} as {name}");
        }
    }
}

fn texture(bytes: &[u8]) -> Texture {
    Texture::from_bytes(bytes).unwrap()
}

/// A part of which one texel of halves or floats was replaced.
fn with_texel(bytes: &[u8], at: usize, texel: &[u8]) -> Vec<u8> {
    let mut texture = texture(bytes);
    texture.texels[at * texel.len()..][..texel.len()].copy_from_slice(texel);
    texture.to_bytes(false)
}

fn floats<const N: usize>(values: [f32; N]) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

fn halves(values: [f32; 4]) -> Vec<u8> {
    values.into_iter().flat_map(|value| half::encode(value).to_le_bytes()).collect()
}

#[test]
fn values_out_of_range_are_named_with_their_texel() {
    let nan = f32::NAN;
    let parts = flat_btf::parts(SMALL, 8);
    let normal = parts.normal.to_bytes(false);
    for bad in [[0.0; 4], [0.7, 0.7, 0.7, 0.0], [nan, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0], [f32::INFINITY; 4]] {
        let error = NormalMap::from_bytes(&with_texel(&normal, 15, &halves(bad))).unwrap_err();
        assert_eq!(error.field, "normal texel (3, 3)", "{bad:?}");
    }
    let reference = parts.reference.to_bytes(false);
    for bad in [[nan, 0.0], [0.0, f32::NEG_INFINITY], [1024.5, 0.0]] {
        let error = ReferenceMap::from_bytes(&with_texel(&reference, 2, &floats(bad))).unwrap_err();
        assert_eq!(error.field, "reference texel (0, 1)", "{bad:?}");
    }
    let mut mask = texture(&flat_btf::mask(SMALL, 1).to_bytes(false));
    mask.texels[9] = 128;
    let error = VisibilityMask::from_bytes(&mask.to_bytes(false)).unwrap_err();
    assert_eq!(error.to_string(), "mask texel 9: found 128; allowed 0 (filled in) or 255 (seen)");
}

/// Texels of the example: one block of 2 columns and 4 rows.
#[test]
fn the_rules_of_a_block() {
    let bytes = flat_btf::example_indirection().to_bytes(false);
    let refusal = |at: usize, texel: [f32; 4]| {
        // The pole of the row keeps to its own rule.
        let [x, y, ..] = texel;
        let bytes = with_texel(&bytes, at - at % 2, &halves([x, y, 0.0, 0.0]));
        IndirectionMap::from_bytes(&with_texel(&bytes, at, &halves(texel))).unwrap_err().allowed
    };
    for bad in [[1.0, 0.0, -0.1, 0.0], [1.0, 0.0, f32::NAN, 0.0], [1.0, 0.0, 2000.0, 0.0], [1.0, 0.0, 0.1, f32::NAN]] {
        assert_eq!(refusal(3, bad), "a distance of 0 to 1024 and a height of -1024 to 1024");
    }
    for bad in [[0.5, 0.0, 0.1, 0.0], [0.0, 0.0, 0.1, 0.0], [f32::NAN, 1.0, 0.1, 0.0], [1.0, 1.0, 0.0, 0.0]] {
        assert_eq!(refusal(3, bad), "a unit direction, or 0 with a distance of 0");
    }
    for bad in [[1.0, 0.0, 0.1, 0.0], [0.0, 1.0, 0.0, 0.0]] {
        assert_eq!(refusal(0, bad), "at the pole a distance of 0 and the direction of the next sample");
    }
    assert_eq!(refusal(7, [1.0, 0.0, 0.3, 0.5]), "in the last row of a block the same as in its first");
}

#[test]
fn displacements_out_of_range_are_named() {
    let made = flat_btf::displacements(SMALL, 2, 3);
    let texture = texture(&made.to_bytes(false));
    let with = |key: &str, offset: usize, word: u32| {
        let mut texture = texture.clone();
        texture.entries.get_mut(key).unwrap()[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
        DisplacementMap::from_bytes(&texture.to_bytes(true)).unwrap_err()
    };
    for (offset, field, value) in [
        (0, "version", 2),
        (4, "size", 0),
        (8, "zenith samples", 257),
        (12, "azimuth samples", 2),
        (16, "largest angle", f32::NAN.to_bits()),
        (20, "largest tangent", 0),
        (20, "largest tangent", 8.5f32.to_bits()),
        (20, "largest tangent", f32::NAN.to_bits()),
    ] {
        assert_eq!(with("brdfc.displacement", offset, value).field, format!("brdfc.displacement {field}"), "{value}");
    }
    assert_eq!(with("brdfc.displacement", 4, 1).field, "size of the part displacement");
    // A half that is no number, and one that is too large.
    for bits in [0x7e00, 0x6401] {
        assert_eq!(with("brdfc.displacement.ranges", 8, bits).field, "brdfc.displacement.ranges block 1");
    }
    let mut short = texture.clone();
    short.entries.get_mut("brdfc.displacement.ranges").unwrap().pop();
    assert_eq!(DisplacementMap::from_bytes(&short.to_bytes(false)).unwrap_err().field, "brdfc.displacement.ranges");
    let mut unlike = texture.clone();
    *unlike.texels.last_mut().unwrap() ^= 1;
    let error = DisplacementMap::from_bytes(&unlike.to_bytes(false)).unwrap_err();
    assert!(error.to_string().contains("found other texels; allowed those of the first row"), "{error}");
    // Blocks have whole texels of the reference plane each.
    let odd = FlatBtfParts { indirection: flat_btf::displacements(SMALL, 3, 1).into(), ..flat_btf::parts(SMALL, 1) };
    let told = FlatBtfDecoder::new(odd).unwrap_err().to_string();
    assert_eq!(told, "size of the part displacement: found 3; allowed a divisor of 2, the size of the part reference");
}

#[test]
fn fields_of_the_entries_out_of_range_are_named() {
    let indirection = texture(&flat_btf::example_indirection().to_bytes(false));
    let view = texture(&flat_btf::example_view().to_bytes(false));
    let with = |texture: &Texture, key: &str, offset: usize, word: u32| {
        let mut texture = texture.clone();
        texture.entries.get_mut(key).unwrap()[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
        texture.to_bytes(true)
    };
    for (offset, field, values) in [
        (0, "version", vec![0, 2]),
        (4, "size", vec![0, 4097, u32::MAX]),
        (8, "zenith samples", vec![0, 1, 257]),
        (12, "azimuth samples", vec![0, 2, 257, u32::MAX]),
        (16, "largest angle", vec![0, 0x8000_0000, 1.58f32.to_bits(), f32::NAN.to_bits(), (-1.0f32).to_bits()]),
    ] {
        for value in values {
            let error =
                IndirectionMap::from_bytes(&with(&indirection, "brdfc.indirection", offset, value)).unwrap_err();
            assert_eq!(error.field, format!("brdfc.indirection {field}"), "{value}");
        }
    }
    for (offset, value) in [(4, 2), (8, 3), (12, 4), (4, 4096)] {
        let error = IndirectionMap::from_bytes(&with(&indirection, "brdfc.indirection", offset, value)).unwrap_err();
        assert_eq!(error.field, "size of the part indirection", "{offset} {value}");
    }
    for (offset, field, values) in [
        (0, "brdfc.flat-btf version", vec![0, 2]),
        (4, "size of the part flat", vec![0, 2, u32::MAX]),
        (8, "brdfc.flat-btf view", vec![2, u32::MAX]),
        (12, "brdfc.flat-btf views", vec![0, 2049]),
        (16, "brdfc.flat-btf lights", vec![0, 2049, u32::MAX]),
        (12, "brdfc.views", vec![1, 3]),
        (16, "brdfc.lights", vec![1, 3]),
    ] {
        for value in values {
            let error = FlatView::from_bytes(&with(&view, "brdfc.flat-btf", offset, value)).unwrap_err();
            assert_eq!(error.field, field, "{value}");
        }
    }
    for key in ["brdfc.views", "brdfc.lights"] {
        for (offset, value) in [(8, -0.1), (8, 1.6), (12, -1.0), (12, 6.284), (8, f32::NAN), (12, f32::NAN)] {
            let error = FlatView::from_bytes(&with(&view, key, offset, f32::to_bits(value))).unwrap_err();
            assert_eq!(error.field, format!("{key} direction 1"), "{offset} {value}");
        }
    }
    for (texture, read) in [
        (&indirection, (|b| IndirectionMap::from_bytes(b).map(drop)) as fn(&[u8]) -> Result<(), FormatError>),
        (&view, |b| FlatView::from_bytes(b).map(drop)),
    ] {
        for key in texture.entries.keys() {
            let mut changed = texture.clone();
            changed.entries.get_mut(key).unwrap().push(0);
            assert_eq!(&read(&changed.to_bytes(false)).unwrap_err().field, key);
            changed.entries.remove(key);
            assert_eq!(&read(&changed.to_bytes(false)).unwrap_err().field, key);
        }
    }
}

/// Sizes in the file that are beyond the texture, or a texture of another kind.
#[test]
fn other_kinds_of_textures_are_refused() {
    let made = |format, extent: Extent, texels: usize| {
        Texture { format, extent, entries: BTreeMap::new(), levels: 1, texels: vec![0; texels] }.to_bytes(false)
    };
    for extent in [Extent::D2([2, 1]), Extent::D2Array([1, 1, 2]), Extent::D3([1, 1, 2])] {
        let error = DiffuseMap::from_bytes(&made(TexelFormat::Rgb9E5, extent, 8)).unwrap_err();
        assert_eq!(error.field, "size of the part diffuse", "{extent}");
    }
    for extent in [Extent::D2([1, 1]), Extent::D2Array([1, 2, 1])] {
        let error = VisibilityMask::from_bytes(&made(TexelFormat::R8Unorm, extent, extent.texels() as usize));
        assert_eq!(error.unwrap_err().field, "size of the part mask", "{extent}");
    }
    let error = DiffuseMap::from_bytes(&made(TexelFormat::Rgba8Unorm, Extent::D2([1, 1]), 4)).unwrap_err();
    assert_eq!(error.to_string(), "texels of the part diffuse: found Rgba8Unorm; allowed Rgb9E5");
}

#[test]
fn constructors_refuse_what_files_may_not_hold() {
    let error = |result: Result<(), FormatError>| result.unwrap_err().to_string();
    assert_eq!(
        error(DiffuseMap::new(2, vec![0; 3]).map(drop)),
        "texels of the part diffuse: found 3; allowed 4, as its size says"
    );
    assert_eq!(
        error(DiffuseMap::new(0, vec![]).map(drop)),
        "size of the part diffuse: found 0; allowed 1 to 8192 texels"
    );
    assert!(DiffuseMap::new(u32::MAX, vec![]).is_err() && VisibilityMask::new(1, 2049, vec![0; 2049]).is_err());
    let header = FlatHeader { size: 1, view: 0, views: vec![[0.0; 2]], lights: vec![[0.0; 2]] };
    assert!(FlatView::new(header.clone(), vec![1]).is_ok() && FlatView::new(header.clone(), vec![1, 2]).is_err());
    assert!(FlatView::new(FlatHeader { lights: vec![], ..header.clone() }, vec![]).is_err());
    assert!(FlatView::new(FlatHeader { view: 1, ..header }, vec![1]).is_err());
    // 256 texels of 33 rows pass the limit of a texture.
    let large = |size| IndirectionHeader { size, zenith_samples: 8, azimuth_samples: 32, largest_angle: 1.0 };
    assert_eq!(
        error(large(256).check()),
        "size of the part indirection: found 2048 x 8448; allowed at most 8192 on each side"
    );
    assert!(large(248).check().is_ok() && large(u32::MAX).check().is_err());
    for displacement in [[f32::NAN, 0.0], [f32::INFINITY, 0.0], [2000.0, 0.0], [1e30, 1e30], [f32::MAX; 2]] {
        let header = IndirectionHeader { size: 1, zenith_samples: 2, azimuth_samples: 3, largest_angle: 1.0 };
        assert!(IndirectionMap::from_displacements(header, |_, _, _| (displacement, 0.0)).is_err());
        assert!(IndirectionMap::from_displacements(header, |_, _, _| ([0.0; 2], displacement[0])).is_err());
    }
}
