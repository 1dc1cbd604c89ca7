use super::*;
use brdfc_formats::direction::{cross, dot, normalize, subtract};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

/// A mesh of `(columns + 1) x (rows + 1)` vertices at `place(column, row)` of 0 to 1 each, with duplicated borders.
fn grid(columns: usize, rows: usize, place: impl Fn(f64, f64) -> Vector) -> TriangleMesh {
    let vertex = |column: usize, row: usize| (row * (columns + 1) + column) as u32;
    let mut mesh = TriangleMesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            mesh.positions.push(place(column as f64 / columns as f64, row as f64 / rows as f64));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [vertex(column, row), vertex(column + 1, row)];
            let [d, c] = [vertex(column, row + 1), vertex(column + 1, row + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn flat(n: usize) -> TriangleMesh {
    grid(n, n, |x, y| [x, y, 0.0])
}

/// Hills with period 1 that differ from place to place.
fn hills(x: f64, y: f64) -> f64 {
    0.1 * (TAU * x + 0.3).sin() + 0.07 * (TAU * (y + x)).cos() + 0.02 * (2.0 * TAU * y).sin()
}

fn hilly(n: usize) -> TriangleMesh {
    grid(n, n, |x, y| [x, y, hills(x, y)])
}

fn message(mesh: &TriangleMesh, tile: f64) -> String {
    weld(mesh, tile).unwrap_err().to_string()
}

fn assert_closed(surface: &PeriodicMesh) {
    let partners = topology::partners(&surface.triangles).unwrap();
    assert_eq!(surface.positions.len() + surface.triangles.len(), partners.len() / 2, "Euler characteristic 0");
    assert!((surface.projected_area() - 1.0).abs() < 1e-9);
    assert!(surface.triangles.iter().all(|t| *t == in_first_tile(*t)));
    assert_eq!(surface.normals.len(), surface.positions.len());
    assert_eq!(surface.materials.len(), surface.positions.len());
    assert!(surface.materials.iter().all(|m| (m.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6));
    assert!(surface.positions.iter().all(|p| p[..2].iter().all(|c| (-TOLERANCE..1.0).contains(c))));
}

#[test]
fn a_plate_with_doubled_borders_closes() {
    let (surface, report) = weld(&flat(4), 1.0).unwrap();
    assert_closed(&surface);
    let expected = WeldReport {
        vertices_in: 25,
        triangles_in: 32,
        vertices: 16,
        triangles: 32,
        merged_vertices: 9,
        ..WeldReport::default()
    };
    assert_eq!(report, expected);
    assert!(surface.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
    assert!(surface.materials.iter().all(|m| *m == VertexMaterial::default()));
    assert_eq!(surface.position(surface.triangles[31][1]), [1.0, 1.0, 0.0]);
}

#[test]
fn two_triangles_are_enough() {
    let (surface, report) = weld(&flat(1), 1.0).unwrap();
    assert_closed(&surface);
    assert_eq!((report.vertices, report.triangles, report.merged_vertices), (1, 2, 3));
}

#[test]
fn the_unit_of_the_file_does_not_matter() {
    let (expected, _) = weld(&hilly(6), 1.0).unwrap();
    let mut mesh = hilly(6);
    mesh.positions.iter_mut().flatten().for_each(|c| *c *= 1024.0);
    assert_eq!(weld(&mesh, 1024.0).unwrap().0, expected);
}

#[test]
fn where_the_tile_begins_does_not_matter() {
    let (expected, report) = weld(&hilly(6), 1.0).unwrap();
    let mut mesh = hilly(6);
    mesh.positions.iter_mut().for_each(|p| *p = [p[0] + 0.3, p[1] - 2.7, p[2]]);
    let (shifted, shifted_report) = weld(&mesh, 1.0).unwrap();
    assert_closed(&shifted);
    assert_eq!(report, shifted_report);
    let mut moved = 0;
    for index in 0..expected.triangles.len() {
        let vertices = |surface: &PeriodicMesh| surface.triangles[index].map(|corner| corner.vertex);
        assert_eq!(vertices(&expected), vertices(&shifted));
        let (a, b) = (expected.corners(index), shifted.corners(index));
        for k in 0..3 {
            let (along, other) = (subtract(a[(k + 1) % 3], a[k]), subtract(b[(k + 1) % 3], b[k]));
            assert!((0..3).all(|axis| (along[axis] - other[axis]).abs() < 1e-12), "{along:?} {other:?}");
            moved += usize::from((b[k][0] - a[k][0] - 0.3).abs() > 0.5);
        }
    }
    assert!(moved > 0, "some triangles are in another tile");
    for (a, b) in expected.normals.iter().zip(&shifted.normals) {
        assert!(dot(*a, *b) > 1.0 - 1e-12);
    }
}

#[test]
fn overhangs_may_cross_the_border() {
    for shift in [0.0, 0.5, 0.77] {
        let mesh = grid(24, 6, |u, v| [u + shift + 0.3 * (TAU * u).sin(), v, 0.3 * (TAU * u).cos()]);
        let (surface, report) = weld(&mesh, 1.0).unwrap();
        assert_closed(&surface);
        let down = (0..surface.triangles.len()).filter(|t| {
            let [a, b, c] = surface.corners(*t);
            cross(subtract(b, a), subtract(c, a))[2] < 0.0
        });
        assert!(down.count() > 50);
        assert_eq!(report.turned_triangles, 0);
    }
}

#[test]
fn repairs_are_counted() {
    let (expected, plain) = weld(&hilly(5), 1.0).unwrap();
    let mut mesh = hilly(5);
    // An unused vertex, a duplicate triangle, a duplicate in the next tile, and two degenerate triangles.
    mesh.positions.push([0.5, 0.5, 9.0]);
    let last = mesh.positions.len() as u32;
    let [a, b, c] = mesh.triangles[7];
    let next = [a, b, c].map(|v| mesh.positions[v as usize]).map(|[x, y, z]| [x + 1.0, y - 2.0, z]);
    mesh.positions.extend(next);
    mesh.positions.push([0.123, 0.456, 7.0]);
    mesh.triangles.extend([[b, c, a], [last + 2, last, last + 1], [a, a, b], [last + 3, last + 3, last + 3]]);
    let (surface, report) = weld(&mesh, 1.0).unwrap();
    assert_eq!(surface, expected);
    let added = WeldReport {
        vertices_in: plain.vertices_in + 5,
        triangles_in: plain.triangles_in + 4,
        merged_vertices: plain.merged_vertices + 3,
        unreferenced_vertices: 2,
        degenerate_triangles: 2,
        duplicate_triangles: 2,
        ..plain
    };
    assert_eq!(report, added);
}

#[test]
fn triangles_are_turned_to_the_outside() {
    let (expected, _) = weld(&hilly(5), 1.0).unwrap();
    for turned in [vec![0], vec![3, 8, 9, 40], (0..50).collect(), (1..50).collect()] {
        let mut mesh = hilly(5);
        turned.iter().for_each(|t: &usize| mesh.triangles[*t].swap(0, 1));
        let (surface, report) = weld(&mesh, 1.0).unwrap();
        assert_eq!(report.turned_triangles, turned.len());
        assert_closed(&surface);
        for (a, b) in surface.normals.iter().zip(&expected.normals) {
            assert!(dot(*a, *b) > 1.0 - 1e-12);
        }
    }
}

/// Splits the edge that triangles 0 and 1 of a grid share, on the side of triangle 0 only, and fills the slit.
fn with_slivers(points: &[f64]) -> TriangleMesh {
    let mut mesh = flat(4);
    mesh.positions.iter_mut().for_each(|p| p[2] = hills(p[0], p[1]));
    let [a, b, c] = mesh.triangles[0];
    let (from, to) = (mesh.positions[c as usize], mesh.positions[a as usize]);
    let first = mesh.positions.len() as u32;
    let mut chain = vec![c];
    for (k, t) in points.iter().enumerate() {
        mesh.positions.push([0, 1, 2].map(|axis| from[axis] + t * (to[axis] - from[axis])));
        chain.push(first + k as u32);
    }
    chain.push(a);
    mesh.triangles[0] = [b, chain[0], chain[1]];
    mesh.triangles.extend(chain[1..].windows(2).map(|pair| [b, pair[0], pair[1]]));
    mesh.triangles.extend(chain[1..].windows(2).map(|pair| [pair[1], pair[0], c]));
    mesh
}

#[test]
fn slivers_are_repaired() {
    for points in [[0.5].as_slice(), &[0.2, 0.7], &[0.1, 0.2, 0.3, 0.9]] {
        let (surface, report) = weld(&with_slivers(points), 1.0).unwrap();
        assert_closed(&surface);
        assert_eq!(report.exchanged_edges, points.len(), "{points:?}");
        assert!((0..surface.triangles.len()).all(|t| !sliver::is_flat(surface.corners(t))));
        assert_eq!(report.triangles, 32 + 2 * points.len());
        let (plain, _) = weld(&with_slivers(&[]), 1.0).unwrap();
        let area = |surface: &PeriodicMesh| -> f64 {
            let normal = |t| {
                let [a, b, c] = surface.corners(t);
                cross(subtract(b, a), subtract(c, a))
            };
            (0..surface.triangles.len()).map(|t| dot(normal(t), normalize(normal(t)))).sum()
        };
        assert!((area(&surface) - area(&plain)).abs() < 1e-12, "the surface is the same");
    }
}

#[test]
fn slivers_back_to_back_are_refused() {
    let mut mesh = with_slivers(&[0.5]);
    // Another vertex on the same edge, on the side of triangle 1.
    let [a, c, d] = mesh.triangles[1];
    let (from, to) = (mesh.positions[a as usize], mesh.positions[c as usize]);
    let middle = mesh.positions.len() as u32;
    mesh.positions.push([0, 1, 2].map(|axis| 0.7 * from[axis] + 0.3 * to[axis]));
    mesh.triangles[1] = [a, middle, d];
    mesh.triangles.extend([[middle, c, d], [a, c, middle]]);
    let error = message(&mesh, 1.0);
    assert!(error.starts_with("triangle ") && error.contains(": no area between"), "{error}");
}

#[test]
fn materials_are_shares_of_triangles() {
    let mut mesh = flat(3);
    mesh.materials = ["wool", "silk", "gold"].map(str::to_owned).to_vec();
    mesh.triangle_materials = vec![0; 18];
    mesh.triangle_materials[8] = 1;
    mesh.triangle_materials[9] = 2;
    mesh.colours = (0..16).map(|k| [k as f32 / 16.0, 0.5, 1.0]).collect();
    let (surface, _) = weld(&mesh, 1.0).unwrap();
    let weights = |position: [f64; 2]| {
        let near = |p: &Vector| (p[0] - position[0]).abs() < 1e-9 && (p[1] - position[1]).abs() < 1e-9;
        surface.materials[surface.positions.iter().position(near).unwrap()]
    };
    // Triangles 8 and 9 are the quad from (1/3, 1/3) to (2/3, 2/3).
    let [third, two] = [1.0 / 3.0, 2.0 / 3.0];
    let sixth = 1.0f32 / 6.0;
    assert_eq!(weights([third, third]).weights, [4.0 / 6.0, sixth, sixth, 0.0]);
    assert_eq!(weights([two, third]).weights, [5.0 / 6.0, sixth, 0.0, 0.0]);
    assert_eq!(weights([third, two]).weights, [5.0 / 6.0, 0.0, sixth, 0.0]);
    assert_eq!(weights([0.0, third]).weights, [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(weights([0.0, third]).tint, [4.0 / 16.0, 0.5, 1.0]);
    assert_eq!(weights([0.0, 0.0]).tint, [0.0, 0.5, 1.0], "the first of the vertices that are one");
    mesh.materials.extend(["ink", "dust"].map(str::to_owned));
    assert_eq!(message(&mesh, 1.0), "materials: found 5 (wool, silk, gold, ink, dust), expected at most 4");
    mesh.materials.extend((0..1000).map(|k| k.to_string()));
    assert!(message(&mesh, 1.0).ends_with("dust, 0, 1, 2, 3, 4, 5, 6 and 993 more), expected at most 4"));
}

#[test]
fn tiles_and_meshes_without_size_are_refused() {
    for tile in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(message(&flat(3), tile).contains("expected a finite length above 0"), "{tile}");
    }
    assert!(message(&TriangleMesh::default(), 1.0).contains("triangles: no triangles"));
    let mut mesh = flat(3);
    mesh.triangles[4][1] = 16;
    assert_eq!(message(&mesh, 1.0), "triangle 4: found vertex 16, expected vertices 0 to 15");
    let mut mesh = flat(3);
    mesh.positions[5][2] = 3e6;
    assert_eq!(
        message(&mesh, 1.0),
        "vertex 5 at (0.3333333333333333, 0.3333333333333333, 3000000): found 3e6 tiles from the origin, expected at most 1e6"
    );
    assert!(message(&flat(3), 1e-320).contains("found inf tiles"));
    let error = message(&flat(3), 1e6);
    assert!(error.starts_with("triangles: none of 18 has three distinct corners"), "{error}");
    assert!(error.ends_with("; the mesh spans 1 x 1 and the tile is 1000000; try --tile 1"), "{error}");
}

#[test]
fn holes_and_borders_that_do_not_fit_are_refused() {
    let mut mesh = hilly(4);
    mesh.triangles.remove(10);
    let error = message(&mesh, 1.0);
    assert!(error.contains("edges: 3 edges have one triangle, the first at triangle 3 from "), "{error}");
    assert!(error.ends_with("; the mesh spans 1 x 1 and the tile is 1"), "{error}");

    let error = message(&hilly(4), 2.0);
    assert!(error.contains("16 edges have one triangle"), "{error}");
    assert!(error.ends_with("; the mesh spans 1 x 1 and the tile is 2; try --tile 1"), "{error}");
    let oblong = grid(4, 4, |x, y| [x, 2.0 * y, hills(x, y)]);
    assert!(message(&oblong, 1.5).ends_with("; the mesh spans 1 x 2 and the tile is 1.5"));

    // The right border is higher than the left one.
    let step = grid(4, 4, |x, y| [x, y, hills(x, y) + 1e-3 * x]);
    let error = message(&step, 1.0);
    assert!(error.contains("8 edges have one triangle"), "{error}");
    let within = grid(4, 4, |x, y| [x, y, hills(x, y) + 0.9e-5 * x]);
    assert!(weld(&within, 1.0).is_ok());
}

#[test]
fn fins_are_refused() {
    let mut mesh = hilly(4);
    mesh.positions.push([0.5, 0.5, 2.0]);
    let [a, b, _] = mesh.triangles[12];
    mesh.triangles.push([a, b, 25]);
    let error = message(&mesh, 1.0);
    assert!(error.contains("1 edge has more than two triangles"), "{error}");
    assert!(error.contains("with 3 triangles; expected two triangles at every edge"), "{error}");
    let error = message(&hilly(4), 0.5);
    assert!(error.contains("more than two triangles") && error.contains("try --tile 1"), "{error}");
}

fn add_tetrahedron(mesh: &mut TriangleMesh, [x, y, z]: Vector) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([[x, y, z], [x + 0.1, y, z], [x, y + 0.1, z], [x, y, z + 0.1]]);
    mesh.triangles.extend([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|t| t.map(|v: u32| v + first)));
}

#[test]
fn loose_parts_are_refused() {
    let mut mesh = hilly(4);
    add_tetrahedron(&mut mesh, [0.3, 0.3, 1.0]);
    add_tetrahedron(&mut mesh, [0.6, 0.3, 1.0]);
    let error = message(&mesh, 1.0);
    assert!(error.contains("found 3 disconnected components, the second with triangle 32 at (0.3, 0.3, 1)"), "{error}");
}

#[test]
fn bodies_are_refused() {
    let mut mesh = TriangleMesh::default();
    add_tetrahedron(&mut mesh, [0.3, 0.3, 1.0]);
    let error = message(&mesh, 1.0);
    assert!(error.contains("4 vertices - 6 edges + 4 triangles = 2 (a closed body), expected 0"), "{error}");
}

/// A plate with two quads removed, whose borders are joined.
fn with_handle(order: [usize; 4]) -> TriangleMesh {
    let mut mesh = flat(8);
    let quad = |column: u32, row: u32| {
        let a = row * 9 + column;
        [a, a + 1, a + 10, a + 9]
    };
    let (first, second) = (quad(1, 1), quad(5, 5));
    let (i, j) = (2 * (8 + 1), 2 * (5 * 8 + 5));
    let removed = [i, i + 1, j, j + 1];
    let mut index = 0..;
    mesh.triangles.retain(|_| !removed.contains(&index.next().unwrap()));
    for k in 0..4 {
        let (a, b) = (first[k], first[(k + 1) % 4]);
        let (c, d) = (second[order[k]], second[order[(k + 1) % 4]]);
        mesh.triangles.extend([[a, b, d], [a, d, c]]);
    }
    mesh
}

#[test]
fn handles_are_refused() {
    let error = message(&with_handle([0, 3, 2, 1]), 1.0);
    assert!(error.contains("= -2 (one handle or through hole), expected 0"), "{error}");
}

#[test]
fn surfaces_with_one_side_are_refused() {
    let error = message(&with_handle([0, 1, 2, 3]), 1.0);
    assert!(error.contains("surface: no consistent orientation"), "{error}");
    // A Klein bottle: a figure of eight that turns by half a turn along the tile.
    let klein = grid(12, 16, |u, v| {
        let t = TAU * (v + 0.5 / 16.0);
        let (y, z) = (0.2 * t.sin(), 0.1 * (2.0 * t).sin());
        let (sin, cos) = (PI * u).sin_cos();
        [u, 0.5 + cos * y - sin * z, sin * y + cos * z]
    });
    let error = message(&klein, 1.0);
    assert!(error.contains("surface: no consistent orientation"), "{error}");
}

#[test]
fn parts_that_touch_are_refused() {
    let mut mesh = hilly(8);
    let vertex = |column: usize, row: usize| row * 9 + column;
    mesh.positions[vertex(2, 2)] = mesh.positions[vertex(6, 5)];
    let error = message(&mesh, 1.0);
    assert!(error.starts_with("vertex 20 at (0.75, 0.625, "), "{error}");
    assert!(error.contains("the surface touches itself"), "{error}");
}

#[test]
fn sheets_that_cover_the_tile_more_than_once_are_refused() {
    // No two vertices have the same height.
    let steps = grid(4, 4, |x, y| [x, y, 0.04 * (x % 1.0) + 0.16 * (y % 1.0)]);
    let error = message(&steps, 0.5);
    assert!(error.contains("found a coverage of 4.000 tiles, expected 1 tile"), "{error}");
    assert!(error.contains("try --tile 1"), "{error}");
    // A tube along x covers nothing: the areas that face up and down are equal.
    let tube = grid(6, 8, |u, v| [u, 0.3 * (TAU * v).cos(), 0.3 * (TAU * v).sin()]);
    let error = message(&tube, 1.0);
    assert!(error.contains("found a coverage of 0.000 tiles"), "{error}");
}

#[test]
fn height_maps_are_upright() {
    let heights: Vec<f32> = (0..20).map(|k| k as f32).collect();
    let surface = from_heights(5, 4, &heights, 0.5, -1.0).unwrap();
    assert_closed(&surface);
    // Pixel (3, 0) of the top row is number 3, near y = 1.
    let at = surface.positions.iter().find(|p| p[2] == 0.5 * 3.0 - 1.0).unwrap();
    assert_eq!(*at, [3.5 / 5.0, 1.0 - 0.5 / 4.0, 0.5]);
    let at = surface.positions.iter().find(|p| p[2] == 0.5 * 16.0 - 1.0).unwrap();
    assert_eq!(*at, [1.5 / 5.0, 0.5 / 4.0, 7.0]);
    let level = from_heights(4, 4, &[0.25; 16], 2.0, 0.0).unwrap();
    assert_eq!(level.height_range(), [0.5, 0.5]);
    assert!(level.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
}

#[test]
fn wrong_height_maps_are_refused() {
    let error =
        |width, height, values: &[f32], scale| from_heights(width, height, values, scale, 0.0).unwrap_err().to_string();
    assert!(error(2, 4, &[0.0; 8], 1.0).contains("found 2 x 4 pixels with 8 heights"));
    assert!(error(4, 4, &[0.0; 15], 1.0).contains("one height per pixel"));
    assert!(error(usize::MAX, 4, &[0.0; 15], 1.0).contains("with 15 heights"));
    let mut values = [0.0; 16];
    values[6] = f32::NAN;
    assert!(error(4, 4, &values, 1.0).contains("at pixel (2, 1), expected finite heights"));
    assert!(error(4, 4, &[1.0; 16], f64::INFINITY).contains("at pixel (0, 3)"));
}

proptest! {
    /// Welding does not depend on the order of vertices and triangles, nor on the tile size and the position in it.
    #[test]
    fn displaced_plates_close(
        n in 2usize..7,
        seed in any::<u64>(),
        tile in 1e-3..1e4,
        shift in [-3.0..3.0, -3.0..3.0],
        offsets in prop::collection::vec([-0.07..0.07, -0.07..0.07, -0.3..0.3], 36),
    ) {
        let step = |u: f64| ((u * n as f64).round() as usize) % n;
        let mut mesh = grid(n, n, |u, v| {
            let o: [f64; 3] = offsets[step(v) * n + step(u)];
            [(u + o[0] + shift[0]) * tile, (v + o[1] + shift[1]) * tile, o[2] * tile]
        });
        let mut state = seed;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        for k in (1..mesh.triangles.len()).rev() {
            mesh.triangles.swap(k, random(k + 1));
            mesh.triangles[k].rotate_left(random(3));
        }
        for k in (1..mesh.positions.len()).rev() {
            let other = random(k + 1);
            mesh.positions.swap(k, other);
            let exchanged = |v: u32| match v as usize {
                v if v == k => other as u32,
                v if v == other => k as u32,
                _ => v,
            };
            mesh.triangles.iter_mut().for_each(|t| *t = t.map(exchanged));
        }
        let (surface, report) = weld(&mesh, tile).unwrap();
        assert_closed(&surface);
        prop_assert_eq!((report.vertices, report.triangles), (n * n, 2 * n * n));
        prop_assert_eq!(report.merged_vertices, 2 * n + 1);
    }

    /// For any triangles, the result is a closed surface or an error.
    #[test]
    fn any_mesh_is_answered(
        points in prop::collection::vec([0i32..4, 0i32..4, 0i32..2], 4..12),
        triangles in prop::collection::vec([0u32..12, 0u32..12, 0u32..12], 1..12),
        tile in 1u32..4,
    ) {
        let count = points.len() as u32;
        let mesh = TriangleMesh {
            positions: points.iter().map(|p| p.map(f64::from)).collect(),
            triangles: triangles.iter().map(|t| t.map(|v| v % count)).collect(),
            ..TriangleMesh::default()
        };
        match weld(&mesh, f64::from(tile)) {
            Ok((surface, _)) => assert_closed(&surface),
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}
