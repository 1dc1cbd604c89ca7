//! Flat BTFs: known answers of rays through layers, values behind them, and file round trips.

mod curved;

use brdfc_formats::flat_btf::{
    FlatBtfDecoder, FlatBtfFile, FlatBtfParts, FlatHeader, FlatView, LayerHeader, LayerMap, MacroSurface, MarchSteps,
    ReliefPoint, Sheet, VisibilityMask,
};
use brdfc_testing::codecs::flat_btf::{
    BASE, Factors, SMALL, Sizes, base_file, factored, factored_file, flat_relief, layers, layers_of, materials_file,
    nothing, only, parts, relief, towards,
};
use brdfc_testing::packs::{Numbers, unit_vector};
use proptest::prelude::*;
use std::array::from_fn;

const UP: [f32; 3] = [0.0, 0.0, 1.0];
const DOWN: [f32; 3] = [0.0, 0.0, -1.0];
/// Half a right angle to both sides.
const FROM_LEFT: [f32; 3] = [-0.707_106_77, 0.0, 0.707_106_77];
const FROM_RIGHT: [f32; 3] = [0.707_106_77, 0.0, 0.707_106_77];
/// Byte of the lower of two heights in these tests, a fifth of the range, and of the upper one, four fifths.
const LOW: u8 = 51;
const HIGH: u8 = 204;
const FINE: MarchSteps = MarchSteps { sight: 64, refine: 6, both: 128 };

/// One tile from the lowest to the highest point, half of it below the reference plane.
fn header(size: u32, sheets: u32) -> LayerHeader {
    LayerHeader { size, sheets, levels: 1, heights: [-0.5, 0.5] }
}

/// Layers without displacement whose heights depend on the column.
fn along(size: u32, sheets: u32, heights: impl Fn(u32) -> [u8; 3]) -> LayerMap {
    relief(header(size, sheets), |[column, _]| (heights(column), [[0.0; 2]; 3]))
}

