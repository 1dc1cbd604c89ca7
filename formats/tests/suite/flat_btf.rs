//! Flat BTFs: known answers of the decoder, blends that stay in their block, and file round trips.

use brdfc_formats::container::{half, rgb9e5};
use brdfc_formats::flat_btf::factored::ShadowFormat;
use brdfc_formats::flat_btf::{
    DiffuseMap, FlatBtfDecoder, FlatBtfFile, FlatBtfParts, FlatHeader, FlatValues, FlatView, IndirectionHeader,
    IndirectionMap, NormalMap, ReferenceMap, VisibilityMask,
};
use brdfc_testing::codecs::flat_btf::{self, Factors, SMALL, Sizes, only};
use brdfc_testing::packs::{Numbers, unit_vector};
use proptest::prelude::*;
use std::f32::consts::{FRAC_PI_2, TAU};

fn from_angles(polar: f32, azimuth: f32) -> [f32; 3] {
    [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
}

/// Each texel of the reference plane maps to the parameters above it.
fn plane_reference(size: u32) -> ReferenceMap {
    let centre = |k: u32| (k as f32 + 0.5) / size as f32;
    let parameters = (0..size * size).map(|at| [centre(at % size), centre(at / size)]).collect();
    ReferenceMap::new(size, parameters).unwrap()
}

/// An asset on the plane with this displacement and height for all texels of the reference.
fn asset(sizes: Sizes, sample: impl Fn([u32; 2], u32, u32) -> ([f32; 2], f32)) -> FlatBtfParts {
    let indirection = IndirectionMap::from_displacements(flat_btf::header(sizes), sample).unwrap();
    FlatBtfParts {
        reference: plane_reference(sizes.reference),
        indirection: indirection.into(),
        ..flat_btf::parts(sizes, 3)
    }
}

const PLANE: Sizes =
    Sizes { flat: 8, reference: 8, zenith: 5, azimuth: 6, largest_angle: FRAC_PI_2, views: 3, lights: 5 };

/// A flat plane has no parallax: in all views the parameters are those of the texel's centre.
#[test]
fn a_plane_has_no_parallax() {
    let decoder = FlatBtfDecoder::new(asset(PLANE, |_, _, _| ([0.0; 2], 0.0))).unwrap();
    let mut numbers = Numbers::new(1);
    for _ in 0..500 {
        let uv = [numbers.between(-3.0, 3.0) as f32, numbers.between(-3.0, 3.0) as f32];
        let view = unit_vector(&mut numbers);
        let centre = uv.map(|c| ((c - c.floor()) * 8.0).floor() / 8.0 + 0.0625);
        assert_eq!(decoder.indirection(uv, view), [centre[0], centre[1], 0.0], "{uv:?} {view:?}");
    }
}

/// At texel centres a plane of equal resolution returns the texels of the flat BTF, for each view and light.
#[test]
fn a_plane_returns_the_flat_btf_unchanged() {
    let parts = asset(PLANE, |_, _, _| ([0.0; 2], 0.0));
    let decoder = FlatBtfDecoder::new(parts.clone()).unwrap();
    for (view, light, [i, j]) in [(0, 0, [0, 0]), (1, 4, [7, 3]), (2, 2, [2, 7])] {
        let uv = [i, j].map(|k: u32| (k as f32 + 0.5) / 8.0);
        let texel = parts.values.views()[view as usize].light(light)[(8 * j + i) as usize];
        assert_eq!(decoder.full(uv, [0.0, 0.6, 0.8], only(view), only(light)), rgb9e5::decode(texel));
    }
    // Halfway between centres the reference is not filtered, so a texel of the plane is a step.
    let uv = [0.126, 0.0625];
    assert_eq!(
        decoder.full(uv, [0.0, 0.0, 1.0], only(0), only(0)),
        rgb9e5::decode(parts.values.views()[0].texels()[1])
    );
}

/// The filter wraps around the border of the tile: a reference at parameter 0 blends the last texels with the first.
#[test]
fn filtering_is_periodic() {
    let mut parts = asset(Sizes { reference: 1, ..PLANE }, |_, _, _| ([0.0; 2], 0.0));
    let colour = |k: u32| [k as f32, 1.0, 0.0];
    let texels: Vec<u32> = (0..64).map(|at| rgb9e5::encode(colour(at % 8))).collect();
    parts.values = FlatValues::None;
    parts.diffuse = DiffuseMap::new(8, texels).unwrap();
    parts.normal = NormalMap::new(8, vec![[0.0, 0.0, 1.0]; 64]).unwrap();
    for (u, expected) in
        [(0.0, 3.5), (1.0, 3.5), (-5.0, 3.5), (0.0625, 0.0), (0.9375, 7.0), (0.03125, 1.75), (0.5, 3.5)]
    {
        parts.reference = ReferenceMap::new(1, vec![[u, 0.3]]).unwrap();
        let decoder = FlatBtfDecoder::new(parts.clone()).unwrap();
        let [red, green, _] = decoder.light_form([0.5, 0.5], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]);
        assert!((red - 0.8 * expected).abs() < 1e-5 && (green - 0.8).abs() < 1e-6, "{u}: {red} {green}");
    }
}

