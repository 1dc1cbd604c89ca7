//! Corrupt and malicious flat BTFs: each is rejected with a reason, or decodes to finite numbers.

use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat, Texture, half};
use brdfc_formats::flat_btf::{
    DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatHeader, FlatView, IndirectionHeader, IndirectionMap, VisibilityMask,
};
use brdfc_testing::codecs::flat_btf::{
    self, SMALL, factored_file, image, light_file, refusal, reshape, set_texel, set_word, survives,
};
use std::collections::BTreeMap;

/// With a valid checksum, which other tests cover.
#[test]
fn no_single_changed_byte_is_harmful() {
    for (supercompress, patterns) in [(false, &[1, 128, 0xff][..]), (true, &[0xff])] {
        let bytes = factored_file().to_bytes(supercompress);
        let mut broken = bytes.clone();
        let (mut valid, mut refused) = (0, 0);
        for offset in 0..bytes.len() {
            for pattern in patterns {
                broken[offset] = bytes[offset] ^ pattern;
                *if survives(&broken) { &mut valid } else { &mut refused } += 1;
            }
            broken[offset] = bytes[offset];
        }
        println!("{} bytes, Zstandard {supercompress}: {valid} read, {refused} refused", bytes.len());
        assert!(valid > 0 && refused > 0, "texels may change, lengths may not");
    }
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
    let field = |name: &str, at: usize, texel: &[u8]| {
        refusal(&light_file(), |file| set_texel(file, name, at, texel)).field.into_owned()
    };
    for bad in [[0.0; 4], [0.7, 0.7, 0.7, 0.0], [nan, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0], [f32::INFINITY; 4]] {
        assert_eq!(field("flat_btf_normal", 15, &halves(bad)), "normal texel (3, 3)", "{bad:?}");
    }
    for bad in [[nan, 0.0], [0.0, f32::NEG_INFINITY], [1024.5, 0.0]] {
        assert_eq!(field("flat_btf_reference", 2, &floats(bad)), "reference texel (0, 1)", "{bad:?}");
    }
    assert_eq!(field("flat_btf_packed_indirection", 8, &halves([nan; 4])), "indirection texel (2, 1)");
}

/// One block of 2 columns and 4 rows.
#[test]
fn the_rules_of_a_block() {
    let map = flat_btf::example_indirection();
    let refusal = |at: usize, texel: [f32; 4]| {
        let mut texels = map.texels().to_vec();
        // The row of the pole has its own rule.
        let [x, y, ..] = texel;
        texels[at - at % 2] = [x, y, 0.0, 0.0].map(half::encode);
        texels[at] = texel.map(half::encode);
        IndirectionMap::new(*map.header(), texels).unwrap_err().allowed.into_string()
    };
    for bad in [[1.0, 0.0, -0.1, 0.0], [1.0, 0.0, f32::NAN, 0.0], [1.0, 0.0, 2000.0, 0.0], [1.0, 0.0, 0.1, f32::NAN]] {
        assert_eq!(refusal(3, bad), "a distance of 0 to 1024 and a height of -1024 to 1024");
    }
    for bad in [[0.5, 0.0, 0.1, 0.0], [0.0, 0.0, 0.1, 0.0], [f32::NAN, 1.0, 0.1, 0.0], [1.0, 1.0, 0.0, 0.0]] {
        assert_eq!(refusal(3, bad), "a unit direction, or 0 with a distance of 0");
    }
    for bad in [[1.0, 0.0, 0.1, 0.0], [0.0, 1.0, 0.0, 0.0]] {
        assert_eq!(refusal(0, bad), "a distance of 0 and the direction of the next sample, at the pole");
    }
    assert_eq!(refusal(7, [1.0, 0.0, 0.3, 0.5]), "in the last row of a block, the value of its first row");
}

