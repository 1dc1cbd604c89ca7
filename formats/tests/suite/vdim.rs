//! Indirection maps and sampled shadows of flat BTFs: known answers, rejected texels and headers, and file round trips.

use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_formats::direction::from_polar;
use brdfc_formats::flat_btf::{
    CompactSamples, FlatBtfDecoder, FlatBtfFile, FlatBtfParts, MacroSurface, Relief, SampledDirections, SeenPoint,
    ShadowMap, Vdim, VdimHeader, VdimSamples,
};
use brdfc_testing::codecs::flat_btf::{
    BASE, MATERIALS, SMALL, compact_vdim_file, factored, image, indirections, layers, refusal, reshape, sampled_relief,
    sampled_shadows, set_texel, set_word, vdim_file,
};
use std::f64::consts::{FRAC_PI_2, PI};

const HEADER: VdimHeader =
    VdimHeader { size: 4, block: 1, polar_angles: 9, azimuth_rows: 65, largest_angle: 1.5, levels: 1, lights: 0 };
const KEY: &str = "brdfc.flat-btf.vdim";

/// A map without reference in which all texels have this displacement and height.
fn plane(header: VdimHeader, sample: impl Fn(u32, u32) -> ([f32; 2], f32)) -> Vdim {
    let reference = vec![[0.0; 2]; (header.size * header.size) as usize];
    let seen = |_, k, a| {
        let (displacement, height) = sample(k, a);
        SeenPoint { displacement, height }
    };
    Vdim::of_views(header, reference, seen).unwrap()
}

fn view(polar: f64, azimuth: f64) -> [f32; 3] {
    from_polar(polar, azimuth).map(|c| c as f32)
}

#[test]
fn a_plane_has_no_parallax() {
    let map = plane(HEADER, |_, _| ([0.0; 2], 0.0));
    for k in 0..500u32 {
        let uv = [f64::from(k) / 77.0 - 2.0, f64::from(k) / 31.0].map(|c| c as f32);
        assert_eq!(map.seen(uv, view(f64::from(k % 23) / 14.0, f64::from(k) / 79.0), 0.0), (uv, 0.0), "{k}");
    }
}

/// With samples that are linear in the angle the blend is exact along it for any azimuth, because directions are blended,
/// not displacements.
#[test]
fn linear_displacements_are_rebuilt() {
    let slope = 0.25;
    let map = plane(HEADER, |k, a| {
        let [polar, azimuth] = HEADER.view_angles(k, a).map(|angle| angle as f32);
        ([slope * polar * azimuth.cos(), slope * polar * azimuth.sin()], -0.1 * polar)
    });
    for k in 0..2000u32 {
        let (polar, azimuth) = (1.5 * f64::from(k * 619 % 1999) / 1999.0, 6.2 * f64::from(k) / 2000.0);
        let ([u, v], z) = map.seen([0.3, 0.6], view(polar, azimuth), 0.0);
        // Halves have a relative precision of 2^-12; blending between 64 directions turns them by less than 1e-3.
        let (du, dv, distance) = (f64::from(u - 0.3), f64::from(v - 0.6), f64::from(slope) * polar);
        assert!((du - distance * azimuth.cos()).abs() < 4e-4, "{polar} {azimuth}: {du}");
        assert!((dv - distance * azimuth.sin()).abs() < 4e-4, "{polar} {azimuth}: {dv}");
        assert!((du.hypot(dv) - distance).abs() < 2e-4 && (f64::from(z) + 0.1 * polar).abs() < 1e-4);
    }
}