/// A plane at depth h below the reference is displaced by `-h tan φ` along the view. With samples that are linear in
/// the angle the blend is exact along it for any azimuth, because directions are blended, not displacements.
#[test]
fn linear_displacements_are_rebuilt() {
    let slope = 0.25;
    let sizes = Sizes { reference: 4, zenith: 9, azimuth: 64, largest_angle: 1.5, ..PLANE };
    let header = flat_btf::header(sizes);
    let parts = asset(sizes, |_, k, a| {
        let [polar, azimuth] = header.view_angles(k, a).map(|angle| angle as f32);
        ([slope * polar * azimuth.cos(), slope * polar * azimuth.sin()], -0.1 * polar)
    });
    let reference = parts.reference.clone();
    let decoder = FlatBtfDecoder::new(parts).unwrap();
    let mut numbers = Numbers::new(5);
    for _ in 0..2000 {
        let (polar, azimuth) = (numbers.between(0.0, 1.5) as f32, numbers.between(0.0, 6.2) as f32);
        let [i, j] = [numbers.bits() % 4, numbers.bits() % 4];
        let uv = [i, j].map(|k| (k as f32 + 0.3) / 4.0);
        let [u, v, z] = decoder.indirection(uv, from_angles(polar, azimuth));
        let [x, y] = reference.parameters()[(4 * j + i) as usize];
        let periodic = |c: f32| c - c.round();
        let [du, dv] = [periodic(u - x), periodic(v - y)];
        // Halves have a relative precision of 2^-12; blending between 64 directions turns them by less than 1e-3.
        let distance = slope * polar;
        assert!((du - distance * azimuth.cos()).abs() < 4e-4, "{polar} {azimuth}: {du}");
        assert!((dv - distance * azimuth.sin()).abs() < 4e-4, "{polar} {azimuth}: {dv}");
        assert!((du.hypot(dv) - distance).abs() < 2e-4 && (z + 0.1 * polar).abs() < 1e-4);
    }
}

/// Equation 3 with four samples of known values, and the view halfway between all of them.
#[test]
fn directions_and_distances_blend_separately() {
    let sizes = Sizes { reference: 1, zenith: 3, azimuth: 4, largest_angle: 1.0, ..PLANE };
    let parts = asset(sizes, |_, k, a| {
        let direction = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][a as usize];
        let distance = 0.1 * k as f32 * (1 + a) as f32;
        (direction.map(|c| c * distance), k as f32)
    });
    let decoder = FlatBtfDecoder::new(parts).unwrap();
    let displaced = |polar, azimuth| {
        let [u, v, z] = decoder.indirection([0.5, 0.5], from_angles(polar, azimuth));
        [u - 0.5, v - 0.5, z]
    };
    // Distances 0.1, 0.2 of the first two azimuths at 0.5, and 0.2, 0.4 at 1.0; the direction is halfway, of length 1.
    let mean = (0.1 + 0.2 + 0.2 + 0.4) / 4.0;
    let [x, y, z] = displaced(0.75, FRAC_PI_2 / 2.0);
    let expected = mean * 0.5f32.sqrt();
    assert!((x - expected).abs() < 1e-4 && (y - expected).abs() < 1e-4 && (z - 1.5).abs() < 1e-5, "{x} {y} {z}");
    // Across the seam of the azimuth, from the last to the first.
    let [x, y, _] = displaced(0.5, 1.75 * std::f32::consts::PI);
    let expected = (0.4 + 0.1) / 2.0 * 0.5f32.sqrt();
    assert!((x - expected).abs() < 1e-4 && (y + expected).abs() < 1e-4, "{x} {y}");
    // Beyond the largest angle, and below the horizon, nothing changes any more.
    assert_eq!(displaced(1.0, 0.3), displaced(1.2, 0.3));
    assert_eq!(displaced(1.0, 0.3), displaced(2.5, 0.3));
}

