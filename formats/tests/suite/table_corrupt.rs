//! Corrupt and malicious table packs: each is rejected, or decodes to finite numbers.

use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::table::{Curve, TableDecoder, TablePack};
use brdfc_testing::codecs::table::tables;
use brdfc_testing::packs::{change_image, pairs, rebind, sealed};

/// The smallest packs: both texel formats, with one layer and more, plain and factored.
fn small_packs() -> Vec<TablePack> {
    let names =
        ["symmetry 2, layers 1", "symmetry 1, layers 3", "symmetry 3, layers 1, curve", "symmetry 0, layers 1, curve"];
    tables().into_iter().filter(|(name, _)| names.contains(&name.as_str())).map(|(_, pack)| pack).collect()
}

/// Returns true if bytes are a pack after their checksum is updated; `f_r` is then finite everywhere.
fn survives(bytes: &[u8]) -> bool {
    let Ok(pack) = TablePack::from_bytes(&sealed(bytes.to_vec())) else { return false };
    let decoder = TableDecoder::new(&pack);
    for pair in pairs(4, 5) {
        let value = decoder.eval_at(pair, 1.3);
        assert!(value.iter().all(|v| v.is_finite() && *v >= 0.0), "{value:?}");
    }
    true
}

#[test]
fn every_truncation_is_an_error() {
    let packs = small_packs();
    assert_eq!(packs.len(), 4);
    for bytes in packs.iter().flat_map(|pack| [pack.to_bytes(false), pack.to_bytes(true)]) {
        assert!((0..bytes.len()).all(|length| !survives(&bytes[..length])));
        assert!(survives(&bytes));
    }
}

#[test]
fn no_single_corrupt_byte_panics() {
    for pack in small_packs() {
        let bytes = pack.to_bytes(false);
        let mut broken = bytes.clone();
        let mut valid = 0;
        for offset in 0..bytes.len() {
            for pattern in [1, 4, 16, 64, 128, 0xff, 0x7f] {
                broken[offset] = bytes[offset] ^ pattern;
                valid += usize::from(survives(&broken));
            }
            broken[offset] = bytes[offset];
        }
        assert!(valid > 0, "the numbers of an error summary may change");
    }
}

/// Error of a factored pack with another curve that its bindings declare.
fn with_curve(format: TexelFormat, extent: Extent, texel: u8) -> FormatError {
    let pack = small_packs().into_iter().find(|pack| pack.curve().is_some() && pack.header().channels == 3).unwrap();
    let curve = pack.curve().unwrap();
    let mut texture = Texture::from_bytes(&pack.to_bytes(false)).unwrap();
    let line = |dimension: &str, format: &str, [width, height, depth]: [u32; 3]| {
        format!("table_brdf_curve texture entry {dimension} {format} {width} {height} {depth} 1 ")
    };
    let old = line("2d", "rgba16float", [curve.nodes() as u32, curve.levels() + 1, 1]);
    rebind(&mut texture, &old, &line(extent.dimension(), format.name(), extent.size()));
    change_image(&mut texture, "table_brdf_curve", |image| {
        (image.format, image.extent) = (format, extent);
        image.texels = vec![texel; extent.texels() as usize * format.texel_bytes()];
    });
    TablePack::from_bytes(&sealed(texture.to_bytes(false))).unwrap_err()
}

#[test]
fn curves_out_of_range_are_named() {
    const FORMAT: TexelFormat = TexelFormat::Rgba16Float;
    for (nodes, found) in [(1, "1"), (257, "257"), (8192, "8192")] {
        let error = with_curve(FORMAT, Extent::D2([nodes, 2]), 0);
        assert_eq!((&*error.field, &*error.found), ("table_brdf_curve nodes", found));
    }
    let error = with_curve(FORMAT, Extent::D2([9, 17]), 0);
    assert_eq!((&*error.field, &*error.found), ("table_brdf_curve levels", "16"));
    // NaN halves.
    assert_eq!(with_curve(FORMAT, Extent::D2([9, 4]), 0xff).field, "table_brdf_curve texel");
    assert_eq!(with_curve(FORMAT, Extent::D2Array([9, 4, 1]), 0).field, "table_brdf_curve");
    assert_eq!(with_curve(TexelFormat::R16Float, Extent::D2([9, 4]), 0).field, "table_brdf_curve");
    // A size that differs from the uniform block.
    let error = with_curve(FORMAT, Extent::D2([8, 4]), 0);
    assert_eq!(error.field, "brdfc.uniform.table_brdf_parameters byte 20", "{error}");
    // A curve with fewer channels than the table.
    let plain = small_packs().into_iter().find(|pack| pack.curve().is_none() && pack.header().channels == 3).unwrap();
    let grey = Curve::new(1, 0, &[[0.0; 3], [1.0; 3]]).unwrap();
    assert_eq!(plain.with_curve(grey).unwrap_err().field, "table_brdf_curve");
}
