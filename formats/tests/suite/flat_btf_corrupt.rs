//! Corrupt and malicious flat BTFs: each is rejected with a reason, or decodes to finite numbers.

use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat, half};
use brdfc_formats::flat_btf::{
    FlatHeader, FlatView, LayerHeader, LayerMap, MAX_DISPLACEMENT, MAX_HEIGHT, VisibilityMask,
};
use brdfc_testing::codecs::flat_btf::{
    base_file, factored_file, image, materials_file, refusal, reshape, set_texel, set_word, survives,
};

const LAYERS: &str = "brdfc.flat-btf.layers";
const HEIGHTS: &str = "flat_btf_heights";
const DISPLACEMENTS: &str = "flat_btf_displacements";

/// With a valid checksum, which other tests cover.
#[test]
fn no_single_changed_byte_is_harmful() {
    for (file, supercompress, patterns) in [
        (factored_file(), false, &[1, 128, 0xff][..]),
        (factored_file(), true, &[0xff]),
        (base_file(), false, &[0xff]),
        (materials_file(), false, &[0xff]),
    ] {
        let bytes = file.to_bytes(supercompress);
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

#[test]
fn displacements_out_of_range_are_named() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1025.0] {
        let texel = [0.0, bad].map(half::encode).map(u16::to_le_bytes).concat();
        let error = refusal(&factored_file(), |file| set_texel(file, DISPLACEMENTS, 9, &texel)).to_string();
        let expected = format!("displacement 9 of layers: found [0.0, {bad:?}], expected two numbers of -1024 to 1024");
        assert_eq!(error, expected);
    }
    // Any bytes are heights.
    let mut file = factored_file().to_bytes(false);
    assert!(survives(&file));
    let length = file.len();
    file.truncate(length - 1);
    assert!(!survives(&file));
}

#[test]
fn header_fields_out_of_range_are_named() {
    let (base, factored) = (base_file(), factored_file());
    let with = |offset: usize, word: u32| refusal(&factored, |file| set_word(file, LAYERS, offset, word)).to_string();
    let heights = "two ascending heights of -64 to 64 tiles";
    for (offset, value, expected) in [
        (0, 0, "version: found 0, expected 2".to_owned()),
        (0, 3, "version: found 3, expected 2".to_owned()),
        (4, 0, "size: found 0, expected 1 to 8192".to_owned()),
        (4, 8193, "size: found 8193, expected 1 to 8192".to_owned()),
        (8, 0, "sheets: found 0, expected 1 or 3".to_owned()),
        (8, 2, "sheets: found 2, expected 1 or 3".to_owned()),
        (8, 4, "sheets: found 4, expected 1 or 3".to_owned()),
        (12, 0, "levels: found 0, expected 1 to 4".to_owned()),
        (12, 5, "levels: found 5, expected 1 to 4".to_owned()),
        (16, 0.25f32.to_bits(), format!("heights: found 0.25 and 0.25, expected {heights}")),
        (16, 0.5f32.to_bits(), format!("heights: found 0.5 and 0.25, expected {heights}")),
        (16, f32::NAN.to_bits(), format!("heights: found NaN and 0.25, expected {heights}")),
        (16, (-64.5f32).to_bits(), format!("heights: found -64.5 and 0.25, expected {heights}")),
        (20, f32::NAN.to_bits(), format!("heights: found -0.25 and NaN, expected {heights}")),
        (20, f32::INFINITY.to_bits(), format!("heights: found -0.25 and inf, expected {heights}")),
        (20, 64.5f32.to_bits(), format!("heights: found -0.25 and 64.5, expected {heights}")),
    ] {
        assert_eq!(with(offset, value), format!("{LAYERS} {expected}"));
    }
    // Sizes of another asset.
    for (offset, value, found, expected) in [
        (4, 16, "4 levels of 8 x 8, Rgba8Unorm", "4 levels of 16 x 16, Rgba8Unorm"),
        (8, 1, "4 levels of 8 x 8, Rgba8Unorm", "4 levels of 8 x 8, R8Unorm"),
        (12, 3, "4 levels of 8 x 8, Rgba8Unorm", "3 levels of 8 x 8, Rgba8Unorm"),
    ] {
        assert_eq!(with(offset, value), format!("part heights: found {found}, expected {expected}, as {LAYERS} says"));
    }
    // The shader's block has the number of the header.
    assert!(with(20, 0.5f32.to_bits()).contains("parameters"));
    for key in ["brdfc.views", "brdfc.lights"] {
        for (offset, value) in [(8, -0.1), (8, 1.6), (12, -1.0), (12, 6.284), (8, f32::NAN), (12, f32::NAN)] {
            let error = refusal(&factored, |file| set_word(file, key, offset, f32::to_bits(value)));
            assert_eq!(error.field, format!("{key} direction 1"), "{offset} {value}");
        }
    }
    for (file, key) in [(&base, LAYERS), (&factored, LAYERS), (&factored, "brdfc.views"), (&factored, "brdfc.lights")] {
        let error = refusal(file, |file| file.entries.get_mut(key).unwrap().push(0));
        assert_eq!(error.field, key);
        let error = refusal(file, |file| drop(file.entries.remove(key)));
        assert_eq!(error.field, key);
    }
}

