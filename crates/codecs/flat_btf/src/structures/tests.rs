//! Properties common to all structures, and those that distinguish them.

use super::relief::Relief;
use super::*;
use crate::mesh::Corner;
use brdfc_core::Tally;
use brdfc_core::address::parse_synth;
use brdfc_core::analytic::ParameterKind;
use brdfc_formats::direction::{DirectionPair, Vector, cross, dot, from_polar};

fn mesh(text: &str) -> PeriodicMesh {
    Structure::parse(text).unwrap().mesh()
}

fn surface(text: &str) -> Box<dyn Relief> {
    let structure = Structure::parse(text).unwrap();
    (structure.info.build)(&structure.values)
}

/// Twice the area of a triangle, as a vector along its normal.
fn area_vector([a, b, c]: [Vector; 3]) -> Vector {
    cross(subtract(b, a), subtract(c, a))
}

/// Every structure, once with defaults and once with other parameters.
const SOME: [&str; 8] = [
    "button",
    "button?count=3&overhang=0.6&seed=9",
    "folds",
    "folds?count=1&lean=1.5&seed=4",
    "knit",
    "knit?count=3&irregularity=1&seed=5",
    "sponge",
    "sponge?count=2&porosity=1&seed=6",
];

#[test]
fn surfaces_repeat_after_a_tile() {
    for text in SOME {
        let surface = surface(text);
        for k in 0..200 {
            let [u, v] = [1, 2].map(|axis| noise::lattice(k, axis, 77));
            let (point, material) = surface.line(v)(u);
            for tile in [[1.0, 0.0], [0.0, 1.0], [-2.0, 3.0]] {
                let (other, other_material) = surface.line(v + tile[1])(u + tile[0]);
                let moved = subtract(other, point);
                let error = (moved[0] - tile[0]).abs() + (moved[1] - tile[1]).abs() + moved[2].abs();
                assert!(error < 1e-9, "{text} at {u}, {v}: {moved:?} after {tile:?}");
                let change = (0..3).map(|c| (material.tint[c] - other_material.tint[c]).abs()).fold(0.0, f32::max);
                assert!(change < 1e-4, "{text} at {u}, {v}: {material:?}, {other_material:?}");
            }
        }
    }
}

#[test]
fn the_projected_area_is_one_tile_and_the_mean_height_is_zero() {
    for text in SOME {
        let mesh = mesh(&format!("{text}{}resolution=64", if text.contains('?') { '&' } else { '?' }));
        let area: f64 = (0..mesh.triangles.len()).map(|k| 0.5 * area_vector(mesh.corners(k))[2]).sum();
        assert!((area - 1.0).abs() < 1e-12, "{text}: {area}");
        let (mean, [low, high]) = (mean_height(&mesh), mesh.height_range());
        assert!(mean.abs() < 1e-12 && low < -0.01 && high > 0.01 && high - low < 0.5, "{text}: {low} {mean} {high}");
    }
    for text in ["button", "folds", "knit", "sponge"] {
        let [low, high] = mesh(text).height_range();
        assert!((0.05..0.2).contains(&(high - low)), "{text}: {low} to {high}");
    }
}

/// Share of the surface, by area, whose triangles have `n.z` below a limit.
fn share_below(mesh: &PeriodicMesh, limit: f64) -> f64 {
    let (mut below, mut all) = (0.0, 0.0);
    for k in 0..mesh.triangles.len() {
        let normal = area_vector(mesh.corners(k));
        let area = dot(normal, normal).sqrt();
        all += area;
        below += if normal[2] < limit * area { area } else { 0.0 };
    }
    below / all
}

#[test]
fn buttons_and_folds_overhang_and_the_others_do_not() {
    for text in ["button", "button?overhang=0.15", "folds", "folds?count=5&seed=3"] {
        let share = share_below(&mesh(text), -0.2);
        assert!(share > 0.01, "{text}: {share}");
    }
    for text in ["knit", "sponge", "folds?lean=0"] {
        let mesh = mesh(text);
        let (down, steep) = (share_below(&mesh, 1e-6), share_below(&mesh, 0.5));
        assert!(down == 0.0 && steep < 0.25, "{text}: {down}, {steep}");
    }
}

#[test]
fn nothing_meets_itself() {
    for text in [
        "button?resolution=64",
        "button?resolution=96&count=3&overhang=0.6&seed=2",
        "button?resolution=64&height=0.4",
        "folds?resolution=64",
        "folds?resolution=96&count=4&lean=1.5&seed=8",
        "folds?resolution=48&count=1&lean=1.5",
        "folds?resolution=64&height=0.5&seed=12",
    ] {
        assert_eq!(meeting(&mesh(text)), None, "{text}");
    }
    // The negative control: a curve with loops meets itself.
    let n = 48;
    let point = |k: usize| {
        let [u, v] = [k % n, k / n].map(|k| k as f64 / n as f64);
        let angle = std::f64::consts::TAU * u;
        [u - 0.3 * angle.sin(), v, 0.1 * angle.cos()]
    };
    let looped = PeriodicMesh::from_grid(n, n, (0..n * n).map(point).collect(), vec![Default::default(); n * n]);
    assert!(meeting(&looped).is_some());
}

