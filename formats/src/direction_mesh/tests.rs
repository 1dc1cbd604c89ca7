use super::*;
use crate::direction::{Vector, from_polar};
use proptest::prelude::*;

fn mesh(set: &DirectionSet) -> DirectionMesh {
    DirectionMesh::new(set).unwrap()
}

fn list(angles: &[[f64; 2]]) -> DirectionSet {
    DirectionSet::new("test", angles.to_vec()).unwrap()
}

fn single(d: Vector) -> [f32; 3] {
    d.map(|c| c as f32)
}

fn at(theta: f64, phi: f64) -> [f32; 3] {
    single(from_polar(theta.to_radians(), phi.to_radians()))
}

/// Weight of each direction of the set.
fn spread(mesh: &DirectionMesh, count: usize, direction: [f32; 3]) -> Vec<f64> {
    let (indices, weights) = mesh.weights(direction);
    let mut all = vec![0.0; count];
    for (index, weight) in indices.into_iter().zip(weights) {
        all[index as usize] += f64::from(weight);
    }
    all
}

fn points(set: &DirectionSet) -> Vec<[f64; 2]> {
    set.directions().iter().map(|d| paraboloid(single(*d)).map(f64::from)).collect()
}

/// The same mesh with one cell that lists everything.
fn without_grid(mesh: &DirectionMesh) -> DirectionMesh {
    let [grid, directions, triangles, candidates] = [0, 1, 2, 3].map(|k| mesh.words[k]);
    let rest = HEADER_WORDS + (grid * grid) as usize + 1 + candidates as usize;
    let mut words = vec![1, directions, triangles, triangles, 0, triangles];
    words.extend(0..triangles);
    words.extend(&mesh.words[rest..]);
    DirectionMesh { words }
}

fn sets() -> Vec<DirectionSet> {
    vec![
        DirectionSet::ubo2003(),
        DirectionSet::ubo2014(),
        DirectionSet::grid(5, 7, 85.0).unwrap(),
        list(&[[0.0, 0.0], [60.0, 0.0], [60.0, 90.0], [60.0, 180.0], [60.0, 270.0]]),
        list(&[[20.0, 10.0], [70.0, 30.0], [50.0, 200.0]]),
        list(&[[30.0, 20.0], [10.0, 200.0], [80.0, 20.0]]),
        list(&[[30.0, 20.0], [10.0, 100.0]]),
        list(&[[30.0, 20.0]]),
    ]
}

