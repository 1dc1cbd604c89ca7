//! Reliefs on curved surfaces.

use super::{FINE, FROM_RIGHT, HIGH, LOW, UP, along, apart, unit};
use brdfc_formats::flat_btf::{
    FlatBtfDecoder, FlatBtfParts, LayerMap, MacroSurface, MarchSteps, ReliefPoint, SampledDirections, Sheet,
};
use brdfc_testing::codecs::flat_btf::{BASE, Factors, SMALL, factored, parts};

/// Over a cylinder around the y axis a ray is straight in space. The control: over a plane it ends elsewhere.
#[test]
fn rays_over_a_cylinder_end_where_straight_ones_do() {
    let mut controls = 0;
    for (radius, byte) in [(16.0f32, 0u8), (16.0, 128), (8.0, 230), (-16.0, 100)] {
        let relief = along(8, 1, |_| [byte, 0, 0]);
        let height = f32::from(byte) / 255.0 - 0.5;
        let views = [(0.0f32, 0.0f32), (0.4, 0.0), (0.8, 0.8), (-1.0, 0.0), (0.9, 1.2), (1.0, 2.5)];
        for ((polar, azimuth), drawn) in views.into_iter().flat_map(|view| [(view, 0.0f32), (view, 0.5), (view, -0.5)])
        {
            let surface = MacroSurface { curvature: [1.0 / radius, 0.0, 0.0], height: drawn, ..MacroSurface::PLANE };
            let [x, y, z] = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
            let seen = |surface| {
                let steps = MarchSteps { sight: 200, refine: 8, both: 201 };
                relief.seen([0.25, 0.5], [x, y, z], surface, 0.0, steps)
            };
            let found = seen(surface);
            // The ray starts at the distance R + drawn from the axis and ends at R + height.
            let (from, to) = (radius + drawn, radius + height);
            let across = x * x + z * z;
            let root = (from * from * z * z - across * (from * from - to * to)).sqrt() * radius.signum();
            let length = (from * z - root) / across;
            let expected = [0.25 + radius * (-length * x / (from - length * z)).atan(), 0.5 - length * y];
            let error = apart(found.at, expected);
            assert!(error < 0.02, "{radius} {byte} {polar} {azimuth} {drawn}: {error}");
            assert!((found.height - f32::from(byte) / 255.0).abs() < 1e-3, "{found:?}");
            // Along the line of sight.
            assert!((found.rise + length * z).abs() < 0.02, "{found:?} {length}");
            let on_a_plane = apart(seen(MacroSurface { height: drawn, ..MacroSurface::PLANE }).at, expected);
            controls += usize::from(on_a_plane > 2.0 * error && on_a_plane > 0.02);
        }
    }
    assert!(controls > 15, "{controls}");
}

/// Over a concave surface a ray may start and end below the highest point of the relief.
#[test]
fn steep_rays_over_concave_surfaces_stay_on_their_line() {
    for byte in [60u8, 128, 200] {
        let relief = along(8, 1, |_| [byte, 0, 0]);
        for polar in [1.3f32, 1.4, 1.5] {
            let surface = MacroSurface {
                curvature: [-0.25, 0.0, 0.0],
                height: f32::from(byte) / 255.0 - 0.5,
                ..MacroSurface::PLANE
            };
            let view = [polar.sin(), 0.0, polar.cos()];
            let found = relief.seen([0.25, 0.5], view, surface, 0.0, FINE);
            // It is drawn where it is seen.
            assert!(apart(found.at, [0.25, 0.5]) < 0.02 && found.rise.abs() < 0.02, "{byte} {polar}: {found:?}");
            assert_eq!(relief.lit(&found, UP, view, surface, 0.0, FINE), 1.0, "{byte} {polar}");
        }
    }
}

/// Rays pass a convex surface at its outline, and reach a concave one.
#[test]
fn rays_pass_at_outlines() {
    let relief = along(8, 1, |_| [LOW, 0, 0]);
    let seen = |radius: f32, polar: f32| {
        let surface = MacroSurface { curvature: [1.0 / radius, 0.0, 0.0], height: 0.5, ..MacroSurface::PLANE };
        relief.seen([0.0; 2], [polar.sin(), 0.0, polar.cos()], surface, 0.0, FINE)
    };
    for radius in [20.0f32, 40.0] {
        // The ray that touches the height of the relief, -0.3: R - 0.3 = (R + 0.5) sin θ.
        let polar = ((radius - 0.3) / (radius + 0.5)).asin();
        let [outside, inside] = [polar + 0.05, polar - 0.05];
        assert!(seen(radius, outside).height < 0.0 && seen(radius, inside).height >= 0.0, "{radius}");
        assert!(seen(-radius, outside).height >= 0.0 && seen(1e9, outside).height >= 0.0, "{radius}");
    }
}

