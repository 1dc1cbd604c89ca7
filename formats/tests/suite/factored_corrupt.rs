//! Corrupt and malicious factored flat BTFs: each is rejected with a reason, or decodes to finite numbers.

use brdfc_formats::bindings::{PackFile, Texels};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_formats::flat_btf::factored::{BasisMap, FactoredFlatBtf, WeightMap, WeightRange};
use brdfc_testing::codecs::flat_btf::{
    BASE, Factors, SMALL, base_file, factored, factored_example, factored_file, file, image, layers, refusal, reshape,
    set_texel, set_word,
};

/// The largest numbers that files can hold, all at once.
#[test]
fn the_largest_numbers_decode_to_numbers() {
    let asset = factored_example();
    for (step, scale, low) in [
        (f32::MAX, 1.0, 1.0),
        (1.0, f32::MAX, f32::MAX),
        (f32::MAX, f32::MAX, f32::MIN),
        (f32::MAX, f32::MIN, f32::MIN),
        (f32::MIN_POSITIVE, f32::MAX, 0.0),
    ] {
        let mut header = asset.header().clone();
        header.steps = header.steps.map(|steps| vec![step; steps.len()]);
        let basis =
            BasisMap::new(header, asset.basis().words().to_vec(), asset.basis().table_texels().to_vec()).unwrap();
        let weights = asset.weights();
        let ranges = vec![WeightRange { scale, low }; weights.ranges().len()];
        let weights = WeightMap::new(weights.size(), weights.levels(), ranges, weights.texels().to_vec()).unwrap();
        let both = FactoredFlatBtf::new(basis, weights, asset.residual().cloned());
        let both = both.unwrap();
        for k in 0..144 {
            let value = both.texel([k % 4, k / 4 % 4]).value(k / 48, k / 16 % 3);
            assert!(value.iter().all(|c| (0.0..3e5).contains(c)), "{step} {scale} {low}: {value:?}");
        }
    }
}

#[test]
fn values_of_other_lengths_are_rejected() {
    for (entry, long, short, without) in [
        (
            "brdfc.flat-btf.factored",
            "193 bytes, expected 192 bytes, as groups requires",
            "96 bytes or more",
            "brdfc.flat-btf.factored: not among the keys ",
        ),
        (
            "brdfc.flat-btf.weights",
            "137 bytes, expected 136 bytes",
            "3 bytes, expected 8 bytes or more",
            "brdfc.flat-btf.weights: not among the keys ",
        ),
        (
            "brdfc.flat-btf.residual",
            "5 bytes, expected 4 bytes",
            "3 bytes, expected 4 bytes",
            "brdfc.flat-btf.residual: not among the keys ",
        ),
    ] {
        let resized = |length: Option<usize>| {
            let error = refusal(&factored_file(), |file| {
                let value = file.entries.get_mut(entry).unwrap();
                value.resize(length.unwrap_or(value.len() + 1), 0);
            });
            error.to_string()
        };
        let error = resized(None);
        assert!(error.starts_with(entry) && error.ends_with(long), "{error}");
        let error = resized(Some(3));
        assert!(error.contains(short), "{error}");
        let error = refusal(&factored_file(), |file| drop(file.entries.remove(entry))).to_string();
        assert!(error.starts_with(without), "{error}");
    }
}

/// Images that contradict the headers.
#[test]
fn other_textures_are_rejected() {
    for (part, extent, levels, expected) in [
        (
            "basis",
            Extent::D2([9, 4]),
            1,
            "size of the part basis: found 9 x 4, expected a texture of 9 x 3, as its header",
        ),
        ("basis", Extent::D2([9, 3]), 2, "byte 40, levelCount: found 2, expected 1"),
        (
            "tables",
            Extent::D3([8, 48, 2]),
            1,
            "size of the part tables: found 8 x 48 x 2, expected a texture of 8 x 48 x 1, as its header",
        ),
        (
            "weights",
            Extent::D2([4, 4]),
            3,
            "size of the part weights: found 4 x 4, expected a 2D array of square layers",
        ),
        (
            "weights",
            Extent::D2Array([4, 2, 2]),
            1,
            "size of the part weights: found 2 layers of 4 x 2, expected a 2D array",
        ),
        (
            "weights",
            Extent::D2Array([4, 4, 3]),
            1,
            "size of the part weights: found 3 layers of 4 x 4, expected 4 layers, as",
        ),
        ("residual", Extent::D3([2, 2, 3]), 1, "size of the part residual: found 2 x 2 x 3, expected a 2D array"),
        (
            "residual",
            Extent::D2Array([2, 4, 3]),
            1,
            "size of the part residual: found 3 layers of 2 x 4, expected a 2D array",
        ),
        (
            "residual",
            Extent::D2Array([2, 2, 3]),
            1,
            "levels of the part residual: found 1, expected 2, down to one cell",
        ),
    ] {
        let error = refusal(&factored_file(), |file| {
            let name = format!("factored_{part}");
            let format = image(file, &name).format;
            reshape(file, &name, format, extent, levels);
        });
        assert!(error.to_string().starts_with(expected), "{error}");
    }
    for part in ["basis", "tables", "weights", "residual"] {
        let error = refusal(&factored_file(), |file| {
            let name = format!("factored_{part}");
            let extent = image(file, &name).extent;
            reshape(file, &name, TexelFormat::R16Unorm, extent, 1);
        });
        let expected = format!("texels of the part {part}: found R16Unorm, expected R");
        assert!(error.to_string().starts_with(&expected), "{error}");
    }
}