/// Equation 3 with four samples of known values, and the view halfway between all of them.
#[test]
fn directions_and_distances_blend_separately() {
    let header = VdimHeader { size: 1, polar_angles: 3, azimuth_rows: 5, largest_angle: 1.0, ..HEADER };
    let map = plane(header, |k, a| {
        let direction = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][a as usize];
        let distance = 0.1 * k as f32 * (1 + a) as f32;
        (direction.map(|c| c * distance), k as f32)
    });
    let displaced = |polar, azimuth| {
        let ([u, v], z) = map.seen([0.5; 2], view(polar, azimuth), 0.0);
        [u - 0.5, v - 0.5, z]
    };
    // Distances of the first two azimuths: 0.1, 0.2 at 0.5, and 0.2, 0.4 at 1.0. The direction is halfway.
    let mean = (0.1 + 0.2 + 0.2 + 0.4) / 4.0;
    let [x, y, z] = displaced(0.75, FRAC_PI_2 / 2.0);
    let expected = mean * 0.5f32.sqrt();
    assert!((x - expected).abs() < 1e-4 && (y - expected).abs() < 1e-4 && (z - 1.5).abs() < 1e-5, "{x} {y} {z}");
    // Across the seam of the azimuth, from the last to the first.
    let [x, y, _] = displaced(0.5, 1.75 * PI);
    let expected = (0.4 + 0.1) / 2.0 * 0.5f32.sqrt();
    assert!((x - expected).abs() < 1e-4 && (y + expected).abs() < 1e-4, "{x} {y}");
    let [before, after] = [-1e-6, 1e-6].map(|azimuth| displaced(0.6, azimuth));
    assert!((0..3).all(|c| (before[c] - after[c]).abs() < 1e-4), "{before:?} {after:?}");
    // Beyond the largest angle, and below the horizon, nothing changes any more.
    assert_eq!(displaced(1.0, 0.3), displaced(1.2, 0.3));
    assert_eq!(displaced(1.0, 0.3), displaced(2.5, 0.3));
    // The negative control: within it, the angle matters.
    assert!(displaced(0.9, 0.3) != displaced(1.0, 0.3));
}

/// Along the normal the azimuth has no effect; away from it, it has.
#[test]
fn the_pole_does_not_depend_on_the_azimuth() {
    let map = indirections(SMALL, 0, 5);
    let seen = |polar, azimuth| map.seen([0.4, 0.9], view(polar, azimuth), 0.0).0;
    for azimuth in [0.7, 2.0, 3.9, 6.0] {
        assert_eq!(seen(0.0, azimuth), seen(0.0, 0.0));
        assert!(seen(0.8, azimuth) != seen(0.8, 0.0));
    }
}

/// Within a texel parameters move with the position. Levels have their own texels, the nearest level counts.
#[test]
fn each_texel_and_level_has_its_own_views() {
    let map = indirections(SMALL, 0, 5);
    let seen = |uv, detail| map.seen(uv, view(0.8, 0.3), detail);
    let ([u, v], height) = seen([0.26, 0.52], 0.0);
    let ([s, t], same) = seen([0.36, 0.6], 0.0);
    assert!((s - u - 0.1).abs() < 1e-6 && (t - v - 0.08).abs() < 1e-6 && height == same);
    assert!(seen([0.38, 0.6], 0.0).1 != height, "the next texel");
    assert_eq!(seen([0.26, 0.52], 0.49).1, height);
    assert!(seen([0.26, 0.52], 0.51).1 != height, "the next level");
    assert_eq!(seen([0.26, 0.52], 17.0).1, seen([0.9, 0.1], 3.0).1, "one texel is the last level");
    // The tile repeats.
    let ([s, t], repeated) = seen([2.26, -1.48], 0.0);
    assert!((s - u - 2.0).abs() < 1e-5 && (t - v + 2.0).abs() < 1e-5 && height == repeated);
}

