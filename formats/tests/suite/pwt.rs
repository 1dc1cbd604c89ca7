//! Polynomial wavelet trees: file round trips, and look-ups with known answers.

use brdfc_formats::Pack;
use brdfc_formats::container::seal;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::pwt::{
    Component, Domain, LightBasis, LightCoordinates, LightMap, MAX_TERMS, PwtDecoder, PwtHeader, PwtPack, TextureHeader,
};
use brdfc_testing::codecs::pwt::{packs, plain, random, single};
use proptest::prelude::*;

const UP: [f32; 3] = [0.0, 0.0, 1.0];

fn linear(degree: u32) -> LightBasis {
    LightBasis { coordinates: LightCoordinates::Projected, degree }
}

fn decoder(header: PwtHeader, texels: Vec<Vec<u8>>) -> PwtDecoder {
    PwtDecoder::new(PwtPack::new(header, texels).unwrap())
}

#[test]
fn files_round_trip() {
    for (name, pack) in packs() {
        for supercompress in [false, true] {
            let bytes = pack.to_bytes(supercompress);
            let read = PwtPack::from_bytes(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(read, pack, "{name}");
            assert_eq!(read.to_bytes(supercompress), bytes, "{name}");
            assert_eq!(Pack::from_bytes(&bytes).unwrap(), Pack::Pwt(pack.clone()), "{name}");
        }
        let lengths = (0..pack.header().textures.len()).map(|texture| pack.texels(texture).len() as u64);
        // Half floats in four channels, for every term.
        let map = pack.header().light_map.as_ref().map_or(0, |map| 8 * 16 * map.terms() as u64);
        // Rows of 256 words.
        let mesh = pack.header().views.as_ref().map_or(0, |mesh| 1024 * mesh.words().len().div_ceil(256) as u64);
        assert_eq!(pack.gpu_bytes(), lengths.sum::<u64>() + map + mesh, "{name}");
    }
}

/// A component that is equal in all texels gives its value times its weight everywhere, at every level.
#[test]
fn constants_are_constant() {
    let header = plain([3, 2], [4, 4], 2, linear(1));
    let textures = vec![single(0, 0, 2.0, 0.25), single(1, 1, 1.0, 0.0)];
    let decoder = decoder(PwtHeader { textures, ..header }, vec![vec![51; 21], vec![102; 5]]);
    for uv in [[0.0, 0.0], [0.3, 0.9], [1.0, 1.0], [-3.0, 7.5]] {
        for level in [-1.0, 0.0, 0.7, 2.0, 9.0] {
            let light = [0.6, 0.0, 0.8];
            // 0.25 + 2 · 51/255, and x · 102/255.
            let expected = 0.65 + 0.6 * 0.4;
            let found = decoder.value(uv, level, UP, light);
            assert!(found.iter().all(|c| (c - expected).abs() < 1e-6), "{uv:?} {level}: {found:?}");
            // A light at or below the horizon has no effect.
            for z in [0.0, -0.0, -0.8] {
                assert_eq!(decoder.value(uv, level, UP, [0.6, 0.0, z]), [0.0; 3]);
            }
        }
    }
}

/// Four texels: `0, 255` above `51, 102`, which mean 0, 1 above 0.2, 0.4.
fn four(repeats: bool) -> PwtDecoder {
    let header = plain([2, 2], [2, 2], 1, linear(0));
    let header = PwtHeader { repeats, textures: vec![single(0, 0, 1.0, 0.0)], ..header };
    decoder(header, vec![vec![0, 255, 51, 102, 153]])
}

fn grey(decoder: &PwtDecoder, uv: [f32; 2], level: f32) -> f32 {
    let [red, green, blue] = decoder.value(uv, level, UP, UP);
    assert!(red == green && green == blue);
    red
}

#[test]
fn texels_are_filtered_by_hand() {
    for repeats in [false, true] {
        let decoder = four(repeats);
        for (uv, expected) in [
            ([0.25, 0.25], 0.0),
            ([0.75, 0.25], 1.0),
            ([0.25, 0.75], 0.2),
            ([0.75, 0.75], 0.4),
            // The middle, and a quarter of the way along x, half along y: (0.25 + 0.25) / 2.
            ([0.5, 0.5], 0.4),
            ([0.375, 0.5], 0.25),
        ] {
            let found = grey(&decoder, uv, 0.0);
            assert!((found - expected).abs() < 1e-6, "{uv:?} {found}");
        }
        // Half a level is half way from 0.4, the mean of the middle, to 0.6.
        for (level, expected) in [(0.5, 0.5), (0.25, 0.45), (1.0, 0.6), (2.0, 0.6), (-1.0, 0.4), (f32::NAN, 0.4)] {
            let found = grey(&decoder, [0.5, 0.5], level);
            assert!((found - expected).abs() < 1e-6, "{level} {found}");
        }
    }
}

#[test]
fn tiles_repeat_and_other_images_are_clamped() {
    let [image, tile] = [four(false), four(true)];
    // At the left border a tile blends both columns equally.
    assert!((grey(&image, [0.0, 0.25], 0.0) - 0.0).abs() < 1e-6);
    assert!((grey(&tile, [0.0, 0.25], 0.0) - 0.5).abs() < 1e-6);
    assert_eq!(grey(&tile, [1.0, 0.25], 0.0), grey(&tile, [0.0, 0.25], 0.0));
    assert_eq!(grey(&tile, [-0.75, 3.25], 0.0), grey(&tile, [0.25, 0.25], 0.0));
    assert_eq!(grey(&image, [-0.75, 3.25], 0.0), grey(&image, [0.0, 1.0], 0.0));
    // Just below 0, where the remainder rounds to 1.
    assert!((grey(&tile, [-1e-9, 0.25], 0.0) - 0.5).abs() < 1e-6);
    for uv in [[f32::NAN, 0.0], [f32::INFINITY, 0.5], [f32::NEG_INFINITY, f32::NAN], [1e30, -1e30]] {
        for decoder in [&image, &tile] {
            assert!((0.0..=1.0).contains(&grey(decoder, uv, 0.3)), "{uv:?}");
        }
    }
}

/// Padding up to the extent affects an image only at its border.
#[test]
fn coordinates_are_relative_to_the_image_size() {
    let header = plain([3, 1], [4, 2], 1, linear(0));
    let header = PwtHeader { textures: vec![single(0, 0, 1.0, 0.0)], ..header };
    let decoder = decoder(header, vec![vec![0, 51, 102, 255, 0, 0, 0, 0, 0, 0]]);
    for (x, expected) in [(0.0, 0.0), (1.0, 0.2), (2.0, 0.4)] {
        let found = grey(&decoder, [(x + 0.5) / 3.0, 0.5], 0.0);
        assert!((found - expected).abs() < 1e-6, "{x}: {found}");
    }
    // Half way to the first texel beyond the image, and to the row beyond it.
    assert!((grey(&decoder, [1.0, 0.5], 0.0) - 0.7).abs() < 1e-6);
    assert!((grey(&decoder, [0.5, 1.0], 0.0) - 0.1).abs() < 1e-6);
    assert_eq!(grey(&decoder, [1.5, 0.5], 0.0), grey(&decoder, [1.0, 0.5], 0.0));
}

/// All 36 harmonics, each a texture with one component: weights by the triangle, computed by hand for those that do not
/// depend on the azimuth.
#[test]
fn weights_of_all_terms() {
    let basis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 5 };
    let component = |term| Component { channel: 0, term, scale: 0.0, low: if term == 35 { 1.0 } else { 0.0 } };
    let components = (0..36).map(component).collect();
    let textures = vec![TextureHeader { level: 0, channels: 4, components }];
    let mut header = PwtHeader { textures, ..plain([1, 1], [1, 1], 0, basis) };
    assert_eq!((header.triangle.len(), header.fetches()), (666, 9));
    let light = [0.48, 0.36, 0.8];
    let weights = header.weights(light);
    assert_eq!(weights, basis.evaluate(light).map(|term| [term; 3]));
    let weights = weights.map(|[weight, ..]| weight);
    let t = 0.6f32; // 2z - 1
    for (term, expected) in [
        (0, 1.0),
        (2, t),
        (6, 1.5 * t * t - 0.5),
        (12, 2.5 * t.powi(3) - 1.5 * t),
        (20, (35.0 * t.powi(4) - 30.0 * t * t + 3.0) / 8.0),
        (30, (63.0 * t.powi(5) - 70.0 * t.powi(3) + 15.0 * t) / 8.0),
        // P_1^1 = sin θ' = 0.8 without a sign, at the azimuth of (0.8, 0.6).
        (1, 0.8 * 0.6),
        (3, 0.8 * 0.8),
        // P_2^2 = 3 sin² θ', cos 2φ = 0.28, sin 2φ = 0.96.
        (8, 3.0 * 0.64 * 0.28),
        (4, 3.0 * 0.64 * 0.96),
    ] {
        assert!((weights[term] - expected).abs() < 2e-6, "{term}: {} {expected}", weights[term]);
    }
    // The last row adds twice the first term to the last; only the last component exists.
    header.triangle[630] = 2.0;
    let decoder = decoder(header, vec![vec![0; 36]]);
    let expected = (2.0 + weights[35]).max(0.0);
    assert!((grey_under(&decoder, light) - expected).abs() < 1e-5);
}