/// Each header field out of its range.
#[test]
fn wrong_headers_are_rejected() {
    let two = Factors { groups: 2, wide_groups: 1, residual: 2, ..BASE };
    let made = file(layers(SMALL, 3), factored(SMALL, two, 3));
    let with =
        |key: &str, word: usize, value: u32| refusal(&made, |file| set_word(file, key, 4 * word, value)).to_string();
    let [nan, inf] = [f32::NAN, f32::INFINITY].map(f32::to_bits);
    for (word, value, expected) in [
        (0, 2, "brdfc.flat-btf.factored version: found 2, expected 5"),
        (1, 0, "brdfc.flat-btf.factored size: found 0, expected 1 to 8192"),
        (2, 4, "brdfc.flat-btf.factored levels: found 4, expected 1 to 3"),
        (3, 17, "brdfc.flat-btf.factored groups: found 17, expected 0 to 16"),
        (3, 3, "brdfc.flat-btf.factored length: found 192 bytes, expected 240 bytes, as groups requires"),
        (4, 3, "brdfc.flat-btf.factored wide groups: found 3, expected 0 to 2, the number of groups"),
        (5, 5, "brdfc.flat-btf.factored cells of the residual: found 5, expected 0 to 4"),
        (6, 0, "brdfc.views: found 24 bytes, expected 0 bytes"),
        (6, 4, "brdfc.views: found 24 bytes, expected 32 bytes"),
        (7, 4, "brdfc.lights: found 40 bytes, expected 32 bytes"),
        (1, 8193, "brdfc.flat-btf.factored size: found 8193, expected 1 to 8192"),
        (2, 0, "brdfc.flat-btf.factored levels: found 0, expected 1 to 3"),
        (3, 0, "brdfc.flat-btf.factored length: found 192 bytes, expected 96 bytes, as groups requires"),
        (6, 2049, "brdfc.flat-btf.factored views: found 2049, expected 0 to 2048"),
        (7, 0, "brdfc.lights: found 40 bytes, expected 0 bytes"),
        (7, 2049, "brdfc.flat-btf.factored lights: found 2049, expected 0 to 2048"),
        (9, nan, "brdfc.flat-btf.factored error: found NaN, expected a finite non-negative number"),
        (13, (-1.0f32).to_bits(), "brdfc.flat-btf.factored error: found -1, expected a finite non-negative number"),
        (
            14,
            1,
            "brdfc.flat-btf.factored range of colours: found 1 to 0 and 0 to 0, expected two ranges with minimum <= maximum",
        ),
        (15, 3, "brdfc.flat-btf.factored materials: found 3, expected 0 to 2"),
        (15, 1, "brdfc.flat-btf.factored groups: found 2, expected no groups, because there are materials"),
        (16, 2, "brdfc.flat-btf.factored axes: found 2, expected 0 to 1"),
        (17, 2, "brdfc.flat-btf.factored levels of tables: found 2, expected 1 to 1"),
        (
            18,
            1.0f32.to_bits(),
            "brdfc.flat-btf.factored albedo of material 0: found [1.0, 0.0, 0.0], expected numbers of 0 to 0",
        ),
        (24, nan, "brdfc.flat-btf.factored step: found NaN, expected a finite non-negative number"),
        (47, inf, "brdfc.flat-btf.factored step: found inf, expected a finite non-negative number"),
    ] {
        assert_eq!(with("brdfc.flat-btf.factored", word, value), expected);
    }
    assert!(with("brdfc.lights", 0, nan).starts_with("brdfc.lights direction 0: found NaN"));
    let weights = |word: usize, value: u32| with("brdfc.flat-btf.weights", word, value);
    assert_eq!(weights(1, 0), "brdfc.flat-btf.weights numbers: found 0, expected 1 to 72");
    assert_eq!(weights(1, 73), "brdfc.flat-btf.weights numbers: found 73, expected 1 to 72");
    assert_eq!(weights(0, 0), "brdfc.flat-btf.weights version: found 0, expected 1");
    assert_eq!(weights(1, 4), "brdfc.flat-btf.weights: found 136 bytes, expected 40 bytes");
    assert!(weights(5, nan).starts_with("brdfc.flat-btf.weights range 1"));
    // The base has two layers.
    let range = WeightRange { scale: 1.0, low: 0.0 };
    assert!(WeightMap::new(1, 1, vec![range; 8], vec![0; 8]).is_ok());
    for count in [4, 9] {
        let refused = WeightMap::new(1, 1, vec![range; count], vec![0; count]).unwrap_err().to_string();
        let expected = format!("numbers of the part weights: found {count}, expected a multiple of 4, at least 8");
        assert_eq!(refused, expected);
    }
    for (half, label) in [(0x7e00u16, "NaN"), (0x7c00, "inf"), (0xb800, "-0.5")] {
        let green = 4 * (2 * 8 + 5) + 1;
        let error = refusal(&factored_file(), |file| set_texel(file, "factored_tables", green, &half.to_le_bytes()));
        let error = error.to_string();
        assert!(error.starts_with("entry (2, 5) of the base: found [") && error.contains(label), "{error}");
        let alpha = green + 2;
        let error = refusal(&factored_file(), |file| set_texel(file, "factored_tables", alpha, &half.to_le_bytes()));
        assert!(error.to_string().starts_with(&format!("diffuse factors of a material: found {label}")), "{error}");
    }
    assert_eq!(with("brdfc.flat-btf.residual", 0, 2), "brdfc.flat-btf.residual version: found 2, expected 1");
}

