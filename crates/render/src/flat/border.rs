//! Distances of the vertices of a mesh from its open border, where a relief ends.

use crate::scene::Mesh;
use crate::vector::{add_scaled, double, subtract};
use brdfc_formats::direction::{Vector, dot};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Vertices closer than this share of the extent of the mesh are one, as at seams of uv.
const CLOSE: f64 = 1e-6;

/// Straight distance of each vertex from the nearest edge that has only one triangle, at most `reach` and the extent of
/// the mesh; in the scene's unit.
///
/// Nearest edges spread from vertex to vertex, so that the other side of a thin part does not count.
pub(super) fn border_distances(mesh: &Mesh, reach: f64) -> Vec<f64> {
    let points: Vec<Vector> = mesh.vertices.iter().map(|vertex| double(vertex.position)).collect();
    let extent = extent(&points);
    let reach = reach.min(extent);
    let joined = joined(&points, CLOSE * extent);
    let triangles = mesh.triangles.iter().map(|triangle| triangle.map(|corner| joined[corner as usize]));
    let triangles: Vec<[usize; 3]> = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let edges = open_edges(&triangles);
    let mut found = vec![reach; points.len()];
    if edges.is_empty() {
        return found;
    }
    let distance = |vertex: usize, edge: usize| from_segment(points[vertex], edges[edge].map(|end| points[end]));
    let neighbours = neighbours(&triangles, points.len());
    // Of positive numbers the bits have the same order.
    let mut open: BinaryHeap<_> =
        (0..edges.len()).flat_map(|edge| edges[edge].map(|vertex| Reverse((0u64, vertex, edge)))).collect();
    while let Some(Reverse((bits, vertex, edge))) = open.pop() {
        let at = f64::from_bits(bits);
        if at >= found[vertex] {
            continue;
        }
        found[vertex] = at;
        for next in &neighbours[vertex] {
            let there = distance(*next, edge);
            if there < found[*next] {
                open.push(Reverse((there.to_bits(), *next, edge)));
            }
        }
    }
    joined.into_iter().map(|vertex| found[vertex]).collect()
}

/// Diagonal of the bounding box.
fn extent(points: &[Vector]) -> f64 {
    let along = |axis: usize| {
        let range = points.iter().fold([f64::MAX, f64::MIN], |[low, high], p| [low.min(p[axis]), high.max(p[axis])]);
        (range[1] - range[0]).max(0.0)
    };
    along(0).hypot(along(1)).hypot(along(2))
}

/// The first vertex within a distance of each vertex, along each axis.
fn joined(points: &[Vector], close: f64) -> Vec<usize> {
    let side = 4.0 * close.max(f64::MIN_POSITIVE);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut found = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        let place = point.map(|c| c / side);
        let cell = place.map(|c| c.floor() as i64);
        // The cell of the point and its neighbours on the nearer sides.
        let near = [0, 1, 2].map(|axis| if place[axis] - place[axis].floor() < 0.5 { -1 } else { 1 });
        let is_near = |other: &usize| (0..3).all(|axis| (points[*other][axis] - point[axis]).abs() <= close);
        let candidates = (0..8).filter_map(|k| {
            let moved = [0, 1, 2].map(|axis| cell[axis] + if k >> axis & 1 == 1 { near[axis] } else { 0 });
            cells.get(&moved)?.iter().copied().find(|other| is_near(other))
        });
        let first = candidates.min().unwrap_or(index);
        if first == index {
            cells.entry(cell).or_default().push(index);
        }
        found.push(first);
    }
    found
}

/// Vertices of each edge of one triangle.
fn open_edges(triangles: &[[usize; 3]]) -> Vec<[usize; 2]> {
    let sides = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
    let undirected = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let mut counts: HashMap<[usize; 2], u32> = HashMap::new();
    for side in triangles.iter().flat_map(|triangle| sides(*triangle)) {
        *counts.entry(undirected(side)).or_default() += 1;
    }
    let all = triangles.iter().flat_map(|triangle| sides(*triangle));
    all.filter(|side| counts[&undirected(*side)] == 1).collect()
}