/// Shadows scale values by the share of the blended lights. The control: without shadows all light arrives.
#[test]
fn sampled_shadows_scale_values() {
    let reflectance = factored(SMALL, MATERIALS, 6);
    let shares = [0u8, 51, 102, 153, 255];
    let texels = |light: usize, level: u32| vec![shares[light]; (SMALL.flat >> level).pow(2) as usize];
    let bytes = (0..BASE.levels).flat_map(|level| (0..5).flat_map(move |light| texels(light, level))).collect();
    let lights = sampled_shadows(SMALL, BASE.levels, 1).lights().to_vec();
    let shadows = ShadowMap::new(lights.clone(), SMALL.flat, BASE.levels, bytes).unwrap();
    let relief = Relief::sampled(indirections(SMALL, 5, 4), Some(shadows)).unwrap();
    let dark = FlatBtfDecoder::new(FlatBtfParts::new(relief, reflectance.clone()));
    let bright =
        FlatBtfDecoder::new(FlatBtfParts::new(Relief::sampled(indirections(SMALL, 0, 4), None).unwrap(), reflectance));
    let directions = SampledDirections::of(dark.parts()).unwrap();
    assert!(SampledDirections::of(bright.parts()).unwrap().is_none());
    let mut lit = 0;
    for (light, share) in lights.iter().zip(shares) {
        let to_light = view(f64::from(light[0]), f64::from(light[1]));
        for k in 0..20 {
            let uv = [0.13 * k as f32, 0.29 * k as f32];
            let look = |decoder: &FlatBtfDecoder, directions| {
                decoder.shaded(directions, uv, 0.4, view(0.5, f64::from(k)), to_light)
            };
            let (found, whole) = (look(&dark, directions.as_ref()), look(&bright, None));
            lit += usize::from(whole != [0.0; 3]);
            for c in 0..3 {
                let expected = whole[c] * f32::from(share) / 255.0;
                assert!((found[c] - expected).abs() <= 1e-5 * whole[c], "{found:?} {expected} {share}");
            }
        }
    }
    assert!(lit > 50, "{lit}");
}

/// On curved surfaces the local frame counts, without outlines.
#[test]
fn curved_surfaces_have_no_outline() {
    let decoder = vdim_file().decoder;
    assert_eq!(decoder.parts().relief.outline(), None);
    let curved = MacroSurface { curvature: [0.5, 0.0, 0.25], height: 0.1, ..MacroSurface::PLANE };
    let looks = [MacroSurface::PLANE, curved].map(|surface| decoder.look([0.3, 0.2], 0.0, view(1.4, 0.3), surface));
    assert!(looks.iter().all(|look| !look.passes() && look.moved() == [0.0; 2]));
    assert_eq!(looks[0].point(), looks[1].point());
    // Tiles that are turned turn the view with them.
    let turned = MacroSurface { stretch: [0.0, -1.0, 1.0, 0.0], ..MacroSurface::PLANE };
    let other = decoder.look([0.3, 0.2], 0.0, view(1.4, 0.3 - FRAC_PI_2), turned);
    assert!((other.point().rise - looks[0].point().rise).abs() < 1e-5);
}

#[test]
fn files_round_trip() {
    let reflectance = factored(SMALL, MATERIALS, 6);
    for with_shadows in [false, true] {
        let relief = sampled_relief(SMALL, with_shadows, |lights| indirections(SMALL, lights, 3));
        let parts = FlatBtfParts::new(relief, reflectance.clone());
        let file = FlatBtfFile::new(FlatBtfDecoder::new(parts)).unwrap();
        for supercompress in [false, true] {
            let read = FlatBtfFile::from_bytes(&file.to_bytes(supercompress)).unwrap();
            assert!(read == file && read.directions.is_some() == with_shadows);
        }
    }
}

/// 8 bytes per view of a texel and 4 per texel, on all levels; a byte per light of a texel of the flat BTF.
#[test]
fn graphics_memory_is_the_sum_of_the_texels() {
    let file = vdim_file();
    let texels = 64 + 16 + 4 + 1;
    let shadows = 5 * (16 + 4 + 1);
    let directions = size_of_val(&file.directions.as_ref().unwrap().texels()[..]) as u64;
    let reflectance = file.decoder.parts().reflectance.factors().unwrap().gpu_bytes();
    assert_eq!(file.gpu_bytes() - reflectance - directions, (8 * 4 * 5 + 4) * texels + shadows);
}

