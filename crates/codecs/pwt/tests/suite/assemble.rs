//! Tests the arrangement of terms at their levels, and the resulting textures.

use brdfc_formats::pwt::{LightBasis, LightCoordinates, PwtHeader, PwtPack};
use brdfc_pwt::assemble::{Limits, arrangements};
use brdfc_pwt::image::Plane;
use brdfc_pwt::levels::{Borders, TermImages, magnified, range, term_images};
use brdfc_pwt::tree::{PacketTree, Transform};
use brdfc_pwt::{Border, Wavelet};
use brdfc_testing::codecs::pwt::plain;
use brdfc_testing::packs::Numbers;

#[test]
fn magnified_by_hand() {
    let plane = Plane { size: [2, 1], values: vec![0.0, 1.0] };
    assert_eq!(magnified(&plane, 0, Borders::of_one(false)), plane);
    let twice = magnified(&plane, 1, Borders::of_one(false));
    assert_eq!((twice.size, &twice.values[..4]), ([4, 2], &[0.0, 0.25, 0.75, 1.0][..]));
    assert_eq!(magnified(&plane, 1, Borders::of_one(true)).values[..4], [0.25, 0.25, 0.75, 0.75]);
    assert_eq!(range(&[plane, Plane { size: [1, 1], values: vec![-3.0] }]), (-3.0, 1.0));
}

/// A term with these errors; its image needs no levels.
fn term(term: usize, errors: &[f64]) -> TermImages {
    TermImages { channel: 0, term, levels: Vec::new(), errors: errors.to_vec() }
}

fn limits(layers: usize, bytes: u64) -> Limits {
    Limits { extent: [2, 2], depth: 1, views: 1, layers, bytes }
}

#[test]
fn changes_gain_most_per_byte_first() {
    // A channel takes 1 byte at level 1, and 4 more at level 0. Eight terms gain 8 together at level 1, four of them
    // another 12 at level 0; the ninth gains nothing.
    let strong = (0..4).map(|k| term(k, &[1.0, 4.0, 5.0]));
    let weak = (4..8).map(|k| term(k, &[1.0, 1.0, 2.0]));
    let images: Vec<TermImages> = strong.chain(weak).chain([term(8, &[2.0, 2.0, 2.0])]).collect();
    let found = |limits: &Limits| -> Vec<(u64, f64)> {
        let path = arrangements(&images, limits);
        path.iter().map(|arrangement| (arrangement.bytes(limits), arrangement.error)).collect()
    };
    assert_eq!(found(&limits(9, 1000)), [(0, 30.0), (1, 29.0), (2, 28.0), (4, 26.0), (8, 22.0), (24, 10.0)]);
    // Limits of layers and of bytes.
    assert_eq!(found(&limits(1, 1000)), [(0, 30.0), (1, 29.0), (2, 28.0), (4, 26.0), (20, 14.0)]);
    assert_eq!(
        found(&limits(9, 19)),
        [(0, 30.0), (1, 29.0), (2, 28.0), (4, 26.0), (8, 22.0), (13, 19.0), (14, 18.0), (18, 16.0)]
    );
    assert_eq!(found(&limits(9, 3)), [(0, 30.0), (1, 29.0), (2, 28.0)]);
}

/// One sharp term among smooth ones begins at level 0 alone, where a whole layer does not fit.
#[test]
fn a_sharp_term_has_a_layer_of_its_own() {
    let images: Vec<TermImages> = (0..9).map(|k| term(k, &[0.0, if k == 3 { 5.0 } else { 0.25 }, 9.0])).collect();
    let path = arrangements(&images, &limits(3, 14));
    let last = &path[path.len() - 1];
    // 5 bytes for the sharp one and 8 for a layer of the others.
    assert_eq!((last.bytes(&limits(3, 14)), last.error), (13, 8.0 * 0.25));
}

fn random(size: [usize; 2], scale: f64, numbers: &mut Numbers) -> Plane {
    Plane { size, values: (0..size[0] * size[1]).map(|_| numbers.between(-scale, scale) as f32).collect() }
}

