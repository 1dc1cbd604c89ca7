//! Construction of triangles and segments, and of the grid of candidates.

use crate::FormatError;
use std::collections::BTreeSet;

/// Words before the cells.
pub(super) const HEADER_WORDS: usize = 4;
/// Minimum distance of two directions, about twice the distance of their paraboloid coordinates at the normal.
const MIN_DISTANCE: f64 = 1e-4;
/// Ratio of height to length below which a triangle counts as a line: a few times the rounding of f32 coordinates.
const FLAT: f64 = 1e-6;
/// Widening of regions, so that f32 rounding never selects a cell that lacks them.
const SLACK: f64 = 1e-5;
/// Maximum number of cells along an axis.
pub(super) const MAX_GRID: usize = 128;

type Point = [f64; 2];

/// Half plane `normal · p + offset >= 0`; the normal has length 1.
#[derive(Clone, Copy)]
struct HalfPlane {
    normal: Point,
    offset: f64,
}

impl HalfPlane {
    /// Points at or ahead of `through` in the direction `direction`.
    fn ahead(through: Point, direction: Point) -> Self {
        let length = direction[0].hypot(direction[1]);
        let normal = [direction[0] / length, direction[1] / length];
        Self { normal, offset: -dot(normal, through) }
    }

    /// Distance to the border, negative outside, of the half plane widened by [`SLACK`].
    fn depth(&self, p: Point) -> f64 {
        dot(self.normal, p) + self.offset + SLACK
    }
}

/// Convex region in which a triangle or segment may determine the weights.
struct Region {
    triangle: u32,
    planes: Vec<HalfPlane>,
}

/// Words of a mesh over points in paraboloid coordinates.
pub(super) fn words(points: &[[f32; 2]]) -> Result<Vec<u32>, FormatError> {
    let exact: Vec<Point> = points.iter().map(|p| p.map(f64::from)).collect();
    check_distances(&exact)?;
    let (triangles, regions) = match triangulate(&exact) {
        triangles if triangles.is_empty() => chain(&exact),
        triangles => {
            check_all_used(&triangles, points.len())?;
            with_hull(&exact, triangles)
        }
    };
    let grid = grid_size(points.len());
    let cells = cells(grid, &regions);
    let candidates: usize = cells.iter().map(Vec::len).sum();
    let mut words = Vec::with_capacity(HEADER_WORDS + grid * grid + 1 + candidates + 3 * triangles.len());
    words.extend([grid as u32, points.len() as u32, triangles.len() as u32, candidates as u32]);
    let mut first = 0;
    for cell in &cells {
        words.push(first);
        first += cell.len() as u32;
    }
    words.push(first);
    words.extend(cells.into_iter().flatten());
    words.extend(triangles.into_iter().flatten());
    words.extend(points.iter().flatten().map(|coordinate| coordinate.to_bits()));
    Ok(words)
}

/// Grid size for about four cells per direction.
fn grid_size(directions: usize) -> usize {
    (2..MAX_GRID).find(|grid| grid * grid >= 4 * directions).unwrap_or(MAX_GRID)
}

fn check_distances(points: &[Point]) -> Result<(), FormatError> {
    for (second, b) in points.iter().enumerate() {
        if let Some(first) = points[..second].iter().position(|a| 2.0 * length(subtract(*a, *b)) < MIN_DISTANCE) {
            let found = format!("less than {MIN_DISTANCE} from direction {first}");
            let allowed = "directions that are farther apart, for interpolation";
            return Err(FormatError::whole(format!("direction {second}"), found, allowed).problem());
        }
    }
    Ok(())
}

/// Checks that all points are used: a point touched only by flat triangles would never get its weight.
fn check_all_used(triangles: &[[u32; 3]], points: usize) -> Result<(), FormatError> {
    let mut used = vec![false; points];
    for corner in triangles.iter().flatten() {
        used[*corner as usize] = true;
    }
    match used.iter().position(|used| !used) {
        Some(index) => Err(FormatError::whole(
            format!("direction {index}"),
            "only triangles that are nearly lines",
            "directions all on one line, or none nearly on a line between others at the rim",
        )
        .problem()),
        None => Ok(()),
    }
}

/// Delaunay triangles, counter-clockwise, each from its smallest index on, sorted. Empty if all points are collinear.
fn triangulate(points: &[Point]) -> Vec<[u32; 3]> {
    let input: Vec<delaunator::Point> = points.iter().map(|&p| p.into()).collect();
    let result = delaunator::triangulate(&input);
    let mut triangles: Vec<[u32; 3]> = result
        .triangles
        .chunks_exact(3)
        .filter_map(|corners| {
            let [a, b, c] = [points[corners[0]], points[corners[1]], points[corners[2]]];
            let area = cross(subtract(b, a), subtract(c, a));
            let longest = length(subtract(b, a)).max(length(subtract(c, b))).max(length(subtract(a, c)));
            let mut triangle = [corners[0] as u32, corners[1] as u32, corners[2] as u32];
            if area < 0.0 {
                triangle.swap(1, 2);
            }
            let smallest = (0..3).min_by_key(|k| triangle[*k]).unwrap_or(0);
            triangle.rotate_left(smallest);
            (area.abs() > FLAT * longest).then_some(triangle)
        })
        .collect();
    triangles.sort_unstable();
    triangles
}