#[test]
fn headers_out_of_range_are_rejected() {
    for (offset, word, expected) in [
        (0, 2, "version: found 2, expected 1"),
        (4, 0, "size: found 0, expected 1 to 4096"),
        (8, 1, "polar angles: found 1, expected 2 to 256"),
        (12, 257, "azimuth rows: found 257, expected 4 to 256"),
        (16, 0, "largest angle: found 0, expected above 0, up to π/2 radians"),
        (16, f32::NAN.to_bits(), "largest angle: found NaN, expected above 0, up to π/2 radians"),
        (16, 1.6f32.to_bits(), "largest angle: found 1.6, expected above 0, up to π/2 radians"),
        (20, 3000, "lights: found 3000, expected 0 to 2048"),
        (
            4,
            16,
            "found 4 levels of 32 x 40, Rgba16Float, expected 4 levels of 64 x 80, Rgba16Float, as brdfc.flat-btf.vdim says",
        ),
        (8, 5, "expected 4 levels of 40 x 40, Rgba16Float, as brdfc.flat-btf.vdim says"),
        (20, 4, "brdfc.lights: found 40 bytes, expected 32 bytes"),
    ] {
        let error = refusal(&vdim_file(), |file| set_word(file, KEY, offset, word)).to_string();
        assert!(error.contains(expected), "{error}");
    }
    let both = refusal(&vdim_file(), |file| {
        file.entries.insert("brdfc.flat-btf.layers".to_owned(), vec![0; 24]);
    });
    assert!(both.to_string().contains("expected either brdfc.flat-btf.layers or brdfc.flat-btf.vdim"), "{both}");
    // A map that would be too large for WebGPU.
    let wide = VdimHeader { size: 1024, polar_angles: 9, ..HEADER }.check().unwrap_err().to_string();
    assert!(wide.contains("9216 x 66560, expected at most 8192 on each side"), "{wide}");
    assert!(VdimHeader { size: 512, polar_angles: 16, azimuth_rows: 16, ..HEADER }.check().is_ok());
    let levels = VdimHeader { size: 12, levels: 4, ..HEADER }.check().unwrap_err().to_string();
    assert!(levels.contains("levels: found 4, expected 1 to 3"), "{levels}");
}

#[test]
fn texels_that_break_a_rule_are_rejected() {
    let half = |number: f32| brdfc_formats::container::half::encode(number);
    let bytes = |texel: [f32; 4]| texel.map(half).map(u16::to_le_bytes).concat();
    let (name, nan) = ("flat_btf_vdim", f32::NAN);
    let of_range = "expected a distance of 0 to 1024 and a height of -64 to 64";
    let unit = "expected a unit direction, or 0 with a distance of 0";
    // Column 2 of row 0 is neither a pole nor the sample after one; column 4 is the pole of the next texel; row 4 repeats row 0.
    for (at, texel, expected) in [
        (2, [1.0, 0.0, nan, 0.0], of_range),
        (2, [1.0, 0.0, -0.5, 0.0], of_range),
        (2, [1.0, 0.0, 1025.0, 0.0], of_range),
        (2, [1.0, 0.0, 0.5, nan], of_range),
        (2, [1.0, 0.0, 0.5, 65.0], of_range),
        (2, [nan, 0.0, 0.5, 0.0], unit),
        (2, [0.5, 0.5, 0.5, 0.0], unit),
        (2, [0.0, 0.0, 0.5, 0.0], unit),
        (4, [1.0, 0.0, 0.25, 0.0], "expected a distance of 0 and the direction of the next sample, at the pole"),
        (4 * 32 + 2, [1.0, 0.0, 0.25, 0.0], "expected in the last row of a block, the value of its first row"),
    ] {
        let error = refusal(&vdim_file(), |file| set_texel(file, name, at, &bytes(texel))).to_string();
        let place = format!("vdim texel ({}, {}) of level 0: found [", at % 32, at / 32);
        assert!(error.contains(expected) && error.starts_with(&place), "{error}");
    }
    let reference = refusal(&vdim_file(), |file| {
        set_texel(file, "flat_btf_reference", 3, &[half(nan), half(0.0)].map(u16::to_le_bytes).concat());
    });
    assert!(reference.to_string().starts_with("texel 3 of the part reference: found [NaN"), "{reference}");
}