/// Coefficients of three terms in three channels, of decreasing strength.
fn terms(transform: Transform) -> (PacketTree, [Vec<Plane>; 3], Vec<TermImages>) {
    let size = [16, 32];
    let mut numbers = Numbers::new(3);
    let mut plane = |k: usize| random(size, 0.3f64.powi(k as i32), &mut numbers);
    let renderings: [Vec<Plane>; 3] = [0, 1, 2].map(|channel| (0..3).map(|term| plane(channel + term)).collect());
    let tree = PacketTree::best(transform, &renderings[0][..1], 0.1, 1);
    let coefficients = renderings.map(|terms| {
        let analysed = terms.into_iter().map(|mut plane| {
            tree.analyse(&mut plane);
            plane
        });
        analysed.collect::<Vec<_>>()
    });
    let weights = Plane { size, values: vec![1.0; size[0] * size[1]] };
    let images = term_images(&tree, &coefficients, &weights, Borders::of_one(transform.border == Border::Periodic));
    (tree, coefficients, images)
}

fn header(depth: u32, repeats: bool) -> PwtHeader {
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 1 };
    PwtHeader { repeats, ..plain([16, 32], [16, 32], depth, basis) }
}

/// Level `l` of the mipmap chain is the tree truncated at `l`, rounded to 8 bits of the component's range.
#[test]
fn mipmaps_are_the_truncated_tree() {
    for wavelet in Wavelet::ALL {
        for border in [Border::Periodic, Border::Mirrored] {
            let (tree, coefficients, images) = terms(Transform { wavelet, border, depth: 3 });
            let header = header(3, border == Border::Periodic);
            let limits = Limits { extent: header.extent, depth: 3, views: 1, layers: 9, bytes: u64::MAX };
            let path = arrangements(&images, &limits);
            assert!(path.len() >= 4);
            let mut seen = 0;
            for arrangement in [&path[1], &path[path.len() / 2], &path[path.len() - 1]] {
                let bytes = arrangement.bytes(&limits);
                let pack = arrangement.pack(&images, header.clone()).unwrap();
                assert_eq!(pack.gpu_bytes(), bytes);
                seen += check(&pack, &tree, &coefficients);
            }
            assert!(seen > 1000, "{seen}");
        }
    }
}

fn check(pack: &PwtPack, tree: &PacketTree, coefficients: &[Vec<Plane>; 3]) -> usize {
    let mut seen = 0;
    for (index, texture) in pack.header().textures.iter().enumerate() {
        for own in 0..pack.levels_of(index) {
            let (first, [width, height]) = pack.level_of(index, own);
            let texels = (width * height) as usize;
            let channels = texture.channels as usize;
            for (k, component) in texture.components.iter().enumerate().filter(|(_, c)| c.scale > 0.0) {
                let plane = &coefficients[component.channel as usize][component.term as usize];
                let expected = tree.truncated(plane, texture.level + own);
                assert_eq!(expected.size, [width as usize, height as usize]);
                let layer = &pack.texels(index)[first + k / channels * texels * channels..];
                for (expected, texel) in expected.values.iter().zip(layer.iter().skip(k % channels).step_by(channels)) {
                    let found = component.low + component.scale * f32::from(*texel) / 255.0;
                    assert!((found - expected).abs() <= component.scale * (0.5 / 255.0 + 1e-5), "{found} {expected}");
                    seen += 1;
                }
            }
        }
    }
    seen
}

#[test]
fn an_empty_arrangement_is_a_pack() {
    let (_, _, images) = terms(Transform { wavelet: Wavelet::Haar, border: Border::Periodic, depth: 2 });
    let limits = Limits { extent: [16, 32], depth: 2, views: 1, layers: 0, bytes: u64::MAX };
    let path = arrangements(&images, &limits);
    let pack = path[0].pack(&images, header(2, true)).unwrap();
    assert_eq!((path.len(), pack.gpu_bytes(), pack.header().fetches()), (1, 4 * 8, 1));
}

/// A layer takes the terms that profit most; channels without a term are unused.
#[test]
fn noise_needs_its_finest_level() {
    let (_, _, images) = terms(Transform { wavelet: Wavelet::Haar, border: Border::Periodic, depth: 2 });
    let limits = Limits { extent: [16, 32], depth: 2, views: 1, layers: 9, bytes: u64::MAX };
    let path = arrangements(&images, &limits);
    let pack = path[path.len() - 1].pack(&images, header(2, true)).unwrap();
    let [texture] = &pack.header().textures[..] else { panic!("one level") };
    assert_eq!((texture.level, texture.channels, texture.layers()), (0, 4, 3));
    assert_eq!(texture.components.iter().filter(|component| component.scale == 0.0).count(), 3);
}
