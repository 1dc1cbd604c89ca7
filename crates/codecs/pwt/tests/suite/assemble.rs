//! Tests the arrangement of terms at their levels, and the resulting textures.

use brdfc_formats::pwt::{LightBasis, LightCoordinates, PwtHeader, PwtPack};
use brdfc_pwt::assemble::arrange;
use brdfc_pwt::image::Plane;
use brdfc_pwt::levels::{StepUp, TermImages, magnified, range, steps, term_images};
use brdfc_pwt::tree::{PacketTree, Transform};
use brdfc_pwt::{Border, Wavelet};
use brdfc_testing::codecs::pwt::plain;
use brdfc_testing::packs::Numbers;

#[test]
fn magnified_by_hand() {
    let plane = Plane { size: [2, 1], values: vec![0.0, 1.0] };
    assert_eq!(magnified(&plane, 0, false), plane);
    let twice = magnified(&plane, 1, false);
    assert_eq!((twice.size, &twice.values[..4]), ([4, 2], &[0.0, 0.25, 0.75, 1.0][..]));
    assert_eq!(magnified(&plane, 1, true).values[..4], [0.25, 0.25, 0.75, 0.75]);
    assert_eq!(range(&[plane, Plane { size: [1, 1], values: vec![-3.0] }]), (-3.0, 1.0));
}

/// A term with these errors; its image needs no levels.
fn term(term: usize, errors: &[f64]) -> TermImages {
    TermImages { channel: 0, term, levels: Vec::new(), errors: errors.to_vec() }
}

#[test]
fn steps_gain_most_per_byte_first() {
    // Level 1 takes a quarter of the bytes. The first term gains 8 for ¼, then 1 for ¾. The second gains 4 for 1 in one
    // step: its level 1, which would gain ½ for ¼, is skipped. The third gains nothing.
    let images = [term(0, &[0.0, 1.0, 9.0]), term(1, &[0.0, 3.5, 4.0]), term(2, &[2.0, 2.0, 2.0])];
    let step = |image, base, error| StepUp { image, base, error };
    assert_eq!(steps(&images), [step(0, 1, 7.0), step(1, 0, 3.0), step(0, 0, 2.0)]);
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
    let images = term_images(&tree, &coefficients, &weights, transform.border == Border::Periodic);
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
            let steps = steps(&images);
            assert!(steps.len() >= 9);
            let mut seen = 0;
            for count in [1, steps.len() / 2, steps.len()] {
                let arrangement = arrange(&images, &steps, count);
                let header = header(3, border == Border::Periodic);
                let bytes = arrangement.bytes(header.extent, header.levels);
                let pack = arrangement.pack(&images, header).unwrap();
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
    let steps = steps(&images);
    let pack = arrange(&images, &steps, 0).pack(&images, header(2, true)).unwrap();
    assert_eq!((pack.gpu_bytes(), pack.header().fetches()), (4 * 8, 1));
}

/// Texels have 4, 2 or 1 channels: the largest number for which padding is cheap.
#[test]
fn texels_are_filled_where_that_is_cheap() {
    let (_, _, images) = terms(Transform { wavelet: Wavelet::Haar, border: Border::Periodic, depth: 2 });
    for (count, channels, layers) in [(9, 1, 9), (8, 4, 2), (6, 2, 3)] {
        let images = &images[..count];
        let steps = steps(images);
        let pack = arrange(images, &steps, steps.len()).pack(images, header(2, true)).unwrap();
        let [texture] = &pack.header().textures[..] else { panic!("noise needs its finest level") };
        assert_eq!((texture.level, texture.channels, texture.layers()), (0, channels, layers), "{count}");
    }
}