/// Finds two triangles without a common corner such that an edge of one passes through the other.
fn meeting(mesh: &PeriodicMesh) -> Option<[usize; 2]> {
    // Cells of the tile, each with the triangles over it and their offsets relative to the tile.
    const CELLS: i64 = 40;
    let mut cells = vec![Vec::new(); (CELLS * CELLS) as usize];
    for k in 0..mesh.triangles.len() {
        let corners = mesh.corners(k);
        let range = |axis: usize| {
            let cell = |x: f64| (x * CELLS as f64).floor() as i64;
            let x = corners.map(|corner| corner[axis]);
            cell(x[0].min(x[1]).min(x[2]))..=cell(x[0].max(x[1]).max(x[2]))
        };
        for row in range(1) {
            for column in range(0) {
                let tile = [column.div_euclid(CELLS), row.div_euclid(CELLS)].map(|tile| tile as i32);
                cells[(row.rem_euclid(CELLS) * CELLS + column.rem_euclid(CELLS)) as usize].push((k, tile));
            }
        }
    }
    let place = |(k, tile): (usize, [i32; 2])| {
        mesh.triangles[k].map(|c| Corner { vertex: c.vertex, tile: [c.tile[0] - tile[0], c.tile[1] - tile[1]] })
    };
    for cell in &cells {
        for (at, first) in cell.iter().enumerate() {
            for second in &cell[at + 1..] {
                let (a, b) = (place(*first), place(*second));
                if a.iter().any(|corner| b.contains(corner)) {
                    continue;
                }
                let (p, q) = (a.map(|c| mesh.position(c)), b.map(|c| mesh.position(c)));
                if (0..3).any(|k| pierces(p[k], p[(k + 1) % 3], q) || pierces(q[k], q[(k + 1) % 3], p)) {
                    return Some([first.0, second.0]);
                }
            }
        }
    }
    None
}

/// Returns true if a segment passes through a triangle.
fn pierces(start: Vector, end: Vector, triangle: [Vector; 3]) -> bool {
    let volume =
        |p: Vector, q: Vector, r: Vector, s: Vector| dot(cross(subtract(q, p), subtract(r, p)), subtract(s, p));
    let [a, b, c] = triangle;
    let (before, behind) = (volume(a, b, c, start), volume(a, b, c, end));
    let sides = [volume(start, end, a, b), volume(start, end, b, c), volume(start, end, c, a)];
    before * behind < 0.0 && (sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0))
}

#[test]
fn the_same_twice_and_seeds_differ() {
    for name in ["button", "folds", "knit", "sponge"] {
        let of_seed = |seed: u32| mesh(&format!("{name}?resolution=48&seed={seed}"));
        assert_eq!(of_seed(3), of_seed(3), "{name}");
        let (one, other) = (of_seed(3), of_seed(4));
        let moved = one.positions.iter().zip(&other.positions).filter(|(a, b)| (a[2] - b[2]).abs() > 1e-4).count();
        assert!(moved > one.positions.len() / 10, "{name}: {moved}");
    }
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| mesh("knit?resolution=40")), mesh("knit?resolution=40"));
}

#[test]
fn without_height_there_is_a_plane() {
    for name in ["button", "folds", "knit", "sponge"] {
        let flat = mesh(&format!("{name}?resolution=32&height=0"));
        assert_eq!(flat.height_range(), [0.0, 0.0], "{name}");
        for (k, (point, normal)) in flat.positions.iter().zip(&flat.normals).enumerate() {
            assert_eq!(*normal, [0.0, 0.0, 1.0], "{name}");
            assert_eq!(*point, [(k % 32) as f64 / 32.0, (k / 32) as f64 / 32.0, 0.0], "{name}");
        }
        let [low, high] = mesh(&format!("{name}?resolution=64&height=1")).height_range();
        let [half_low, half_high] = mesh(&format!("{name}?resolution=64&height=0.5")).height_range();
        let ratio = (half_high - half_low) / (high - low);
        assert!((ratio - 0.5).abs() < 1e-9, "{name}: {ratio}");
    }
}