/// Compact samples: displacements in the frame of the view, times the growth towards the horizon.
#[test]
fn compact_samples_turn_with_the_view_and_grow_with_it() {
    let header = VdimHeader { size: 4, block: 2, polar_angles: 9, azimuth_rows: 17, ..HEADER };
    let texels = 4 * 9 * 17;
    let (ranges, packed) = ([[0.0625, -0.03125]; 8].to_vec(), vec![[0; 2]; texels]);
    let samples = CompactSamples { range: [-0.5, 0.5], ranges, packed, heights: vec![255; 16] };
    let reference = vec![[0.25, 0.0]; 16];
    let map = Vdim::new(header, reference, VdimSamples::Compact(samples)).unwrap();
    for k in 0..200u32 {
        let (polar, azimuth) = (1.6 * f64::from(k) / 200.0, 0.37 * f64::from(k));
        // Minima are 0.0625 and -0.03125, extents too; bytes of 0 are the minima.
        let growth = polar.tan().clamp(0.0, 8.0) + 0.25;
        let growth = if polar > FRAC_PI_2 { 8.25 } else { growth };
        let [along, across] = [0.0625, -0.03125].map(|c| c * growth);
        let expected = [
            0.5 + 0.25 + along * azimuth.cos() - across * azimuth.sin(),
            0.5 + along * azimuth.sin() + across * azimuth.cos(),
        ];
        let ([u, v], height) = map.seen([0.5; 2], view(polar, azimuth), 0.0);
        assert!((f64::from(u) - expected[0]).abs() < 1e-5 && (f64::from(v) - expected[1]).abs() < 1e-5, "{k}: {u} {v}");
        assert!((height - 0.5).abs() < 1e-6, "{k}: {height}");
    }
    // The control: half-way between the bounds the displacement is another.
    let VdimSamples::Compact(samples) = map.samples().clone() else { panic!("compact") };
    let samples = CompactSamples { packed: vec![[128; 2]; texels], ..samples };
    let other = Vdim::new(header, vec![[0.25, 0.0]; 16], VdimSamples::Compact(samples)).unwrap();
    assert!(other.seen([0.5; 2], view(0.7, 0.2), 0.0) != map.seen([0.5; 2], view(0.7, 0.2), 0.0));
}

/// Two bytes per view of a block; bounds, references and heights.
#[test]
fn compact_files_round_trip_and_have_their_bytes() {
    let file = compact_vdim_file();
    for supercompress in [false, true] {
        assert!(FlatBtfFile::from_bytes(&file.to_bytes(supercompress)).unwrap() == file);
    }
    // Levels of 8, 4 and 2 texels; blocks of 2.
    let (texels, blocks) = (64 + 16 + 4, 16 + 4 + 1);
    let [whole, without] = [&file, &vdim_file()].map(|file| {
        let map = match &file.decoder.parts().relief {
            Relief::Vdim(map, _) => map,
            Relief::Layers(_) => panic!("layers"),
        };
        (file.gpu_bytes(), (map.reference_bytes().len() + map.packed_bytes().len()) as u64)
    });
    let ranges_and_heights = whole.0 - whole.1 - (without.0 - without.1);
    assert_eq!(whole.1, 2 * 4 * 5 * blocks + 4 * texels);
    assert_eq!(ranges_and_heights, 8 * blocks + texels);
}