#[test]
fn displacements_out_of_range_are_named() {
    let (packed, ranges) = ("flat_btf_packed_indirection", "flat_btf_ranges");
    let made = factored_file();
    let with =
        |offset: usize, word: u32| refusal(&made, |file| set_word(file, "brdfc.displacement", offset, word)).field;
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
        assert_eq!(with(offset, value), format!("brdfc.displacement {field}"), "{value}");
    }
    assert_eq!(with(4, 1), "size of the part displacement");
    // A NaN half, and one that is too large.
    for bits in [0x7e00u32, 0x6401] {
        let error = refusal(&made, |file| set_texel(file, ranges, 2, &bits.to_le_bytes()));
        assert_eq!(error.field, "range 1 of the part displacement");
    }
    for (format, extent, levels, field) in [
        (TexelFormat::Rgba16Float, Extent::D2([2, 1]), 1, "ranges of the part displacement"),
        (TexelFormat::Rgba16Float, Extent::D2([2, 2]), 2, "levelCount"),
        (TexelFormat::Rgba8Unorm, Extent::D2([2, 2]), 1, "texels of the part ranges"),
    ] {
        assert_eq!(refusal(&made, |file| reshape(file, ranges, format, extent, levels)).field, field);
    }
    let error = refusal(&made, |file| *image(file, packed).bytes.to_mut().last_mut().unwrap() ^= 1);
    assert!(error.to_string().contains("differs from the first row of the blocks; expected equal rows"), "{error}");
    // Blocks consist of whole texels of the reference plane.
    let odd = FlatBtfParts { indirection: flat_btf::displacements(SMALL, 3, 1).into(), ..flat_btf::parts(SMALL, 1) };
    let text = FlatBtfDecoder::new(odd).unwrap_err().to_string();
    assert_eq!(text, "size of the part displacement: found 3, expected a divisor of 2, the size of the part reference");
}

#[test]
fn header_fields_out_of_range_are_named() {
    let (light, factored) = (light_file(), factored_file());
    let with =
        |offset: usize, word: u32| refusal(&light, |file| set_word(file, "brdfc.indirection", offset, word)).field;
    for (offset, field, values) in [
        (0, "version", vec![0, 2]),
        (4, "size", vec![0, 4097, u32::MAX]),
        (8, "zenith samples", vec![0, 1, 257]),
        (12, "azimuth samples", vec![0, 2, 257, u32::MAX]),
        (16, "largest angle", vec![0, 0x8000_0000, 1.58f32.to_bits(), f32::NAN.to_bits(), (-1.0f32).to_bits()]),
    ] {
        for value in values {
            assert_eq!(with(offset, value), format!("brdfc.indirection {field}"), "{value}");
        }
    }
    for (offset, value) in [(4, 1), (8, 4), (12, 5), (4, 4096)] {
        assert_eq!(with(offset, value), "size of the part indirection", "{offset} {value}");
    }
    for key in ["brdfc.views", "brdfc.lights"] {
        for (offset, value) in [(8, -0.1), (8, 1.6), (12, -1.0), (12, 6.284), (8, f32::NAN), (12, f32::NAN)] {
            let error = refusal(&factored, |file| set_word(file, key, offset, f32::to_bits(value)));
            assert_eq!(error.field, format!("{key} direction 1"), "{offset} {value}");
        }
    }
    for (file, key) in [
        (&light, "brdfc.indirection"),
        (&factored, "brdfc.displacement"),
        (&factored, "brdfc.views"),
        (&factored, "brdfc.lights"),
    ] {
        let error = refusal(file, |file| file.entries.get_mut(key).unwrap().push(0));
        assert_eq!(error.field, key);
        let error = refusal(file, |file| drop(file.entries.remove(key)));
        assert_eq!(error.field, key.replace("displacement", "indirection"));
    }
}