/// All blocks except one hold the largest numbers; only the block of the requested texel has an effect.
#[test]
fn blends_never_leave_a_block() {
    let sizes = Sizes { reference: 3, zenith: 3, azimuth: 4, largest_angle: 1.2, ..PLANE };
    let one = |k: u32, a: u32| ([0.01 * (k * (a + 1)) as f32, 0.0], 0.25);
    let alone = FlatBtfDecoder::new(asset(sizes, |_, k, a| one(k, a))).unwrap();
    let among = asset(sizes, |texel, k, a| if texel == [1, 1] { one(k, a) } else { ([1024.0, 0.0], 1024.0) });
    let among = FlatBtfDecoder::new(among).unwrap();
    let mut numbers = Numbers::new(9);
    let mut views: Vec<[f32; 3]> = (0..2000).map(|_| unit_vector(&mut numbers)).collect();
    for k in 0..=16 {
        for a in 0..=64 {
            views.push(from_angles(1.2 * k as f32 / 16.0, TAU * a as f32 / 64.0));
        }
    }
    views.extend([[1.0, -0.0, 0.0], [1.0, -1e-30, 0.0], [-1.0, -1e-30, 0.0], [0.0, 0.0, -1.0], [0.0; 3]]);
    for uv in [[0.3334, 0.3334], [0.5, 0.5], [0.6666, 0.6666]] {
        for view in &views {
            let found = among.indirection(uv, *view);
            assert_eq!(found, alone.indirection(uv, *view), "{view:?}");
            assert!(found[2] == 0.25 || (found[2] - 0.25).abs() < 1e-6);
        }
    }
    // The neighbours differ, so the test would detect them.
    assert!(among.indirection([0.1, 0.5], [0.0, 0.0, 1.0])[2] == 1024.0);
}

#[test]
fn any_query_gives_numbers_in_range() {
    let decoder = FlatBtfDecoder::new(flat_btf::parts(SMALL, 4)).unwrap();
    let odd = [0.0, -0.0, 1.0, -1e-9, 1e9, -1e30, f32::MAX, f32::INFINITY, f32::NAN, f32::MIN_POSITIVE];
    for u in odd {
        for v in odd {
            for z in odd {
                let found = decoder.indirection([u, v], [v, u, z]);
                assert!((0.0..1.0).contains(&found[0]) && (0.0..1.0).contains(&found[1]), "{u} {v} {z}: {found:?}");
                let value = decoder.full([u, v], [u, z, v], only(2), only(4));
                assert!(value.iter().all(|c| (0.0..2.0).contains(c)), "{value:?}");
            }
        }
    }
}

/// The full form is the weighted sum of its pairs; pairs with weight 0 are not read.
#[test]
fn views_and_lights_are_blended_by_their_weights() {
    let decoder = FlatBtfDecoder::new(flat_btf::parts(SMALL, 7)).unwrap();
    let mut numbers = Numbers::new(2);
    for _ in 0..200 {
        let (views, lights) = (flat_btf::weights(&mut numbers, 3), flat_btf::weights(&mut numbers, 5));
        let uv = [numbers.unit() as f32, numbers.unit() as f32];
        let view = unit_vector(&mut numbers);
        let mut expected = [0.0; 3];
        for v in 0..3 {
            for l in 0..3 {
                let value = decoder.full(uv, view, only(views.indices[v]), only(lights.indices[l]));
                for channel in 0..3 {
                    expected[channel] += views.weights[v] * lights.weights[l] * value[channel];
                }
            }
        }
        let found = decoder.full(uv, view, views, lights);
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{found:?} {expected:?}");
    }
    let mut nowhere = only(1);
    nowhere.indices[1] = u32::MAX;
    assert_eq!(
        decoder.full([0.2, 0.3], [0.0, 0.0, 1.0], nowhere, only(0)),
        decoder.full([0.2, 0.3], [0.0, 0.0, 1.0], only(1), only(0))
    );
}

#[test]
fn the_light_form_is_a_lambertian_surface() {
    let mut parts = asset(PLANE, |_, _, _| ([0.0; 2], 0.0));
    parts.values = FlatValues::None;
    let tilted = [0.6, 0.0, 0.8];
    parts.normal = NormalMap::new(8, vec![tilted; 64]).unwrap();
    parts.diffuse = DiffuseMap::from_colours(8, &[[0.5, 0.25, 0.125]; 64]).unwrap();
    let decoder = FlatBtfDecoder::new(parts).unwrap();
    for (light, cosine) in [(tilted, 1.0), ([0.0, 0.0, 1.0], 0.8), ([-0.8, 0.0, 0.6], 0.0), ([-1.0, 0.0, 0.0], 0.0)] {
        let value = decoder.light_form([0.3, 0.4], [0.0, 0.0, 1.0], light);
        for (found, expected) in value.into_iter().zip([0.5, 0.25, 0.125]) {
            assert!((found - expected * cosine).abs() < 3e-4, "{light:?}: {value:?}");
        }
    }
}