/// Images with shapes that a flat BTF cannot have.
#[test]
fn other_kinds_of_textures_are_rejected() {
    let shaped = |name: &str, format, extent, levels| {
        refusal(&factored_file(), |file| reshape(file, name, format, extent, levels)).to_string()
    };
    let (rgba, halves) = (TexelFormat::Rgba8Unorm, TexelFormat::Rg16Float);
    let flat = Extent::D2([8; 2]);
    for (format, extent, levels, found) in [
        (TexelFormat::R8Unorm, flat, 4, "4 levels of 8 x 8, R8Unorm"),
        (TexelFormat::Rgba16Unorm, flat, 4, "4 levels of 8 x 8, Rgba16Unorm"),
        (rgba, Extent::D2([4; 2]), 3, "3 levels of 4 x 4, Rgba8Unorm"),
        (rgba, Extent::D2([8, 4]), 4, "4 levels of 8 x 4, Rgba8Unorm"),
        (rgba, Extent::D2Array([8, 8, 1]), 4, "4 levels of 1 layers of 8 x 8, Rgba8Unorm"),
        (rgba, flat, 1, "1 levels of 8 x 8, Rgba8Unorm"),
    ] {
        let expected = format!("part heights: found {found}, expected 4 levels of 8 x 8, Rgba8Unorm, as {LAYERS} says");
        assert_eq!(shaped(HEIGHTS, format, extent, levels), expected);
    }
    let layers = |count| Extent::D2Array([4, 4, count]);
    for (format, extent, levels, found) in [
        (TexelFormat::Rg8Unorm, layers(3), 3, "3 levels of 3 layers of 4 x 4, Rg8Unorm"),
        (TexelFormat::Rgba16Float, layers(3), 3, "3 levels of 3 layers of 4 x 4, Rgba16Float"),
        (halves, layers(1), 3, "3 levels of 1 layers of 4 x 4, Rg16Float"),
        (halves, Extent::D2Array([8, 8, 3]), 3, "3 levels of 3 layers of 8 x 8, Rg16Float"),
        (halves, Extent::D2([4; 2]), 3, "3 levels of 4 x 4, Rg16Float"),
        (halves, layers(3), 2, "2 levels of 3 layers of 4 x 4, Rg16Float"),
    ] {
        let allowed = "3 levels of 3 layers of 4 x 4, Rg16Float";
        let expected = format!("part displacements: found {found}, expected {allowed}, as {LAYERS} says");
        assert_eq!(shaped(DISPLACEMENTS, format, extent, levels), expected);
    }
    for name in [HEIGHTS, DISPLACEMENTS, "factored_tables"] {
        let error = refusal(&factored_file(), |file| {
            let texels = image(file, name);
            *texels = brdfc_formats::bindings::Texels::empty(texels.format, texels.extent);
        });
        assert_eq!(error.to_string(), format!("{name}: no texels; expected texels of a flat BTF"));
    }
}