fn unit([x, y, z]: [f32; 3]) -> [f32; 3] {
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

fn apart(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A ray that passes a plane at the height h meets it at `uv + h slope`, by any number of steps.
#[test]
fn a_plane_is_met_where_rays_pass_its_height() {
    let mut numbers = Numbers::new(1);
    for byte in [0, 1, 77, 128, 254, 255] {
        let (share, height) = (f32::from(byte) / 255.0, f32::from(byte) / 255.0 - 0.5);
        let plane = along(8, 1, |_| [byte, 0, 0]);
        for k in 0..300 {
            let uv = [0; 2].map(|_| numbers.between(-3.0, 3.0) as f32);
            let [x, y, z] = unit_vector(&mut numbers);
            let view = unit([x, y, z.abs().max(0.07)]);
            let steps = MarchSteps { sight: k % 20, refine: k % 4, both: k % 7 };
            let found = plane.seen(uv, view, MacroSurface::PLANE, 0.0, steps);
            let expected: [f32; 2] = from_fn(|k| uv[k] + height * view[k] / view[2]);
            assert!(apart(found.at, expected) < 1e-5, "{byte} {uv:?} {view:?}: {found:?} {expected:?}");
            assert!((found.height - share).abs() < 1e-6 && found.sheet == Sheet::Base, "{byte}: {found:?}");
            // The control: a plane at another height is met elsewhere.
            if view[2] < 0.8 && byte > 1 {
                let other = along(8, 1, |_| [0, 0, 0]).seen(uv, view, MacroSurface::PLANE, 0.0, steps);
                assert!(apart(other.at, expected) > 0.1, "{view:?}: {other:?}");
            }
        }
    }
}

#[test]
fn parameters_are_positions_and_displacements() {
    let moved = |[column, row]: [u32; 2]| {
        from_fn(|sheet| [0.125 * sheet as f32 + 0.3125 * column as f32, -0.375 - 0.03125 * (row + sheet as u32) as f32])
    };
    let layers = relief(header(4, 3), |texel| ([LOW, 0, 255], moved(texel.map(|k| k / 2))));
    for (texel, k) in [([0, 0], 0), ([1, 0], 1), ([1, 1], 2)] {
        let sheet = [Sheet::Base, Sheet::Top, Sheet::Underside][k];
        let at = texel.map(|k: u32| (k as f32 + 0.5) / 2.0);
        for tiles in [0.0, 1.0, -2.0] {
            let at = at.map(|c| c + tiles);
            let expected: [f32; 2] = from_fn(|axis| at[axis] + moved(texel)[k][axis]);
            assert!(apart(layers.parameters(at, sheet, 0.0), expected) < 1e-6, "{texel:?} {sheet:?}");
        }
    }
    // Halfway between the last texel of a row and the first of the next tile.
    let [u, v] = layers.parameters([1.0, 0.25], Sheet::Base, 0.0);
    assert!((u - 1.0 - 0.5 * 0.3125).abs() < 1e-6 && (v - 0.25 + 0.375).abs() < 1e-6, "{u} {v}");
    // The decoder wraps them.
    let decoder = FlatBtfDecoder::new(FlatBtfParts { relief: layers.into(), ..parts(Sizes { plane: 4, ..SMALL }, 1) });
    let (_, [u, v]) = decoder.seen([0.75, 0.25], UP, 0.0);
    assert!((u - 0.0625).abs() < 1e-6 && (v - 0.875).abs() < 1e-6, "{u} {v}");
}

/// No light above the horizon is blocked.
#[test]
fn light_reaches_a_plane() {
    let mut numbers = Numbers::new(2);
    for byte in [0, 77, 255] {
        let plane = along(8, 1, |_| [byte, 0, 0]);
        for k in 0..300 {
            let [x, y, z] = unit_vector(&mut numbers);
            let light = if k % 3 == 0 { unit([x, y, 0.0]) } else { [x, y, z.abs()] };
            let steps = MarchSteps::of(plane.header());
            let point = plane.seen([x, y], UP, MacroSurface::PLANE, 0.0, steps);
            assert_eq!(plane.lit(&point, UP, light, MacroSurface::PLANE, 0.0, steps), 1.0, "{byte} {light:?}");
        }
    }
}

#[test]
fn a_slab_hides_and_shadows_the_base() {
    let slab = along(8, 3, |_| [LOW, HIGH, 153]);
    // The underside is above the top: nothing is there.
    let closed = along(8, 3, |_| [LOW, 153, HIGH]);
    let base = ReliefPoint { at: [0.3, 0.4], height: 0.2, sheet: Sheet::Base, rise: 0.0, steps: 0 };
    let underside = ReliefPoint { height: 0.6, sheet: Sheet::Underside, ..base };
    let mut numbers = Numbers::new(3);
    for _ in 0..300 {
        let [x, y, z] = unit_vector(&mut numbers);
        let direction = unit([x, y, z.abs()]);
        let top = slab.seen([x, y], direction, MacroSurface::PLANE, 0.0, FINE);
        assert!(top.sheet == Sheet::Top && (top.height - 0.8).abs() < 1e-5, "{direction:?}: {top:?}");
        let through = closed.seen([x, y], direction, MacroSurface::PLANE, 0.0, FINE);
        assert!(through.sheet == Sheet::Base && (through.height - 0.2).abs() < 1e-5, "{direction:?}: {through:?}");
        let lit =
            |layers: &LayerMap, point, normal| layers.lit(point, normal, direction, MacroSurface::PLANE, 0.0, FINE);
        assert_eq!([lit(&slab, &top, UP), lit(&slab, &base, UP), lit(&slab, &underside, DOWN)], [1.0, 0.0, 0.0]);
        assert_eq!([lit(&closed, &through, UP), lit(&closed, &base, UP)], [1.0, 1.0]);
    }
}

/// A ray passes below the rim of a high slab and meets the wall below its thick part.
#[test]
fn the_underside_is_met_beneath_a_rim() {
    // Columns of a tile: open, a thin slab, a thick one, open.
    let columns = [[0, 102, HIGH], [0, 242, HIGH], [0, 242, 25], [0, 102, HIGH]];
    let layers = along(32, 3, |column| columns[column as usize / 8]);
    // This ray is at the height 0.875 - x.
    let found = layers.seen([0.375, 0.1], FROM_LEFT, MacroSurface::PLANE, 0.0, FINE);
    assert_eq!(found.sheet, Sheet::Underside);
    assert!(apart(found.at, [0.5, 0.1]) < 1.0 / 32.0 && (found.height - 0.375).abs() < 1.0 / 32.0, "{found:?}");
    // From above and from the other side it is hidden.
    for view in [UP, FROM_RIGHT] {
        assert_eq!(layers.seen([0.45, 0.1], view, MacroSurface::PLANE, 0.0, FINE).sheet, Sheet::Top);
    }
    // The same ray without the thick part goes on to the base.
    let thin = along(32, 3, |column| columns[[0, 1, 1, 3][column as usize / 8]]);
    let found = thin.seen([0.375, 0.1], FROM_LEFT, MacroSurface::PLANE, 0.0, FINE);
    assert!(found.sheet == Sheet::Base && found.height < 1e-5, "{found:?}");
}

/// A wall of four columns.
fn wall() -> LayerMap {
    along(32, 1, |column| [if (14..18).contains(&column) { HIGH } else { LOW }, 0, 0])
}

#[test]
fn a_wall_is_met_from_the_side_of_the_eye() {
    let (wall, texel) = (wall(), 1.0 / 32.0);
    // The left side of the wall is at 14 texels, the right one at 18.
    for (view, side) in [(FROM_LEFT, 14.0 * texel), (FROM_RIGHT, 18.0 * texel)] {
        let found = wall.seen([side, 0.6], view, MacroSurface::PLANE, 0.0, FINE);
        assert!(apart(found.at, [side, 0.6]) < texel && (found.height - 0.5).abs() < texel, "{view:?}: {found:?}");
    }
    // The control: from the other side the same points are hidden, and rays meet the top or the other side.
    for (view, side) in [(FROM_RIGHT, 14.0 * texel), (FROM_LEFT, 18.0 * texel)] {
        let found = wall.seen([side, 0.6], view, MacroSurface::PLANE, 0.0, FINE);
        assert!(apart(found.at, [side, 0.6]) > 3.0 * texel, "{view:?}: {found:?}");
    }
}

#[test]
fn a_wall_shadows_the_side_away_from_the_light() {
    let wall = wall();
    let lit = |x: f32, light| {
        let point = wall.seen([x, 0.6], UP, MacroSurface::PLANE, 0.0, FINE);
        assert_eq!(point.at, [x, 0.6]);
        wall.lit(&point, UP, light, MacroSurface::PLANE, 0.0, FINE)
    };
    // The foot on the left, the top, the foot on the right.
    assert_eq!([0.3, 0.5, 0.7].map(|x| lit(x, FROM_RIGHT)), [0.0, 1.0, 1.0]);
    assert_eq!([0.3, 0.5, 0.7].map(|x| lit(x, FROM_LEFT)), [1.0, 1.0, 0.0]);
    // Steeper light and light along the wall reach both sides.
    for light in [unit([0.2, 0.0, 1.0]), unit([0.0, 1.0, 1.0])] {
        assert_eq!([0.3, 0.7].map(|x| lit(x, light)), [1.0; 2], "{light:?}");
    }
    // A side of the wall is lit from its own side only.
    let side = wall.seen([14.0 / 32.0, 0.6], FROM_LEFT, MacroSurface::PLANE, 0.0, FINE);
    assert_eq!(wall.lit(&side, [-1.0, 0.0, 0.0], FROM_LEFT, MacroSurface::PLANE, 0.0, FINE), 1.0);
    assert_eq!(wall.lit(&side, [-1.0, 0.0, 0.0], FROM_RIGHT, MacroSurface::PLANE, 0.0, FINE), 0.0);
}

/// Refined ends are on the sheets that they name.
#[test]
fn ends_of_rays_are_on_the_surface() {
    let layers = layers(Sizes { plane: 32, ..SMALL }, 5);
    let mut numbers = Numbers::new(6);
    let mut sheets = [0; 3];
    let mut off = [0.0f32; 2];
    for _ in 0..2000 {
        let uv = [0; 2].map(|_| numbers.unit() as f32);
        let view = unit_vector(&mut numbers);
        for (largest, refine) in off.iter_mut().zip([0, 12]) {
            let found = layers.seen(uv, view, MacroSurface::PLANE, 0.0, MarchSteps { sight: 200, refine, both: 201 });
            let column = layers.column(found.at, 0.0);
            *largest += (found.height - column[found.sheet as usize]).abs() / 2000.0;
            sheets[found.sheet as usize] += refine.min(1);
        }
    }
    println!("off by {off:?}, sheets {sheets:?}");
    assert!(off[1] < 5e-4 && off[0] > 4.0 * off[1], "{off:?}");
    assert!(sheets[0] > 200 && sheets[1] > 200, "{sheets:?}");
}

/// Rays at and below the horizon, without steps, far from the origin, at levels beyond the ends, and not finite.
#[test]
fn any_query_gives_numbers_in_range() {
    let odd = [0.0, -0.0, 1.0, -1e-9, 1e9, -1e30, f32::MAX, f32::INFINITY, f32::NAN, f32::MIN_POSITIVE];
    for file in [base_file(), materials_file(), factored_file()] {
        for steps in [file.decoder.steps(), MarchSteps { sight: 0, refine: 0, both: 0 }] {
            let decoder = file.decoder.clone().with_steps(steps);
            let samples = |k| if file.directions.is_some() { only(k) } else { nothing(k) };
            for u in odd {
                for v in odd {
                    for z in odd {
                        let (point, found) = decoder.seen([u, v], [v, u, z], z);
                        assert!(!(point.height < 0.0 || point.height > 1.0), "{u} {v} {z}: {point:?}");
                        assert!(found.iter().all(|c| (0.0..1.0).contains(c)), "{u} {v} {z}: {found:?}");
                        let [view, light] = [2, 1].map(|k| towards(samples(k)));
                        let value = decoder.value([u, v], z, view, light);
                        assert!(value.iter().all(|c| (0.0..100.0).contains(c)), "{value:?}");
                    }
                }
            }
        }
    }
    let layers = layers(SMALL, 4);
    let mut numbers = Numbers::new(7);
    for _ in 0..500 {
        let uv = [0; 2].map(|_| (numbers.bits() % 64) as f32 / 64.0);
        let azimuth = numbers.between(0.0, 6.3) as f32;
        let horizon = [azimuth.cos(), azimuth.sin(), 0.0];
        let found = layers.seen(uv, horizon, MacroSurface::PLANE, 0.0, FINE);
        assert!(found.at.iter().all(|c| c.abs() < 8.0) && (0.0..=1.0).contains(&found.height), "{found:?}");
        // Lower rays are raised to the same one.
        assert_eq!(layers.seen(uv, [horizon[0], horizon[1], -0.5], MacroSurface::PLANE, 0.0, FINE), found);
        let lit = |light| layers.lit(&found, UP, light, MacroSurface::PLANE, 0.0, FINE);
        assert_eq!(lit(horizon), lit([horizon[0], horizon[1], 0.05]));
        // A single step is the minimum.
        let few = |count| MarchSteps { sight: count, refine: 0, both: 2 * count };
        assert_eq!(
            layers.seen(uv, horizon, MacroSurface::PLANE, 0.0, few(0)),
            layers.seen(uv, horizon, MacroSurface::PLANE, 0.0, few(1))
        );
        assert_eq!(
            layers.lit(&found, UP, FROM_LEFT, MacroSurface::PLANE, 0.0, few(0)).to_bits(),
            layers.lit(&found, UP, FROM_LEFT, MacroSurface::PLANE, 0.0, few(1)).to_bits()
        );
        // The tile repeats.
        let there = layers.seen([uv[0] + 256.0, uv[1] - 64.0], UP, MacroSurface::PLANE, 0.0, FINE);
        let here = layers.seen(uv, UP, MacroSurface::PLANE, 0.0, FINE);
        assert_eq!((there.at, there.height), ([uv[0] + 256.0, uv[1] - 64.0], here.height));
    }
}

#[test]
fn levels_of_detail_are_blended_and_clamped() {
    let layers = layers(SMALL, 8);
    for at in [[0.1, 0.7], [0.96, 0.02], [-3.3, 5.6]] {
        let [fine, coarse, between] = [1.0, 2.0, 1.25].map(|detail| layers.column(at, detail));
        for k in 0..3 {
            assert!((between[k] - 0.75 * fine[k] - 0.25 * coarse[k]).abs() < 1e-6, "{at:?}: {between:?}");
        }
        assert_ne!(fine, coarse);
        for (detail, clamped) in [(-1.0, 0.0), (f32::NAN, 0.0), (3.5, 3.0), (1e9, 3.0)] {
            assert_eq!(layers.column(at, detail), layers.column(at, clamped), "{detail}");
            let seen = |detail| layers.seen(at, FROM_LEFT, MacroSurface::PLANE, detail, FINE);
            assert_eq!(seen(detail), seen(clamped), "{detail}");
            let parameters = |detail| layers.parameters(at, Sheet::Top, detail);
            assert_eq!(parameters(detail), parameters(clamped), "{detail}");
        }
        // The last level is one texel.
        assert_eq!(layers.column(at, 3.0), layers.column([0.5; 2], 3.0));
    }
    // The level of detail refers to the texels of the flat BTF, of which there are half as many.
    let decoder = FlatBtfDecoder::new(FlatBtfParts { relief: layers.clone().into(), ..parts(SMALL, 8) });
    assert_eq!(decoder.finer(), 1.0);
    let (found, _) = decoder.seen([0.1, 0.7], FROM_LEFT, 0.5);
    assert_eq!(found, layers.seen([0.1, 0.7], FROM_LEFT, MacroSurface::PLANE, 1.5, decoder.steps()));
    assert_ne!(found, decoder.seen([0.1, 0.7], FROM_LEFT, 1.0).0);
}

/// The filter wraps around the border of the tile.
#[test]
fn filtering_is_periodic() {
    let layers = along(8, 1, |column| [20 * column as u8, 0, 0]);
    for (x, byte) in
        [(0.0, 70.0), (1.0, 70.0), (-5.0, 70.0), (0.0625, 0.0), (0.9375, 140.0), (0.03125, 35.0), (0.5, 70.0)]
    {
        let [base, ..] = layers.column([x, 0.3], 0.0);
        assert!((255.0 * base - byte).abs() < 1e-3, "{x}: {base}");
    }
}

/// A value is that of the flat BTF at the parameters of the visible point. Rays of light multiply it by 0 or 1; with a
/// residual, points in shadow keep something. No light reaches points that are turned away from it.
#[test]
fn values_are_those_behind_a_ray_of_sight() {
    let decoder = |residual: u32| {
        let factors = Factors { groups: 2, wide_groups: 1, residual, ..BASE };
        let layers = layers(Sizes { plane: 32, ..SMALL }, 9);
        FlatBtfDecoder::new(FlatBtfParts::new(layers, factored(SMALL, factors, 3)))
    };
    let (plain, with) = (decoder(0), decoder(2));
    let mut numbers = Numbers::new(10);
    let (mut blocked, mut reached, mut away) = (0, 0, 0);
    for k in 0..500 {
        let uv = [0; 2].map(|_| numbers.between(-1.0, 1.0) as f32);
        let level = numbers.between(-1.0, 3.0) as f32;
        let (view, light) = (towards(only(k % 3)), towards(only(k % 5)));
        let (point, parameters) = with.seen(uv, view.direction, level);
        let texel = with.parts().reflectance.factors().unwrap().filtered(parameters, level);
        let value = texel.blended(view, light);
        let (layers, steps) = (layers_of(with.parts()), with.steps());
        let (normal, to) = (texel.base().normal, light.direction);
        let faces = normal[0] * to[0] + normal[1] * to[1] + normal[2] * to[2] > 0.0;
        let lit = if faces && value != [0.0; 3] {
            layers.lit(&point, normal, to, MacroSurface::PLANE, level + with.finer(), steps)
        } else {
            away += 1;
            0.0
        };
        assert_eq!(with.value(uv, level, view, light), texel.shadowed(value, light.samples, lit));
        let texel = plain.parts().reflectance.factors().unwrap().filtered(parameters, level);
        let value = texel.blended(view, light).map(|channel| channel * lit);
        assert_eq!(plain.value(uv, level, view, light), value);
        *if lit > 0.0 { &mut reached } else { &mut blocked } += 1;
    }
    assert!(blocked > away + 20 && reached > 100 && away > 20, "{blocked} {reached} {away}");
    // Layers of one height shadow nothing.
    let (layers, reflectance) = (flat_relief(SMALL), factored(SMALL, BASE, 3));
    let flat = FlatBtfDecoder::new(FlatBtfParts::new(layers, reflectance));
    let (view, light) = (towards(nothing(1)), towards(nothing(4)));
    let (_, parameters) = flat.seen([0.3, 0.6], view.direction, 0.5);
    let value = flat.parts().reflectance.factors().unwrap().filtered(parameters, 0.5).blended(view, light);
    assert!(flat.value([0.3, 0.6], 0.5, view, light) == value && value[0] > 0.0, "{value:?}");
}

#[test]
fn steps_may_be_replaced() {
    let decoder = FlatBtfDecoder::new(parts(Sizes { plane: 32, ..SMALL }, 4));
    assert_eq!(decoder.steps(), MarchSteps::of(layers_of(decoder.parts()).header()));
    let fine = decoder.clone().with_steps(FINE);
    assert_eq!((fine.steps(), fine.parts()), (FINE, decoder.parts()));
    let differ = |k: u32| {
        let uv = [0.01 * k as f32, 0.3];
        decoder.seen(uv, FROM_LEFT, 0.0) != fine.seen(uv, FROM_LEFT, 0.0)
    };
    assert!((0..100).filter(|k| differ(*k)).count() > 30);
}

/// The reported memory is that of the stored images.
#[test]
fn graphics_memory_is_the_sum_of_the_texels() {
    for file in [base_file(), materials_file(), factored_file()] {
        let (layers, reflectance) =
            (layers_of(file.decoder.parts()), file.decoder.parts().reflectance.factors().unwrap());
        let of_layers = layers.height_bytes().len() + layers.displacement_bytes().len();
        let directions = file.directions.as_ref().map_or(0, |directions| size_of_val(&directions.texels()[..]));
        assert_eq!(file.gpu_bytes(), (of_layers + directions) as u64 + reflectance.gpu_bytes());
    }
    // 8 x 8, 4 x 4, 2 x 2 and 1 x 1 texels of a byte, or four; from 4 x 4 on two halves for each sheet.
    let sizes = |file: FlatBtfFile| {
        let layers = layers_of(file.decoder.parts());
        [layers.height_bytes().len(), layers.displacement_bytes().len()]
    };
    assert_eq!(sizes(base_file()), [85, 4 * 21]);
    assert_eq!(sizes(factored_file()), [4 * 85, 3 * 4 * 21]);
}

fn sizes() -> impl Strategy<Value = Sizes> {
    (1u32..6, 0u32..4, any::<bool>(), 1u32..5, 1u32..7).prop_map(|(flat, octaves, overhangs, views, lights)| Sizes {
        flat,
        plane: 1 << octaves,
        sheets: if overhangs { 3 } else { 1 },
        views,
        lights,
    })
}

proptest! {
    #[test]
    fn files_round_trip(sizes in sizes(), seed in 0u64..1000, groups in 0u32..3, materials in 0u32..3, supercompress: bool, report in ".*") {
        let residual = if groups == 2 { sizes.flat } else { 0 };
        let materials = if groups == 0 { materials } else { 0 };
        let factors = Factors { levels: 1, groups, wide_groups: groups / 2, residual, materials };
        let layers = layers(sizes, seed);
        let parts = FlatBtfParts::new(layers, factored(sizes, factors, seed));
        let file = FlatBtfFile { report, ..FlatBtfFile::new(FlatBtfDecoder::new(parts)).unwrap() };
        prop_assert_eq!(file.directions.is_some(), groups > 0);
        prop_assert_eq!(FlatBtfFile::from_bytes(&file.to_bytes(supercompress)).unwrap(), file);
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