/// Collinear points as segments between neighbours, in both directions; a single point as one segment.
fn chain(points: &[Point]) -> (Vec<[u32; 3]>, Vec<Region>) {
    if points.len() == 1 {
        return (vec![[0; 3]], vec![Region { triangle: 0, planes: Vec::new() }]);
    }
    let farthest = |from: Point| {
        let distance = |k: &usize| length(subtract(points[*k], from));
        (0..points.len()).max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    };
    let start = points[farthest(points[0])];
    let along = subtract(points[farthest(start)], start);
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by(|a, b| dot(along, points[*a as usize]).total_cmp(&dot(along, points[*b as usize])));
    let mut segments = Vec::new();
    let mut regions = Vec::new();
    for (k, pair) in order.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        let mut planes = Vec::new();
        if k > 0 {
            planes.push(HalfPlane::ahead(points[a as usize], along));
        }
        if k + 2 < points.len() {
            planes.push(HalfPlane::ahead(points[b as usize], negative(along)));
        }
        for segment in [[a, b, b], [b, a, a]] {
            regions.push(Region { triangle: segments.len() as u32, planes: planes.clone() });
            segments.push(segment);
        }
    }
    (segments, regions)
}

/// Triangles followed by the segments of the hull. Regions are the triangles themselves, the strips beyond the segments
/// and the wedges beyond the corners.
fn with_hull(points: &[Point], mut triangles: Vec<[u32; 3]>) -> (Vec<[u32; 3]>, Vec<Region>) {
    let mut regions = Vec::new();
    let mut edges = BTreeSet::new();
    for (number, triangle) in triangles.iter().enumerate() {
        let corner = |k: usize| points[triangle[k % 3] as usize];
        let planes = (0..3).map(|k| HalfPlane::ahead(corner(k), left(subtract(corner(k + 1), corner(k))))).collect();
        regions.push(Region { triangle: number as u32, planes });
        edges.extend((0..3).map(|k| (triangle[k], triangle[(k + 1) % 3])));
    }
    let outer: BTreeSet<(u32, u32)> = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))).copied().collect();
    for &(a, b) in &outer {
        let (from, to) = (points[a as usize], points[b as usize]);
        let along = subtract(to, from);
        let segment = triangles.len() as u32;
        triangles.push([a, b, b]);
        let outside = HalfPlane::ahead(from, negative(left(along)));
        let planes = vec![outside, HalfPlane::ahead(from, along), HalfPlane::ahead(to, negative(along))];
        regions.push(Region { triangle: segment, planes });
        for &(_, c) in outer.range((b, 0)..=(b, u32::MAX)) {
            let next = subtract(points[c as usize], to);
            let planes = vec![HalfPlane::ahead(to, along), HalfPlane::ahead(to, negative(next))];
            regions.push(Region { triangle: segment, planes });
        }
    }
    (triangles, regions)
}

/// Indices of all regions that touch each cell, ascending.
fn cells(grid: usize, regions: &[Region]) -> Vec<Vec<u32>> {
    let step = 2.0 / grid as f64;
    let mut cells = vec![Vec::new(); grid * grid];
    for region in regions {
        for row in 0..grid {
            for column in 0..grid {
                let low = [-1.0 + column as f64 * step, -1.0 + row as f64 * step];
                if touches(&region.planes, low, step) {
                    cells[row * grid + column].push(region.triangle);
                }
            }
        }
    }
    for cell in &mut cells {
        cell.sort_unstable();
        cell.dedup();
    }
    cells
}

/// Returns true if a square has a point in all half planes.
fn touches(planes: &[HalfPlane], low: Point, step: f64) -> bool {
    let centre = [low[0] + 0.5 * step, low[1] + 0.5 * step];
    let beyond =
        |plane: &HalfPlane| plane.depth(centre) + 0.5 * step * (plane.normal[0].abs() + plane.normal[1].abs()) < 0.0;
    if planes.iter().any(beyond) {
        return false;
    }
    let high = [low[0] + step, low[1] + step];
    let mut polygon = vec![low, [high[0], low[1]], high, [low[0], high[1]]];
    for plane in planes {
        polygon = clip(&polygon, plane);
    }
    !polygon.is_empty()
}

/// Clips a convex polygon to a half plane (Sutherland and Hodgman 1974).
fn clip(polygon: &[Point], plane: &HalfPlane) -> Vec<Point> {
    let mut clipped = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (here, there) = (plane.depth(p), plane.depth(q));
        if here >= 0.0 {
            clipped.push(p);
        }
        if (here >= 0.0) != (there >= 0.0) {
            let t = here / (here - there);
            clipped.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    clipped
}

fn subtract(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn negative(a: Point) -> Point {
    [-a[0], -a[1]]
}

/// Rotates a vector by 90 degrees counter-clockwise.
fn left(a: Point) -> Point {
    [-a[1], a[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn length(a: Point) -> f64 {
    a[0].hypot(a[1])
}