#[test]
fn constructors_reject_invalid_parts() {
    let error = |result: Result<(), FormatError>| result.unwrap_err().to_string();
    let header = LayerHeader { size: 2, sheets: 3, levels: 2, heights: [-0.5, 0.5] };
    let made = |header, heights, displacements| LayerMap::new(header, vec![0; heights], vec![[0.0; 2]; displacements]);
    assert!(made(header, 20, 3).is_ok());
    assert_eq!(error(made(header, 19, 3).map(drop)), "bytes of heights: found 19, expected 20, as the header says");
    assert_eq!(
        error(made(header, 20, 4).map(drop)),
        "displacements of layers: found 4, expected 3, as the header says"
    );
    let one = LayerHeader { sheets: 1, ..header };
    assert!(made(one, 5, 1).is_ok() && made(one, 20, 3).is_err());
    for (header, expected) in [
        (LayerHeader { sheets: 2, ..header }, "sheets: found 2, expected 1 or 3"),
        (LayerHeader { size: 0, ..header }, "size: found 0, expected 1 to 8192"),
        (LayerHeader { levels: 3, ..header }, "levels: found 3, expected 1 to 2"),
        (
            LayerHeader { heights: [0.5, -0.5], ..header },
            "heights: found 0.5 and -0.5, expected two ascending heights of -64 to 64 tiles",
        ),
    ] {
        assert_eq!(error(header.check()), format!("{LAYERS} {expected}"));
        assert!(made(header, 20, 3).is_err());
    }
    assert!(LayerHeader { heights: [-MAX_HEIGHT, MAX_HEIGHT], ..header }.check().is_ok());
    for heights in [[f32::NAN, 0.5], [0.0, f32::NAN], [f32::NEG_INFINITY, 0.0], [0.0, f32::INFINITY], [0.0; 2]] {
        assert!(LayerHeader { heights, ..header }.check().is_err(), "{heights:?}");
    }
    let moved = |displacement: [f32; 2]| {
        let mut displacements = vec![[0.0; 2]; 3];
        displacements[2] = displacement;
        LayerMap::new(header, vec![0; 20], displacements)
    };
    assert!(moved([MAX_DISPLACEMENT, -MAX_DISPLACEMENT]).is_ok());
    for bad in [[f32::NAN, 0.0], [0.0, f32::INFINITY], [-1024.5, 0.0], [f32::MAX; 2]] {
        let error = error(moved(bad).map(drop));
        assert!(error.starts_with("displacement 2 of layers: found ["), "{error}");
        assert!(error.ends_with(", expected two numbers of -1024 to 1024"), "{error}");
    }
    // Displacements are rounded to halves.
    let rounded = moved([0.1, 1.0 / 3.0]).unwrap().displacement_bytes();
    assert_eq!(rounded[4 * 2..][..4], [0.1, 1.0 / 3.0].map(half::encode).map(u16::to_le_bytes).concat());
    assert!(VisibilityMask::new(1, 2049, vec![0; 2049]).is_err() && VisibilityMask::new(1, 1, vec![128]).is_err());
    let header = FlatHeader { size: 1, view: 0, views: vec![[0.0; 2]], lights: vec![[0.0; 2]] };
    assert!(FlatView::new(header.clone(), vec![1]).is_ok() && FlatView::new(header.clone(), vec![1, 2]).is_err());
    assert!(FlatView::new(FlatHeader { lights: vec![], ..header.clone() }, vec![]).is_err());
    assert!(FlatView::new(FlatHeader { view: 1, ..header }, vec![1]).is_err());
}