fn views(parts: &mut FlatBtfParts) -> &mut Vec<FlatView> {
    match &mut parts.values {
        FlatValues::Views(views) => views,
        other => panic!("{other:?}"),
    }
}

#[test]
fn parts_that_do_not_match_are_rejected() {
    let good = flat_btf::parts(SMALL, 1);
    let refusal = |change: &dyn Fn(&mut FlatBtfParts)| {
        let mut parts = good.clone();
        change(&mut parts);
        FlatBtfDecoder::new(parts).unwrap_err().field.into_owned()
    };
    let larger = flat_btf::parts(Sizes { flat: 5, reference: 3, ..SMALL }, 1);
    assert_eq!(refusal(&|p| p.reference = larger.reference.clone()), "size of the part indirection");
    assert_eq!(refusal(&|p| p.normal = larger.normal.clone()), "size of the part normal");
    assert_eq!(refusal(&|p| p.values = larger.values.clone()), "size of the part flat");
    assert_eq!(refusal(&|p| drop(views(p).pop())), "views of the part flat");
    assert_eq!(refusal(&|p| views(p).swap(0, 1)), "views of the part flat");
    let changed = |p: &mut FlatBtfParts| {
        let view = &mut views(p)[2];
        let mut header = view.header().clone();
        header.lights[1][0] += 0.01;
        *view = FlatView::new(header, view.texels().to_vec()).unwrap();
    };
    assert_eq!(refusal(&changed), "directions of view 2");
}

fn sizes() -> impl Strategy<Value = Sizes> {
    (1u32..6, 1u32..4, 2u32..5, 3u32..6, 0.1f32..1.57, 1u32..5, 1u32..7).prop_map(
        |(flat, reference, zenith, azimuth, largest_angle, views, lights)| Sizes {
            flat,
            reference,
            zenith,
            azimuth,
            largest_angle,
            views,
            lights,
        },
    )
}

proptest! {
    #[test]
    fn files_round_trip(sizes in sizes(), seed in 0u64..1000, supercompress in any::<bool>(), compact in any::<bool>(), report in ".*") {
        let factors = Factors { levels: 1, groups: 2, wide_groups: 1, shadow: ShadowFormat::R8 };
        let mut parts = flat_btf::parts(sizes, seed);
        parts.values = FlatValues::None;
        if compact {
            parts.indirection = flat_btf::displacements(sizes, sizes.reference, seed).into();
            parts.values = FlatValues::Factored(Box::new(flat_btf::factored(sizes, factors, seed)));
        }
        let file = FlatBtfFile::new(FlatBtfDecoder::new(parts).unwrap(), Some(flat_btf::mask(sizes, seed))).unwrap();
        let file = FlatBtfFile { report, ..file };
        prop_assert_eq!(FlatBtfFile::from_bytes(&file.to_bytes(supercompress)).unwrap(), file);
    }

    /// Displacements round-trip to the precision of halves.
    #[test]
    fn displacements_survive_the_packing(x in -2.0f32..2.0, y in -2.0f32..2.0, z in -2.0f32..2.0) {
        let header = IndirectionHeader { size: 2, zenith_samples: 3, azimuth_samples: 3, largest_angle: 1.0 };
        let at = ([1, 0], 2, 1);
        let sample = |texel, k, a| if (texel, k, a) == at { ([x, y], z) } else { ([0.0; 2], 0.0) };
        let map = IndirectionMap::from_displacements(header, sample).unwrap();
        let [dx, dy, distance, height] = map.sample(at.0, at.1, at.2);
        prop_assert!((dx * distance - x).abs() < 2e-3 && (dy * distance - y).abs() < 2e-3);
        prop_assert_eq!(height, half::decode(half::encode(z)));
        prop_assert_eq!(map.sample([0, 0], 2, 1), [0.0; 4]);
    }
}

#[test]
fn masks_and_views_are_found_by_texel() {
    let mask = VisibilityMask::new(2, 2, vec![0, 0, 0, 0, 0, 255, 0, 0]).unwrap();
    assert!(mask.is_seen(1, [1, 0]) && !mask.is_seen(1, [0, 1]) && !mask.is_seen(0, [1, 0]));
    let header = FlatHeader { size: 1, view: 0, views: vec![[0.0; 2]], lights: vec![[0.0; 2], [1.0, 2.0]] };
    let view = FlatView::new(header, vec![3, 4]).unwrap();
    assert_eq!((view.light(0), view.light(1)), (&[3][..], &[4][..]));
}