/// Known answer: term 0 alone without a texel, and a component of another term.
#[test]
fn learned_terms_are_coloured() {
    let basis = LightBasis { coordinates: LightCoordinates::Learned, degree: 1 };
    let map = [vec![[0.5, 0.25, 0.125]; 16], vec![[0.25, -0.5, 0.0]; 16]].concat();
    let light_map = Some(LightMap::new(4, &map).unwrap());
    let header = PwtHeader { light_map, textures: vec![single(0, 1, 1.0, 0.2)], ..plain([1, 1], [1, 1], 0, basis) };
    assert_eq!((header.triangle.len(), header.weights(UP)[2]), (0, [0.0; 3]));
    let decoder = decoder(header.clone(), vec![vec![51]]);
    let found = decoder.value([0.5; 2], 0.0, UP, UP);
    // The component is 0.2 + 51 / 255.
    for (found, expected) in found.into_iter().zip([0.6, 0.05, 0.125]) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
    for (wrong, expected) in [
        (PwtHeader { light_map: None, ..header.clone() }, "terms of the light map: found 0, expected 2"),
        (
            PwtHeader { basis: LightBasis { degree: 36, ..basis }, ..header.clone() },
            "degree: found 36, expected 0 to 35",
        ),
        (PwtHeader { basis: linear(0), triangle: vec![1.0], ..header }, "terms of the light map: found 2, expected 0"),
    ] {
        let error = PwtPack::new(wrong, vec![vec![51]]).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

fn grey_under(decoder: &PwtDecoder, light: [f32; 3]) -> f32 {
    decoder.value([0.5, 0.5], 0.0, UP, light)[0]
}

/// Red, green and blue of three channels, and the scale after the sum.
#[test]
fn colours_and_domains() {
    let component = |channel, low| Component { channel, term: 0, scale: 0.0, low };
    let components = vec![component(0, 0.5), component(1, 0.25), component(2, -0.125), component(1, 0.125)];
    let textures = vec![TextureHeader { level: 0, channels: 4, components }];
    let colour = [[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
    let header = PwtHeader { colour, textures, ..plain([1, 1], [1, 1], 0, linear(0)) };
    let display = |code: f32| ((code + 0.055) / 1.055).powf(2.4);
    for (domain, [red, green, blue]) in [
        (Domain::Linear, [0.5, 0.625, 0.0]),
        (Domain::CubeRoot, [0.125, 0.244_140_63, 0.0]),
        (Domain::Display, [display(0.5), display(0.625), 0.0]),
        (Domain::Logarithm { epsilon: 0.5 }, [0.5f32.exp() - 0.5, 0.625f32.exp() - 0.5, (-0.25f32).exp() - 0.5]),
    ] {
        let decoder = decoder(PwtHeader { domain, ..header.clone() }, vec![vec![9; 4]]);
        let found = decoder.value([0.5; 2], 0.0, UP, UP);
        for (found, expected) in found.into_iter().zip([red, green, blue]) {
            assert!((found - expected).abs() < 2e-6, "{domain:?}: {found} {expected}");
        }
    }
}

/// Decompressed images equal look-ups at texel centres, bit for bit if sides are powers of two, because then centres
/// are exact.
#[test]
fn unpacked_levels_are_the_look_ups() {
    let mut exact = 0;
    for (name, pack) in packs() {
        let decoder = PwtDecoder::new(pack);
        let header = decoder.pack().header().clone();
        let light = [0.36, -0.48, 0.8];
        let weights = header.weights(light);
        for level in 0..=header.levels {
            let unpacked = decoder.unpacked(0, level);
            let [width, height] = unpacked.size();
            assert_eq!([width, height], header.size.map(|side| side.div_ceil(1 << level) as usize));
            let texels = (width * height * header.components().count()) as u64;
            assert_eq!(decoder.unpacked_bytes(level), 4 * texels);
            let image = unpacked.rows(0..height, &weights);
            assert_eq!(unpacked.rows(height - 1..height, &weights)[..], image[(height - 1) * width..]);
            for (k, found) in image.iter().enumerate() {
                let at = [(k % width) as f32 + 0.5, (k / width) as f32 + 0.5];
                let uv = [0, 1].map(|axis| at[axis] * (1 << level) as f32 / header.size[axis] as f32);
                // Centres beyond the border of an image are clamped to it.
                if !header.repeats && uv.iter().any(|c| *c > 1.0) {
                    continue;
                }
                let expected = decoder.value(uv, level as f32, UP, light);
                if header.size.iter().all(|side| side.is_power_of_two()) {
                    assert_eq!(found.map(f32::to_bits), expected.map(f32::to_bits), "{name} {level} {k}");
                    assert_eq!(
                        decoder.sum(uv, level as f32, 0, &weights).map(|sum| header.domain.decode(sum)),
                        expected
                    );
                    exact += 1;
                }
                let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-4 * (1.0 + b.abs());
                assert!(found.iter().zip(&expected).all(close), "{name} {level} {k}: {found:?} {expected:?}");
            }
        }
        // Levels beyond the coarsest are clamped.
        let last = decoder.unpacked(0, header.levels);
        let beyond = decoder.unpacked(0, u32::MAX);
        assert_eq!((beyond.size(), beyond.rows(0..1, &weights)), (last.size(), last.rows(0..1, &weights)));
        assert_eq!(decoder.unpacked_bytes(u32::MAX), decoder.unpacked_bytes(header.levels));
    }
    assert!(exact > 40, "{exact}");
}

#[test]
fn any_weights_give_numbers() {
    for (name, pack) in packs() {
        let decoder = PwtDecoder::new(pack);
        for weight in [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN] {
            let sum = decoder.sum([0.3, 0.7], 0.4, 0, &[[weight; 3]; MAX_TERMS]);
            let value = sum.map(|sum| decoder.pack().header().domain.decode(sum));
            assert!(value.iter().all(|c| (0.0..=65504.0).contains(c)), "{name} {weight}: {value:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
    #[test]
    fn any_pack_there_and_back(
        size in [1u32..20, 1u32..20],
        levels in 0u32..4,
        repeats: bool,
        coordinates in 0usize..3,
        degree in 0u32..6,
        layers in prop::collection::vec((prop::sample::select(vec![1u32, 2, 4]), 1u32..4), 1..4),
        numbers in [-10.0f32..10.0, -1.0f32..1.0],
        seed: u64,
        supercompress: bool,
    ) {
        let step = 1 << levels;
        let extent = size.map(|side| side.next_multiple_of(step));
        let size = if repeats { extent } else { size };
        let basis = LightBasis { coordinates: LightCoordinates::POLYNOMIAL[coordinates], degree };
        let header = plain(size, extent, levels, basis);
        let [scale, low] = numbers;
        let last = basis.terms() as u32 - 1;
        let textures = layers.into_iter().take(levels as usize + 1).zip(0u32..).map(|((channels, layers), level)| {
            let component = |k: u32| Component { channel: k % 3, term: (k + level).min(last), scale, low };
            TextureHeader { level, channels, components: (0..channels * layers).map(component).collect() }
        }).collect();
        let pack = random(PwtHeader { repeats, textures, ..header }, seed);
        prop_assert_eq!(&PwtPack::from_bytes(&pack.to_bytes(supercompress)).unwrap(), &pack);
        let value = PwtDecoder::new(pack).value(numbers, low, UP, [0.6, 0.0, 0.8]);
        prop_assert!(value.iter().all(|c| c.is_finite() && *c >= 0.0));
    }
}

/// Four texels of each of two views, `10 v + k` for texel `k` of layer `l`: 100 more in the second layer.
fn two_views() -> PwtDecoder {
    let set = DirectionSet::new("two", vec![[0.0, 0.0], [60.0, 0.0]]).unwrap();
    let basis = linear(0);
    let component = |term| Component { channel: 0, term, scale: 255.0, low: 0.0 };
    let textures = vec![TextureHeader { level: 0, channels: 1, components: vec![component(0), component(0)] }];
    let views = Some(DirectionMesh::new(&set).unwrap());
    let header = PwtHeader { repeats: true, views, textures, ..plain([2, 2], [2, 2], 0, basis) };
    let layer = |first: u8| (0..2u8).flat_map(move |view| (0..4).map(move |k| first + 10 * view + k));
    decoder(header, vec![layer(0).chain(layer(100)).collect()])
}

/// Known answers: at its direction each view is the sum of its own layers; between, they are blended in paraboloid coordinates;
/// texels of other views never show.
#[test]
fn views_are_blended_by_their_directions() {
    let decoder = two_views();
    let at = |degrees: f32| [degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()];
    let value = |degrees, uv| decoder.value(uv, 0.0, at(degrees), UP)[0];
    for (k, uv) in [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]].into_iter().enumerate() {
        let [first, second] = [100.0 + 2.0 * k as f32, 120.0 + 2.0 * k as f32];
        assert!((value(0.0, uv) - first).abs() < 1e-3 && (value(60.0, uv) - second).abs() < 1e-3, "{k}");
        // Half of the tangent of half the angle.
        let middle = 2.0 * (0.5 * 30f32.to_radians().tan()).atan().to_degrees();
        assert!((value(middle, uv) - 0.5 * (first + second)).abs() < 1e-2, "{k}: {}", value(middle, uv));
        assert!((value(-60.0, uv) - first).abs() < 1e-3 && (value(80.0, uv) - second).abs() < 1e-3, "{k}");
    }
    // A tile repeats its own view, not the next one.
    assert!((value(0.0, [0.25, 0.0]) - 102.0).abs() < 1e-3, "{}", value(0.0, [0.25, 0.0]));
    let rows = |view| decoder.unpacked(view, 0).rows(0..2, &decoder.pack().header().weights(UP));
    assert_eq!([rows(0)[3], rows(1)[0]].map(|colour| colour[0].round()), [106.0, 120.0]);
}

/// Files whose mesh is missing, of another number of views, or not finite, and packs with too many layers.
#[test]
fn wrong_views_are_rejected() {
    let pack = two_views().into_pack();
    let bytes = pack.to_bytes(false);
    assert_eq!(PwtPack::from_bytes(&bytes).unwrap(), pack);
    let header = pack.header().clone();
    let mut components = header.textures[0].components.clone();
    components.resize(129, components[0]);
    let textures = vec![TextureHeader { level: 0, channels: 1, components }];
    let error = PwtPack::new(PwtHeader { textures, ..header.clone() }, vec![Vec::new()]).unwrap_err().to_string();
    let expected = "brdfc.pwt layers of a texture: found 129 for each of 2 views, expected at most 256 in all";
    assert_eq!(error, expected);
    let single = DirectionMesh::new(&DirectionSet::new("one", vec![[0.0, 0.0]]).unwrap()).unwrap();
    let error = PwtPack::new(PwtHeader { views: Some(single), ..header }, vec![vec![0; 16]]).unwrap_err().to_string();
    assert_eq!(error, "brdfc.pwt views: found 1, expected 2 to 256");
    // The last coordinate of the mesh becomes NaN.
    let x = (60f32.to_radians() / 2.0).tan().to_bits().to_le_bytes();
    let at = bytes.windows(4).position(|word| word[1..] == x[1..]).expect("the mesh has the view");
    let mut broken = bytes.clone();
    broken[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    seal(&mut broken);
    let error = PwtPack::from_bytes(&broken).unwrap_err().to_string();
    assert_eq!(error, "directions, coordinate 2: found NaN, expected -1 to 1");
}