#[test]
fn damaged_compact_samples_are_rejected() {
    let key = "brdfc.flat-btf.compact";
    for (offset, word, expected) in [
        (0, 2, "version: found 2, expected 1"),
        (4, 0, "block: found 0, expected a divisor of the size 8"),
        (4, 3, "block: found 3, expected a divisor of the size 8"),
        (4, 4, "levels: found 3, expected 1 to 2"),
        (4, 1, "expected 3 levels of 32 x 40, Rg8Unorm"),
        (8, f32::NAN.to_bits(), "heights: found [NaN, 0.25], expected -64 to 64, the lower one first"),
        (12, (-0.25f32).to_bits(), "heights: found [-0.25, -0.25]"),
    ] {
        let error = refusal(&compact_vdim_file(), |file| set_word(file, key, offset, word)).to_string();
        assert!(error.contains(expected), "{error}");
    }
    let half = |number: f32| brdfc_formats::container::half::encode(number).to_le_bytes();
    let bounds = refusal(&compact_vdim_file(), |file| {
        set_texel(file, "flat_btf_displacements", 5, &[half(f32::NAN), half(0.0)].concat());
    });
    assert!(bounds.to_string().starts_with("texel 5 of the part ranges: found [NaN"), "{bounds}");
    let seam = refusal(&compact_vdim_file(), |file| set_texel(file, "flat_btf_vdim", 4 * 16 + 2, &[1, 2]));
    assert!(seam.to_string().contains("vdim row 4 of level 0: found other values"), "{seam}");
    let missing = refusal(&compact_vdim_file(), |file| {
        reshape(file, "flat_btf_heights", TexelFormat::R8Unorm, Extent::D2([4; 2]), 1);
    });
    assert!(missing.to_string().contains("part heights: found 1 levels of 4 x 4"), "{missing}");
    let halves = refusal(&compact_vdim_file(), |file| {
        file.entries.remove(key);
    });
    assert!(halves.to_string().contains("Rgba16Float, as brdfc.flat-btf.vdim says"), "{halves}");
}

#[test]
fn parts_that_do_not_match_are_rejected() {
    let map = |lights| indirections(SMALL, lights, 3);
    let error = Relief::sampled(map(4), Some(sampled_shadows(SMALL, 3, 2))).unwrap_err().to_string();
    assert!(error.contains("lights: found 4, expected 5, as the shadows have"), "{error}");
    let relief = Relief::sampled(map(5), Some(sampled_shadows(SMALL, 2, 2))).unwrap();
    let parts = FlatBtfParts::new(relief, factored(SMALL, MATERIALS, 6));
    let error = FlatBtfFile::new(FlatBtfDecoder::new(parts)).unwrap_err().to_string();
    assert!(error.contains("found 2 levels of 4 x 4, expected 3 levels of 4 x 4, as the weights have"), "{error}");
    let shapes = refusal(&vdim_file(), |file| {
        reshape(file, "flat_btf_shadows", TexelFormat::R8Unorm, Extent::D2Array([4, 4, 6]), 3);
    });
    assert!(shapes.to_string().contains("expected 5 layers, one for each light"), "{shapes}");
    let missing = refusal(&vdim_file(), |file| {
        file.entries.remove("brdfc.lights");
    });
    assert!(missing.to_string().contains("brdfc.lights"), "{missing}");
    // The control: layers need none of it.
    let parts = FlatBtfParts::new(layers(SMALL, 3), factored(SMALL, MATERIALS, 6));
    let mut file = brdfc_formats::bindings::PackFile::from_bytes(
        &FlatBtfFile::new(FlatBtfDecoder::new(parts)).unwrap().to_bytes(false),
    )
    .unwrap();
    assert_eq!(image(&mut file, "flat_btf_vdim").bytes.len(), 8);
}