#[test]
fn materials_are_shares_and_vary() {
    for info in STRUCTURES {
        let mesh = mesh(&format!("{}?resolution=96", info.name));
        let (mut weight_range, mut tint_range) = ([1.0f32, 0.0], [1.0f32, 0.0]);
        let widen = |range: &mut [f32; 2], x: f32| *range = [range[0].min(x), range[1].max(x)];
        for material in &mesh.materials {
            let sum: f32 = material.weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-6 && material.weights.iter().all(|w| *w >= 0.0), "{material:?}");
            assert!(material.weights[info.materials.len()..].iter().all(|w| *w == 0.0), "{material:?}");
            assert!(material.tint.iter().all(|t| (0.0..=1.0).contains(t)), "{material:?}");
            widen(&mut weight_range, material.weights[0]);
            widen(&mut tint_range, material.tint[1]);
        }
        let blends = weight_range[1] - weight_range[0] > 0.3;
        assert_eq!(blends, info.materials.len() > 1, "{}: {weight_range:?}", info.name);
        assert!(tint_range[1] - tint_range[0] > 0.15, "{}: {tint_range:?}", info.name);
    }
}

#[test]
fn materials_reflect_less_than_they_receive() {
    for address in STRUCTURES.iter().flat_map(|info| info.materials) {
        let source = parse_synth(address).unwrap();
        for incidence in [0.0, 0.8, 1.3] {
            let incoming = from_polar(incidence, 0.0);
            let mut albedo = [0.0; 3];
            const N: usize = 64;
            for k in 0..N * N {
                // Cosine-weighted directions: the albedo is the mean of f π.
                let [a, b] = [k % N, k / N].map(|k| (k as f64 + 0.5) / N as f64);
                let outgoing = from_polar(a.sqrt().asin(), std::f64::consts::TAU * b);
                let value = source.eval(DirectionPair::new(incoming, outgoing), &mut Tally::default());
                (0..3).for_each(|c| albedo[c] += std::f64::consts::PI * value[c] / (N * N) as f64);
            }
            assert!(albedo.iter().all(|a| *a > 0.01 && *a < 1.0), "{address} at {incidence}: {albedo:?}");
        }
    }
}

#[test]
fn addresses_are_parsed_and_errors_name_the_expected_values() {
    let canonical = |text: &str| Structure::parse(text).unwrap().canonical();
    assert_eq!(canonical("button"), "synth:button?resolution=192&height=1&seed=1&count=2&overhang=0.35");
    assert_eq!(
        canonical("sponge?seed=7&height=5e-1"),
        "synth:sponge?resolution=192&height=0.5&seed=7&count=5&porosity=0.7"
    );
    for text in SOME {
        let structure = Structure::parse(text).unwrap();
        let address = structure.canonical();
        assert_eq!(Structure::parse(address.strip_prefix("synth:").unwrap()), Ok(structure));
    }
    for (text, expected) in [
        ("", "structure: found \"\", expected button, folds, knit or sponge"),
        ("buton", "structure: found \"buton\", expected button, folds, knit or sponge; did you mean button?"),
        ("knit?", "parameter of knit: found \"\", expected name=value"),
        (
            "folds?lane=1",
            "parameter of folds: found \"lane\", expected resolution, height, seed, count or lean; did you mean lean?",
        ),
        ("folds?lean=2", "lean of folds: found 2, expected 0 to 1.5"),
        ("folds?lean=1&lean=1", "lean of folds: repeated; expected one value"),
        ("sponge?resolution=15", "resolution of sponge: found 15, expected a whole number, 16 to 1024"),
        ("sponge?resolution=16.5", "resolution of sponge: found 16.5, expected a whole number, 16 to 1024"),
        ("sponge?seed=-1", "seed of sponge: found -1, expected a whole number, 0 to 999999"),
        ("button?height=NaN", "height of button: found NaN, expected 0 to 2"),
        ("button?height=1,1,1", "height of button: found 1,1,1, expected one number"),
    ] {
        assert_eq!(Structure::parse(text).unwrap_err().to_string(), expected);
    }
}

#[test]
fn the_specification_lists_every_parameter() {
    let page = include_str!("../../../../../docs/synth.md");
    let help = describe_structures();
    for info in STRUCTURES {
        let section = page.split("\n### ").find(|section| section.starts_with(info.name)).unwrap();
        let common = page.split("\n## Meso-structures\n").nth(1).unwrap().split("\n### ").next().unwrap();
        assert!(help.contains(info.meaning), "{help}");
        assert!(info.materials.iter().all(|material| section.contains(material)), "{}", info.name);
        for (k, p) in info.parameters.iter().enumerate() {
            let kind = if p.kind == ParameterKind::Integer { "whole number" } else { "number" };
            let row = format!("| {} | {kind} | {} to {} | {} |", p.name, p.minimum, p.maximum, p.default);
            assert!(if k < 3 { common } else { section }.contains(&row), "{}: {row}", info.name);
            assert!((p.minimum..=p.maximum).contains(&p.default));
        }
        assert_eq!(info.parameters[0].name, "resolution");
        assert_eq!(info.parameters[1].name, "height");
        assert_eq!(info.parameters[2].name, "seed");
    }
}