#[test]
fn known_answers() {
    let set = list(&[[0.0, 0.0], [60.0, 0.0], [60.0, 90.0], [60.0, 180.0], [60.0, 270.0]]);
    let mesh = mesh(&set);
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]);
    let close = |direction, expected: [f64; 5]| {
        let found = spread(&mesh, 5, direction);
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
    };
    let share = 15f64.to_radians().tan() / 30f64.to_radians().tan();
    close(at(30.0, 0.0), [1.0 - share, share, 0.0, 0.0, 0.0]);
    // On the diagonal both coordinates are the same.
    let half = share / 2f64.sqrt();
    close(at(30.0, 45.0), [1.0 - 2.0 * half, half, half, 0.0, 0.0]);
    // Beyond the hull: the middle of an edge, and a corner.
    close(at(85.0, 135.0), [0.0, 0.0, 0.5, 0.5, 0.0]);
    close(at(85.0, 180.0), [0.0, 0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn samples_have_weight_one() {
    for set in sets() {
        let mesh = mesh(&set);
        for (index, direction) in set.directions().into_iter().enumerate() {
            let all = spread(&mesh, set.len(), single(direction));
            assert!(all.iter().enumerate().all(|(k, w)| *w == f64::from(u8::from(k == index))), "{} {all:?}", set.name);
        }
    }
}

/// The coordinates themselves, anywhere inside the outer ring.
#[test]
fn linear_functions_are_reproduced() {
    for set in [DirectionSet::ubo2003(), DirectionSet::ubo2014()] {
        let (mesh, points) = (mesh(&set), points(&set));
        let mut most = 0.0f64;
        for k in 0..20_000 {
            let direction = at(f64::from(k) * 74.0 / 20_000.0, f64::from(k) * 137.508);
            let expected = paraboloid(direction).map(f64::from);
            let all = spread(&mesh, set.len(), direction);
            for axis in 0..2 {
                let found: f64 = all.iter().zip(&points).map(|(w, p)| w * p[axis]).sum();
                most = most.max((found - expected[axis]).abs());
            }
            assert_eq!(all.iter().filter(|w| **w > 0.0).count().clamp(1, 3), all.iter().filter(|w| **w != 0.0).count());
        }
        assert!(most < 3e-7, "{}: {most}", set.name);
    }
}

#[test]
fn sets_in_line_are_blended_along_it() {
    let one = mesh(&list(&[[30.0, 20.0]]));
    assert_eq!(one.weights(at(80.0, 300.0)), ([0; 3], [1.0, 0.0, 0.0]));
    let set = list(&[[40.0, 0.0], [10.0, 180.0], [80.0, 0.0]]);
    let mesh = mesh(&set);
    assert!(mesh.triangles().is_empty());
    let tangent = |theta: f64| (theta.to_radians() / 2.0).tan();
    let share = (tangent(60.0) - tangent(40.0)) / (tangent(80.0) - tangent(40.0));
    let all = spread(&mesh, 3, at(60.0, 0.0));
    assert!((all[2] - share).abs() < 1e-6 && (all[0] + share - 1.0).abs() < 1e-6, "{all:?}");
    assert_eq!(spread(&mesh, 3, at(80.0, 180.0)), [0.0, 1.0, 0.0]);
    assert_eq!(spread(&mesh, 3, at(89.0, 0.0)), [0.0, 0.0, 1.0]);
    // Off the line: the point straight across on it.
    let aside = spread(&mesh, 3, at(60.0, 90.0));
    let foot = tangent(10.0) / (tangent(10.0) + tangent(40.0));
    assert!((aside[0] - foot).abs() < 1e-6, "{aside:?}");
}

#[test]
fn directions_too_close_for_f32_are_refused() {
    let close =
        |apart: f64| DirectionSet { name: String::new(), angles: vec![[0.0, 0.0], [50.0, 10.0], [50.0 + apart, 10.0]] };
    let error = DirectionMesh::new(&close(0.01)).unwrap_err().to_string();
    assert!(error.starts_with("direction 2: equal to direction 1"), "{error}");
    // Sets within the limits can be interpolated, also at the horizon, where coordinates are densest.
    assert!(DirectionMesh::new(&close(0.02)).is_ok());
    let low = DirectionSet { name: String::new(), angles: vec![[0.0, 0.0], [89.9, 10.0], [89.9, 10.015]] };
    assert!(DirectionMesh::new(&low).is_ok());
    let none = DirectionSet { name: String::new(), angles: Vec::new() };
    assert!(DirectionMesh::new(&none).is_err());
}

#[test]
fn invalid_directions_get_an_arbitrary_sample() {
    for set in sets() {
        let mesh = mesh(&set);
        for bad in [[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [0.0; 3], [1e30, -1e30, -1.0], [0.0, f32::NAN, 1.0]] {
            let (indices, weights) = mesh.weights(bad);
            assert!(indices.iter().all(|index| (*index as usize) < set.len()));
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{bad:?} {weights:?}");
        }
    }
}

/// Largest change of interpolated values over steps of 1e-4 rad around the rim, with random values at the samples.
fn largest_step(weights: impl Fn([f32; 3]) -> ([u32; 3], [f32; 3])) -> f64 {
    let value = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
    let mut largest = 0.0f64;
    for theta in [20.0f64, 55.0, 78.0, 84.0, 89.0] {
        let mut before = None;
        for k in 0..=62_832 {
            let direction = single(from_polar(theta.to_radians(), f64::from(k) * 1e-4));
            let (indices, weights) = weights(direction);
            let found: f64 = (0..3).map(|k| f64::from(weights[k]) * value(indices[k])).sum();
            largest = largest.max(before.map_or(0.0, |before: f64| (found - before).abs()));
            before = Some(found);
        }
    }
    largest
}

/// The triangle whose smallest weight is largest, negative weights set to 0: simpler, but it jumps beyond the hull.
fn clamped_weights(mesh: &DirectionMesh, points: &[[f64; 2]], direction: [f32; 3]) -> ([u32; 3], [f32; 3]) {
    let p = paraboloid(direction).map(f64::from);
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|index| points[index as usize]);
        [cross(p, b, c), cross(a, p, c), cross(a, b, p)].map(|w| w / cross(a, b, c))
    };
    let smallest = |triangle: &[u32; 3]| of(triangle).into_iter().fold(f64::INFINITY, f64::min);
    let triangles = mesh.triangles();
    let best = triangles.iter().max_by(|a, b| smallest(a).total_cmp(&smallest(b))).unwrap();
    let weights = of(best).map(|w| w.max(0.0));
    let sum: f64 = weights.iter().sum();
    (*best, weights.map(|w| (w / sum) as f32))
}

#[test]
fn weights_are_continuous() {
    for set in [DirectionSet::ubo2003(), DirectionSet::grid(3, 5, 70.0).unwrap()] {
        let mesh = mesh(&set);
        let step = largest_step(|direction| mesh.weights(direction));
        assert!(step < 2e-3, "{step}");
    }
    let set = list(&[[10.0, 0.0], [70.0, 10.0], [40.0, 100.0], [75.0, 150.0], [50.0, 250.0], [60.0, 300.0]]);
    let mesh = mesh(&set);
    let step = largest_step(|direction| mesh.weights(direction));
    assert!(step < 2e-3, "{step}");
    let points = points(&set);
    let other = largest_step(|direction| clamped_weights(&mesh, &points, direction));
    assert!(other > 2e-2, "{other}: the test sees jumps");
}

#[test]
fn cells_hold_few_candidates() {
    for set in [DirectionSet::ubo2003(), DirectionSet::ubo2014()] {
        let mesh = mesh(&set);
        let grid = mesh.words[0] as usize;
        let counts: Vec<u32> =
            mesh.words[HEADER_WORDS..=HEADER_WORDS + grid * grid].windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mean = f64::from(mesh.words[3]) / counts.len() as f64;
        assert!(*counts.iter().min().unwrap() >= 1);
        assert!(mean < 3.5 && *counts.iter().max().unwrap() <= 12, "{mean} {counts:?}");
        assert_eq!(mesh.words.len(), 5 + grid * grid + (mesh.words[3] + 3 * mesh.words[2]) as usize + 2 * set.len());
    }
}

#[test]
fn the_largest_set_is_quick_enough() {
    let mesh = mesh(&DirectionSet::grid(24, 89, 89.0).unwrap());
    assert!(mesh.words().len() < 100_000);
}

fn random_set() -> impl Strategy<Value = DirectionSet> {
    // Round angles, so that points in line and on circles turn up.
    proptest::collection::btree_set((0u32..18, 0u32..36), 1..40).prop_filter_map("equal directions", |angles| {
        let angles = angles.into_iter().map(|(t, p)| [f64::from(t * 5), f64::from(p * 10)]).collect();
        DirectionSet::new("random", angles).ok()
    })
}

fn any_direction() -> impl Strategy<Value = [f32; 3]> {
    (0.0f64..1.7, 0.0f64..std::f64::consts::TAU).prop_map(|(theta, phi)| single(from_polar(theta, phi)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_grid_changes_nothing(set in random_set(), directions in proptest::collection::vec(any_direction(), 60)) {
        let mesh = mesh(&set);
        let plain = without_grid(&mesh);
        for direction in directions {
            // At a corner several triangles agree.
            let [with, without] = [&mesh, &plain].map(|mesh| spread(mesh, set.len(), direction));
            prop_assert_eq!(with, without, "{:?}", direction);
        }
    }

    #[test]
    fn weights_give_the_nearest_point_of_the_hull(set in random_set(), direction in any_direction()) {
        let mesh = mesh(&set);
        let (indices, weights) = mesh.weights(direction);
        prop_assert!(weights.iter().all(|w| *w >= 0.0));
        prop_assert!((weights.iter().map(|w| f64::from(*w)).sum::<f64>() - 1.0).abs() < 1e-6);
        let points = points(&set);
        let p = paraboloid(direction).map(f64::from);
        let found = [0, 1].map(|axis| (0..3).map(|k| f64::from(weights[k]) * points[indices[k] as usize][axis]).sum());
        let distance = |q: [f64; 2]| (q[0] - p[0]).hypot(q[1] - p[1]);
        // For a convex hull: no sample lies farther in the direction of `p` than the nearest point does.
        let away = [p[0] - found[0], p[1] - found[1]];
        let gap = distance(found);
        for q in &points {
            let ahead = away[0] * (q[0] - found[0]) + away[1] * (q[1] - found[1]);
            prop_assert!(ahead <= 2e-6 * (1.0 + gap), "{:?} {:?} {:?}", p, found, q);
        }
    }

    #[test]
    fn triangles_are_delaunay(set in random_set()) {
        let mesh = mesh(&set);
        let points = points(&set);
        for [a, b, c] in mesh.triangles() {
            let (a, b, c) = (points[a as usize], points[b as usize], points[c as usize]);
            for q in &points {
                let [u, v, w] = [a, b, c].map(|r| [r[0] - q[0], r[1] - q[1]]);
                let square = |r: [f64; 2]| r[0] * r[0] + r[1] * r[1];
                let inside = square(u) * (v[0] * w[1] - v[1] * w[0]) - square(v) * (u[0] * w[1] - u[1] * w[0])
                    + square(w) * (u[0] * v[1] - u[1] * v[0]);
                prop_assert!(inside <= 1e-9);
            }
        }
    }
}

#[test]
fn words_round_trip_and_stay_in_range() {
    let mesh = mesh(&DirectionSet::ubo2003());
    let longer = [mesh.words(), &[7, 7]].concat();
    assert_eq!(DirectionMesh::from_words(&longer).unwrap(), mesh);
    assert_eq!(mesh.directions(), 81);
    let [grid, _, triangles, candidates] = *mesh.words.first_chunk().unwrap();
    let [grid, triangles, candidates] = [grid, triangles, candidates].map(|word| word as usize);
    let first_candidate = 5 + grid * grid;
    let first_corner = first_candidate + candidates;
    let first_coordinate = first_corner + 3 * triangles;
    for (at, word, problem) in [
        (0, 0, "directions, side of the grid: found 0, expected 1 to 128"),
        (0, u32::MAX, "directions, side of the grid: found 4294967295"),
        (1, 0, "directions, number: found 0, expected 1 to 2048"),
        (1, 2048, "directions, words: found"),
        (2, u32::MAX, "directions, triangles and segments: found 4294967295, expected 1 to 324"),
        (3, u32::MAX, "directions, candidates: found 4294967295"),
        (4, 1, "directions, cells: first candidates out of order"),
        (9, u32::MAX, "directions, cells: first candidates out of order"),
        (first_candidate, triangles as u32, "directions, candidate 0: found"),
        (first_corner + 2, 81, "directions, corner 2: found 81, expected below 81"),
        (first_coordinate + 5, f32::NAN.to_bits(), "directions, coordinate 5: found NaN, expected -1 to 1"),
    ] {
        let mut words = mesh.words.clone();
        words[at] = word;
        let error = DirectionMesh::from_words(&words).unwrap_err().to_string();
        assert!(error.starts_with(problem), "{error}");
    }
    for length in [0, 3, 4, mesh.words.len() - 1] {
        assert!(DirectionMesh::from_words(&mesh.words[..length]).is_err());
    }
}
