//! The reported GPU memory of flat BTFs equals the uploaded bytes.

use brdfc_formats::flat_btf::{
    Atlas, FlatBtfDecoder, FlatBtfFile, FlatBtfParts, FlatValues, SampledDirections, VisibilityMask,
};
use brdfc_testing::codecs::flat_btf::{SMALL, Sizes, parts};

/// Size of the bindings of a shader, part by part.
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
    assert_eq!(Atlas::new(8, 17).texels(), 8 * 8 * 20);
    let light = FlatBtfParts { values: FlatValues::None, ..parts(SMALL, 1) };
    assert_eq!(light.gpu_bytes(), uploaded(light) as u64);
}

#[test]
fn images_that_no_shader_reads_take_no_memory() {
    let light = FlatBtfParts { values: FlatValues::None, ..parts(SMALL, 1) };
    let [size, views] = [light.diffuse.size(), 2];
    let decoder = FlatBtfDecoder::new(light).unwrap();
    let mask = VisibilityMask::new(size, views, vec![255; (size * size * views) as usize]).unwrap();
    let [without, with] = [None, Some(mask)].map(|mask| FlatBtfFile::new(decoder.clone(), mask).unwrap());
    assert!(with.to_bytes(false).len() > without.to_bytes(false).len());
    assert_eq!(with.gpu_bytes(), without.gpu_bytes());
}