/// Images and masks with shapes or texels that a flat BTF cannot have.
#[test]
fn other_kinds_of_textures_are_rejected() {
    let shaped = |format, extent| refusal(&light_file(), |file| reshape(file, "flat_btf_diffuse", format, extent, 1));
    for extent in [Extent::D2([2, 1]), Extent::D2Array([1, 1, 2]), Extent::D3([1, 1, 2])] {
        assert_eq!(shaped(TexelFormat::Rgb9E5, extent).field, "size of the part diffuse", "{extent}");
    }
    let error = shaped(TexelFormat::Rgba8Unorm, Extent::D2([4, 4]));
    assert_eq!(error.to_string(), "texels of the part diffuse: found Rgba8Unorm, expected Rgb9E5");
    let masked = |extent: Extent, texel| {
        let (texels, format) = (vec![texel; extent.texels() as usize], TexelFormat::R8Unorm);
        let mask = Texture { format, extent, entries: BTreeMap::new(), levels: 1, texels }.to_bytes(false);
        refusal(&light_file(), |file| drop(file.entries.insert("brdfc.flat-btf.mask".to_owned(), mask))).to_string()
    };
    for (extent, texel, expected) in [
        (Extent::D2([4, 4]), 0, ", size of the part mask: found 4 x 4, expected a 2D array of square layers"),
        (Extent::D2Array([4, 2, 3]), 0, ", size of the part mask: found 3 layers of 4 x 2, expected a 2D array of"),
        (Extent::D2Array([4, 4, 3]), 128, ", mask texel 0: found 128, expected 0 (filled in) or 255 (seen)"),
        (Extent::D2Array([2, 2, 3]), 0, ": found 2 x 2 texels of 3 views, expected 4 x 4 texels of each view"),
    ] {
        let (error, expected) = (masked(extent, texel), format!("brdfc.flat-btf.mask{expected}"));
        assert!(error.starts_with(&expected), "{error}");
    }
}

#[test]
fn constructors_reject_invalid_parts() {
    let error = |result: Result<(), FormatError>| result.unwrap_err().to_string();
    assert_eq!(
        error(DiffuseMap::new(2, vec![0; 3]).map(drop)),
        "texels of the part diffuse: found 3, expected 4, as its size says"
    );
    assert_eq!(
        error(DiffuseMap::new(0, vec![]).map(drop)),
        "size of the part diffuse: found 0, expected 1 to 8192 texels"
    );
    assert!(DiffuseMap::new(u32::MAX, vec![]).is_err() && VisibilityMask::new(1, 2049, vec![0; 2049]).is_err());
    let header = FlatHeader { size: 1, view: 0, views: vec![[0.0; 2]], lights: vec![[0.0; 2]] };
    assert!(FlatView::new(header.clone(), vec![1]).is_ok() && FlatView::new(header.clone(), vec![1, 2]).is_err());
    assert!(FlatView::new(FlatHeader { lights: vec![], ..header.clone() }, vec![]).is_err());
    assert!(FlatView::new(FlatHeader { view: 1, ..header }, vec![1]).is_err());
    // 256 texels of 33 rows exceed the limit of a texture.
    let large = |size| IndirectionHeader { size, zenith_samples: 8, azimuth_samples: 32, largest_angle: 1.0 };
    assert_eq!(
        error(large(256).check()),
        "size of the part indirection: found 2048 x 8448, expected at most 8192 on each side"
    );
    assert!(large(248).check().is_ok() && large(u32::MAX).check().is_err());
    for displacement in [[f32::NAN, 0.0], [f32::INFINITY, 0.0], [2000.0, 0.0], [1e30, 1e30], [f32::MAX; 2]] {
        let header = IndirectionHeader { size: 1, zenith_samples: 2, azimuth_samples: 3, largest_angle: 1.0 };
        assert!(IndirectionMap::from_displacements(header, |_, _, _| (displacement, 0.0)).is_err());
        assert!(IndirectionMap::from_displacements(header, |_, _, _| ([0.0; 2], displacement[0])).is_err());
    }
}