/// A base alone has no views, lights, residual and meshes.
#[test]
fn a_base_with_parts_of_components_is_rejected() {
    const KEY: &str = "brdfc.flat-btf.factored";
    let directions = |file: &mut PackFile| {
        for key in ["brdfc.views", "brdfc.lights"] {
            file.entries.insert(key.to_owned(), vec![0; 8]);
        }
        set_word(file, KEY, 24, 1);
        set_word(file, KEY, 28, 1);
    };
    assert_eq!(
        refusal(&base_file(), directions).to_string(),
        "brdfc.flat-btf.factored directions: found 1 views and 1 lights, expected no views and lights, because there are no groups"
    );
    let residual = refusal(&base_file(), |file| set_word(file, KEY, 20, 1)).to_string();
    assert_eq!(residual, "brdfc.flat-btf.factored cells of the residual: found 1, expected 0 to 0");
    // Of a file with components, whose basis has no groups any more.
    let without = refusal(&factored_file(), |file| {
        let entry = file.entries.get_mut(KEY).unwrap();
        entry.truncate(96);
        entry[12..20].fill(0);
    });
    assert!(
        without.to_string().starts_with("brdfc.flat-btf.factored directions: found 3 views and 3 lights"),
        "{without}"
    );
    for (name, expected) in [
        ("factored_residual", "brdfc.flat-btf.residual: not among the keys "),
        ("direction_mesh_words", "direction_mesh_words: found meshes of 3 views and 3 lights, expected no meshes"),
    ] {
        let other = PackFile::from_bytes(&factored_file().to_bytes(false)).unwrap();
        let error = refusal(&base_file(), |file| {
            let taken = other.bindings.textures().find(|(of, _)| *of == name).unwrap().1.clone();
            *image(file, name) = taken;
        });
        assert!(error.to_string().starts_with(expected), "{error}");
    }
    // A file with components has the meshes of its directions.
    let error = refusal(&factored_file(), |file| {
        let texels = image(file, "direction_mesh_words");
        *texels = Texels::empty(texels.format, Extent::D2([1; 2]));
    });
    assert_eq!(error.to_string(), "direction_mesh_words: found no meshes, expected meshes of 3 views and 3 lights");
}
