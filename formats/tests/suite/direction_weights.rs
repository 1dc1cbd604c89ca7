//! Compares weights of views and lights with the rules of `formats/src/flat_btf/spec.md`, implemented here
//! independently.

use brdfc_formats::direction::{Vector, from_polar};
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;

type Point = [f64; 2];

fn paraboloid([x, y, z]: Vector) -> Point {
    [x, y].map(|c| (c / (1.0 + z.max(0.0))).clamp(-1.0, 1.0))
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Corners and weights.
type Weights = Vec<(usize, f64)>;

/// The rules, by exhaustive search. If more than three points are on a circle any triangulation is valid, so this
/// returns the weights of all of them.
fn by_the_page(points: &[Point], q: Point, flat: f64) -> Vec<Weights> {
    let count = points.len();
    let (mut found, mut hull) = (Vec::new(), Vec::new());
    let mut any = false;
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                let (b, c) =
                    if cross(minus(points[b], points[a]), minus(points[c], points[a])) < 0.0 { (c, b) } else { (b, c) };
                let corners = [a, b, c].map(|k| points[k]);
                let Some(weights) = barycentric(corners, q, flat) else { continue };
                if !is_delaunay(points, corners) {
                    continue;
                }
                any = true;
                if weights.iter().all(|w| *w >= -1e-7) {
                    found.push([a, b, c].into_iter().zip(weights).collect());
                }
            }
        }
    }
    if any {
        for a in 0..count {
            for b in 0..count {
                let along = minus(points[b], points[a]);
                let left = |p: &Point| cross(along, minus(*p, points[a])) >= -1e-9;
                if a != b && points.iter().all(left) {
                    hull.push((a, b));
                }
            }
        }
    } else {
        // Collinear: segments between neighbours along the line.
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|a, b| points[*a][0].total_cmp(&points[*b][0]).then(points[*a][1].total_cmp(&points[*b][1])));
        hull.extend(order.windows(2).map(|pair| (pair[0], pair[1])));
    }
    if found.is_empty() {
        let nearest = hull.iter().map(|edge| on_edge(points, *edge, q));
        let best = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(vec![(0, 1.0)], |(_, weights)| weights);
        found.push(best);
    }
    found
}

fn barycentric([a, b, c]: [Point; 3], q: Point, flat: f64) -> Option<[f64; 3]> {
    let area = cross(minus(b, a), minus(c, a));
    let longest = [minus(b, a), minus(c, b), minus(a, c)].iter().map(|e| dot(*e, *e).sqrt()).fold(0.0, f64::max);
    if area <= flat * longest {
        return None;
    }
    let (wb, wc) = (cross(minus(q, a), minus(c, a)) / area, cross(minus(b, a), minus(q, a)) / area);
    Some([1.0 - wb - wc, wb, wc])
}

fn is_delaunay(points: &[Point], [a, b, c]: [Point; 3]) -> bool {
    points.iter().all(|p| {
        let [a, b, c] = [a, b, c].map(|k| minus(k, *p));
        let inside = dot(a, a) * cross(b, c) + dot(b, b) * cross(c, a) + dot(c, c) * cross(a, b);
        inside <= 1e-9
    })
}

fn on_edge(points: &[Point], (a, b): (usize, usize), q: Point) -> (f64, Weights) {
    let (along, to) = (minus(points[b], points[a]), minus(q, points[a]));
    let t = (dot(to, along) / dot(along, along)).clamp(0.0, 1.0);
    let off = minus(to, along.map(|c| t * c));
    (dot(off, off), vec![(a, 1.0 - t), (b, t)])
}

fn spread(count: usize, weights: &[(usize, f64)]) -> Vec<f64> {
    let mut all = vec![0.0; count];
    weights.iter().for_each(|(index, weight)| all[*index] += weight);
    all
}

fn sample_bilinear(mesh: &DirectionMesh, count: usize, direction: Vector) -> Vec<f64> {
    let (indices, weights) = mesh.weights(direction.map(|c| c as f32));
    spread(count, &[0, 1, 2].map(|k| (indices[k] as usize, f64::from(weights[k]))))
}

fn at([polar, azimuth]: [f64; 2]) -> Vector {
    from_polar(polar.to_radians(), azimuth.to_radians())
}

fn list(angles: &[[f64; 2]]) -> DirectionSet {
    DirectionSet::new("list", angles.to_vec()).unwrap()
}

#[test]
fn the_look_up_follows_the_page() {
    for set in [
        DirectionSet::grid(4, 6, 75.0).unwrap(),
        DirectionSet::grid(3, 9, 50.0).unwrap(),
        list(&[[5.0, 10.0], [48.0, 30.0], [70.0, 95.0], [33.0, 170.0], [81.0, 215.0], [60.0, 300.0], [20.0, 340.0]]),
        list(&[[20.0, 10.0], [70.0, 30.0], [50.0, 200.0]]),
        list(&[[40.0, 0.0], [10.0, 180.0], [80.0, 0.0]]),
        list(&[[30.0, 20.0], [10.0, 100.0]]),
        list(&[[30.0, 20.0]]),
    ] {
        let points: Vec<Point> = set.directions().into_iter().map(paraboloid).collect();
        let mesh = DirectionMesh::new(&set).unwrap();
        for k in 0..400 {
            // All directions, including below the horizon.
            let direction = at([f64::from(k) * 97.0 / 400.0, f64::from(k) * 137.508]);
            let found = sample_bilinear(&mesh, set.len(), direction);
            let allowed = by_the_page(&points, paraboloid(direction), 1e-6);
            let off = |weights: &Weights| {
                let expected = spread(set.len(), weights);
                found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            assert!(allowed.iter().any(|weights| off(weights) < 1e-5), "{direction:?}: {found:?} {allowed:?}");
        }
    }
}

/// Checks the table on the page.
#[test]
fn the_worked_weights_of_the_page() {
    let page = include_str!("../../src/flat_btf/spec.md");
    let (_, table) = page.split_once("| polar angle, azimuth | q | weights |").expect("the table");
    let mesh =
        DirectionMesh::new(&list(&[[0.0, 0.0], [60.0, 0.0], [60.0, 90.0], [60.0, 180.0], [60.0, 270.0]])).unwrap();
    let number = |text: &str| text.trim().trim_end_matches('°').parse::<f64>().unwrap_or_else(|_| panic!("{text}"));
    let two = |text: &str| text.split_once(',').map(|(a, b)| [number(a), number(b)]).unwrap();
    let mut rows = 0;
    for row in table.lines().skip(2).take_while(|line| line.starts_with('|')) {
        let [_, direction, q, weights, _] = row.split('|').collect::<Vec<_>>()[..] else { panic!("{row}") };
        let (direction, q) = (at(two(direction)), two(q));
        let weights: Weights = weights
            .split(", ")
            .map(|weight| weight.split_once(':').unwrap())
            .map(|(index, weight)| (number(index) as usize, number(weight)))
            .collect();
        let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off(&paraboloid(direction), &q) < 1e-6, "{row}");
        assert!(off(&sample_bilinear(&mesh, 5, direction), &spread(5, &weights)) < 2e-6, "{row}");
        rows += 1;
    }
    assert_eq!(rows, 6);
}