/// Vertices that share an edge with each vertex.
fn neighbours(triangles: &[[usize; 3]], count: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new(); count];
    for [a, b, c] in triangles.iter().copied() {
        for [from, to] in [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]] {
            all[from].push(to);
        }
    }
    all
}

fn from_segment(point: Vector, [a, b]: [Vector; 2]) -> f64 {
    let (along, to) = (subtract(b, a), subtract(point, a));
    let share = (dot(to, along) / dot(along, along).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let off = add_scaled(to, -share, along);
    dot(off, off).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Vertex;
    use crate::scenes::Builtin;

    fn distances(builtin: Builtin, reach: f64) -> (Mesh, Vec<f64>) {
        let mesh = builtin.scene().parts.remove(0).mesh;
        let found = border_distances(&mesh, reach);
        (mesh, found)
    }

    #[test]
    fn a_ball_has_no_border() {
        let (_, found) = distances(Builtin::Sphere, 0.25);
        assert!(found.iter().all(|distance| *distance == 0.25));
    }

    /// On the lower, straight part of a bottle.
    #[test]
    fn distances_are_those_to_the_lower_end() {
        let (mesh, found) = distances(Builtin::Bottle, 0.5);
        let low = mesh.vertices.iter().map(|vertex| vertex.position[1]).fold(f32::MAX, f32::min);
        let mut counts = [0; 2];
        for (vertex, distance) in mesh.vertices.iter().zip(found) {
            let height = f64::from(vertex.position[1] - low);
            if (0.1..0.4).contains(&height) {
                assert!((distance - height).abs() < 0.02, "{height} {distance}");
                counts[0] += 1;
            } else if height == 0.0 {
                assert_eq!(distance, 0.0);
                counts[1] += 1;
            } else if (0.6..1.0).contains(&height) {
                assert_eq!(distance, 0.5);
            }
        }
        assert!(counts[0] > 1000 && counts[1] > 90, "{counts:?}");
    }

    /// Two halves of a strip with vertices of their own where they meet, a hair apart; far from the origin.
    #[test]
    fn vertices_are_joined_at_seams() {
        let quad = crate::testing::quad(2.0, 0.0);
        let mut mesh = Mesh::default();
        for (k, hair) in [0.0f32, 1e-6].into_iter().enumerate() {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend(quad.vertices.iter().map(|vertex| {
                let [x, y, z] = vertex.position;
                Vertex { position: [x + 100.0, y + 2.0 * k as f32 + hair, z], ..*vertex }
            }));
            mesh.triangles.extend(quad.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)));
        }
        let points: Vec<Vector> = mesh.vertices.iter().map(|vertex| double(vertex.position)).collect();
        let joined = joined(&points, 1e-5);
        assert_eq!(joined, [0, 1, 2, 3, 3, 2, 6, 7]);
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| t.map(|corner| joined[corner as usize])).collect();
        assert_eq!(open_edges(&triangles).len(), 6);
        // The control: apart, both halves have four.
        let apart: Vec<_> = mesh.triangles.iter().map(|t| t.map(|corner| corner as usize)).collect();
        assert_eq!(open_edges(&apart).len(), 8);
    }

    /// A mesh whose triangles share no vertices has the same distances as one whose triangles do.
    #[test]
    fn distances_go_across_seams() {
        let (mesh, expected) = distances(Builtin::Bottle, 0.5);
        let corners = mesh.triangles.iter().flatten();
        let apart = Mesh {
            vertices: corners.clone().map(|corner| mesh.vertices[*corner as usize]).collect(),
            triangles: (0..mesh.triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        };
        let found = border_distances(&apart, 0.5);
        let expected: Vec<f64> = corners.map(|corner| expected[*corner as usize]).collect();
        assert_eq!(found, expected);
        assert!(expected.iter().any(|distance| (0.1..0.4).contains(distance)));
    }
}