/// Light just above the horizon of a convex surface reaches it sooner, over a concave one later.
#[test]
fn curvature_moves_shadows() {
    // Walls half a tile apart.
    let walls = along(32, 1, |column| [if column % 16 == 0 { HIGH } else { 128 }, 0, 0]);
    let reached = |curvature: f32| {
        let surface = MacroSurface { curvature: [curvature, 0.0, 0.0], ..MacroSurface::PLANE };
        let lit = |k: u32| {
            let x = 0.06 + k as f32 / 256.0;
            let point = walls.seen([x, 0.5], UP, MacroSurface::PLANE, 0.0, FINE);
            walls.lit(&point, UP, unit([-1.5, 0.0, 1.0]), surface, 0.0, FINE)
        };
        (0..100).map(lit).sum::<f32>()
    };
    let [convex, plane, concave] = [0.8, 0.0, -0.8].map(reached);
    assert!(convex > plane + 4.0 && plane > concave + 4.0, "{convex} {plane} {concave}");
}

/// On a plane a look is the value; over a curved surface view and light are those of the point that is seen.
#[test]
fn looks_turn_with_the_surface() {
    let layers = along(8, 1, |_| [HIGH, 0, 0]);
    let decoder = FlatBtfDecoder::new(FlatBtfParts { relief: layers.into(), ..parts(SMALL, 1) });
    let [uv, light] = [[0.3, 0.6], [0.2, 0.5]];
    let light = unit([light[0], light[1], 0.8]);
    let plane = decoder.look(uv, 0.0, FROM_RIGHT, MacroSurface::PLANE);
    assert_eq!(plane.shaded(None, light), decoder.shaded(None, uv, 0.0, FROM_RIGHT, light));
    // Three tenths of a tile above the plane, seen at 45 degrees.
    let offset = plane.offset();
    assert!((offset[0] - 0.3).abs() < 1e-4 && offset[1] == 0.0 && (offset[2] - 0.3).abs() < 1e-4, "{offset:?}");
    let convex = MacroSurface { curvature: [0.2, 0.0, 0.0], ..MacroSurface::PLANE };
    let curved = decoder.look(uv, 0.0, FROM_RIGHT, convex);
    assert!(!curved.passes() && (0.1..0.3).contains(&curved.offset()[0]), "{:?}", curved.offset());
    // There the normal leans to the right by about 0.2 x 0.28: light from the right rises above its horizon, light from
    // the left goes below.
    let lit = |surface, light: [f32; 3]| {
        let at = |k: u32| [k as f32 / 40.0, (7 * k) as f32 / 40.0];
        (0..40).filter(|k| decoder.look(at(*k), 0.0, FROM_RIGHT, surface).shaded(None, unit(light)) != [0.0; 3]).count()
    };
    let [below_right, above_left] = [[1.0, 0.0, -0.03], [-1.0, 0.0, 0.03]];
    assert!(lit(convex, below_right) > 0 && lit(MacroSurface::PLANE, below_right) == 0);
    assert!(lit(convex, above_left) == 0 && lit(MacroSurface::PLANE, above_left) > 0);
}

