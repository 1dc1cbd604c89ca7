//! Encodes committed inputs and compares the bytes, and the decoded values, with the codec's list: see docs/goldens.md.

use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::{brdf_map, environment_map, texture_map};
use brdfc_bandwidth::resolution::Resolution;
use brdfc_bandwidth::texture::Placement;
use brdfc_source::open::open;
use brdfc_source::radiance_image::open_radiance_image;
use brdfc_source::tile_image::open_colours;
use brdfc_testing::golden::encodes::{Packs, check_encodes};
use brdfc_testing::testdata;
use std::path::PathBuf;

#[test]
fn bandwidth_maps() {
    let material = open("synth:ggx?alpha=0.4", None).unwrap_or_else(|error| panic!("{error}")).source;
    let (brdf, _) = brdf_map(material.as_ref(), Resolution::Fixed(32), DEFAULT_EPSILON).expect("an epsilon in range");
    let path = |relative| PathBuf::from(testdata(relative));
    let sky = open_radiance_image(path("demo/sky.hdr")).unwrap_or_else(|error| panic!("{error}"));
    let environment = environment_map(&sky.pixels, sky.width, 0.02).expect("an epsilon in range");
    let cloth = open_colours(path("golden/cloth.png")).unwrap_or_else(|error| panic!("{error}"));
    let texture = |metres, tiles| {
        let map = texture_map(&cloth.pixels, cloth.width, Placement { metres, tiles }, DEFAULT_EPSILON);
        map.expect("a placement in range").to_bytes(true)
    };
    let packs = Packs::from([
        ("brdf.ktx2".to_owned(), brdf.to_bytes(true)),
        ("environment.ktx2".to_owned(), environment.to_bytes(true)),
        ("texture-repeats.ktx2".to_owned(), texture([0.3, 0.25], true)),
        // Dense enough that halves require a scale.
        ("texture-ends.ktx2".to_owned(), texture([1e-5, 2e-5], false)),
    ]);
    check_encodes("bandwidth", &packs, |_| true);
}
