//! What flat BTFs are said to take in graphics memory is what is uploaded.

use brdfc_formats::container::{Extent, Texture};
use brdfc_formats::flat_btf::{Atlas, FlatBtfDecoder, FlatBtfParts, FlatValues, SampledDirections, gpu_bytes};
use brdfc_testing::flat_btf::{SMALL, Sizes, mask, parts, position};

/// As the bindings of a shader take them, part by part.
fn uploaded(parts: FlatBtfParts) -> usize {
    let decoder = FlatBtfDecoder::new(parts).unwrap();
    let (atlas, parts) = (decoder.atlas(), decoder.parts());
    let views: usize = parts.values.views().iter().map(|view| size_of_val(&atlas.layer(view)[..])).sum();
    let maps = parts.normal.texel_bytes().len() + parts.indirection.samples().unwrap().texel_bytes().len();
    let directions = SampledDirections::of(&parts.values).unwrap();
    let directions = directions.map_or(0, |directions| size_of_val(&directions.texels()[..]));
    views + directions + maps + size_of_val(parts.reference.parameters()) + size_of_val(parts.diffuse.texels())
}

#[test]
fn unused_tiles_of_the_atlas_count() {
    for lights in [1, 2, 4, 5, 9, 17, 26, 80, 81] {
        let sizes = Sizes { lights, ..SMALL };
        let parts = parts(sizes, 1);
        assert_eq!(parts.gpu_bytes(), uploaded(parts) as u64, "{lights}");
    }
    // Five columns and four rows.
    assert_eq!(gpu_bytes("flat.003", Extent::D2Array([8, 8, 17]), 1), 4 * 8 * 8 * 20);
    assert_eq!(Atlas::new(8, 17).texels(), 8 * 8 * 20);
    assert_eq!(gpu_bytes("flat.0003", Extent::D2Array([8, 8, 16]), 1), 4 * 8 * 8 * 16);
    let light = FlatBtfParts { values: FlatValues::None, ..parts(SMALL, 1) };
    assert_eq!(light.gpu_bytes(), uploaded(light) as u64);
}

#[test]
fn parts_that_no_shader_reads_take_nothing() {
    for (part, bytes) in [("position", position(4, 1).to_bytes(false)), ("mask", mask(SMALL, 1).to_bytes(false))] {
        let texture = Texture::from_bytes(&bytes).unwrap();
        assert!(texture.texel_bytes() > 0);
        assert_eq!(gpu_bytes(part, texture.extent, texture.levels), 0, "{part}");
    }
}