/// On tiles twice as long as wide, a slope along the tangent crosses half as many tiles; mirrored tiles go the other way.
/// The control are square tiles.
#[test]
fn stretched_tiles_are_crossed_more_slowly() {
    let relief = along(64, 1, |column| [(4 * column.abs_diff(32)) as u8 + 64, 0, 0]);
    let seen = |slope: [f32; 2], stretch: [f32; 4]| {
        let surface = MacroSurface { stretch, ..MacroSurface::PLANE };
        relief.seen([0.1, 0.5], unit([slope[0], slope[1], 1.0]), surface, 0.0, FINE)
    };
    for (stretch, [x, y]) in [
        ([0.5, 0.0, 0.0, 2.0], [0.5, 0.0]),
        ([-0.5, 0.0, 0.0, 2.0], [-0.5, 0.0]),
        ([1.0, 0.5, 0.0, 1.0], [1.0, 0.0]),
        ([0.0, -2.0, 0.5, 0.0], [0.0, 0.5]),
    ] {
        let (found, expected) = (seen([1.0, 0.0], stretch), seen([x, y], MacroSurface::SQUARE));
        assert!(
            apart(found.at, expected.at) < 1e-5 && (found.rise - expected.rise).abs() < 1e-5,
            "{found:?} {expected:?}"
        );
        assert!(stretch[0] == 1.0 || apart(found.at, seen([1.0, 0.0], MacroSurface::SQUARE).at) > 0.02, "{stretch:?}");
        // From above, a light likewise.
        let above = relief.seen([0.7, 0.5], UP, MacroSurface::PLANE, 0.0, FINE);
        let lit = |slope: f32, stretch| {
            let surface = MacroSurface { stretch, ..MacroSurface::PLANE };
            relief.lit(&above, UP, unit([slope, 0.0, 1.0]), surface, 0.0, FINE)
        };
        if stretch[1] == 0.0 {
            let reached = (0..40).map(|k| 0.2 * k as f32).filter(|slope| lit(*slope, stretch) > 0.0).count();
            let on_squares = |by: f32| {
                (0..40).map(|k| 0.2 * k as f32).filter(|slope| lit(slope * by, MacroSurface::SQUARE) > 0.0).count()
            };
            assert_eq!(reached, on_squares(x), "{stretch:?}");
            assert!(stretch[0] < 0.0 || x == 0.0 || reached != on_squares(1.0), "the control: {stretch:?} {reached}");
        }
    }
    // A slope of the relief is half as steep along the tangent.
    let layers = along(64, 1, |column| [2 * column.min(63) as u8 + 64, 0, 0]);
    let decoder = FlatBtfDecoder::new(FlatBtfParts { relief: layers.into(), ..parts(SMALL, 1) });
    let normal = decoder.look([0.3, 0.6], 0.0, UP, MacroSurface::PLANE).normal();
    let surface = MacroSurface { stretch: [0.5, 0.0, 0.0, 2.0], ..MacroSurface::PLANE };
    let [x, y, z] = decoder.look([0.3, 0.6], 0.0, UP, surface).normal();
    assert!((x / z - 0.5 * normal[0] / normal[2]).abs() < 1e-5 && (y / z - 2.0 * normal[1] / normal[2]).abs() < 1e-5);
}

/// Rays of sight with few steps end a little inside the solid, from where no light would be seen.
#[test]
fn rays_of_light_start_outside_the_solid() {
    let lit = |layers: &LayerMap, height: f32, sheet| {
        let point = ReliefPoint { at: [0.3, 0.5], height, sheet, rise: 0.0, steps: 1 };
        layers.lit(&point, UP, unit([1.0, 0.2, 1.0]), MacroSurface::PLANE, 0.0, FINE)
    };
    for byte in [255u8, 128, 0] {
        let plateau = along(8, 1, |_| [byte, 0, 0]);
        let height = f32::from(byte) / 255.0;
        assert_eq!([0.03, 0.01, 0.0].map(|below| lit(&plateau, height - below, Sheet::Base)), [1.0; 3], "{byte}");
    }
    let slab = along(8, 3, |_| [10, 200, 100]);
    let [top, base, underside] = [(200.0, Sheet::Top), (10.0, Sheet::Base), (100.0, Sheet::Underside)]
        .map(|(byte, sheet)| (byte / 255.0, sheet));
    assert_eq!(lit(&slab, top.0 - 0.02, top.1), 1.0);
    // Below the slab there is no light.
    assert_eq!([lit(&slab, base.0 - 0.02, base.1), lit(&slab, underside.0 + 0.02, underside.1)], [0.0; 2]);
}

/// The frame along u and v of turned, sheared and mirrored tiles.
#[test]
fn components_are_looked_up_along_the_tiles() {
    let reflectance = factored(SMALL, Factors { groups: 1, ..BASE }, 1);
    let decoder = FlatBtfDecoder::new(FlatBtfParts::new(along(8, 1, |_| [128, 0, 0]), reflectance));
    let directions = SampledDirections::of(decoder.parts()).unwrap();
    assert!(directions.is_some());
    let [uv, light] = [[0.3, 0.6], [0.2, 0.5]];
    let view = unit([0.3, -0.4, 0.8]);
    let light = unit([light[0], light[1], 0.8]);
    let plane = decoder.look(uv, 0.0, view, MacroSurface::PLANE).shaded(directions.as_ref(), light);
    // A quarter turn of the tangent turns both directions back.
    let turned = |[x, y, z]: [f32; 3]| [y, -x, z];
    let surface = MacroSurface { stretch: [0.0, -1.0, 1.0, 0.0], ..MacroSurface::PLANE };
    let found = decoder.look(uv, 0.0, turned(view), surface).shaded(directions.as_ref(), turned(light));
    let other = decoder.look(uv, 0.0, turned(view), MacroSurface::PLANE).shaded(directions.as_ref(), turned(light));
    let apart = |a: [f32; 3]| (0..3).map(|k| (a[k] - plane[k]).abs()).fold(0.0, f32::max);
    assert!(apart(found) < 1e-5 && apart(other) > 1e-3, "{plane:?} {found:?} {other:?}");
}
