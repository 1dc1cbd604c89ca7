//! Distances of the vertices of a mesh from its open border, where a relief ends.

use crate::scene::Mesh;
use crate::vector::{add_scaled, double, subtract};
use brdfc_formats::direction::{Vector, dot};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Vertices closer than this share of the mesh's extent are one, as at seams of uv.
const CLOSE: f64 = 1e-6;

/// Distance of each vertex from the nearest edge that has only one triangle, at most `reach`; in the scene's unit.
///
/// Nearest edges spread from vertex to vertex, so that the other side of a thin part does not count.
pub(super) fn border_distances(mesh: &Mesh, reach: f64) -> Vec<f64> {
    let points: Vec<Vector> = mesh.vertices.iter().map(|vertex| double(vertex.position)).collect();
    let edges = open_edges(mesh, &points);
    let distance = |vertex: usize, edge: usize| from_segment(points[vertex], edges[edge].map(|end| points[end]));
    let neighbours = neighbours(mesh);
    let mut found = vec![reach; points.len()];
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
    found
}

/// Vertices of each edge of one triangle.
fn open_edges(mesh: &Mesh, points: &[Vector]) -> Vec<[usize; 2]> {
    let extent = points.iter().flatten().fold(0.0f64, |most, c| most.max(c.abs()));
    let key = |vertex: u32| points[vertex as usize].map(|c| (c / (CLOSE * extent)).round() as i64);
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    let undirected = |[a, b]: [u32; 2]| {
        let mut ends = [key(a), key(b)];
        ends.sort_unstable();
        ends
    };
    let mut counts: HashMap<[[i64; 3]; 2], u32> = HashMap::new();
    for side in mesh.triangles.iter().flat_map(|triangle| sides(*triangle)) {
        *counts.entry(undirected(side)).or_default() += 1;
    }
    let all = mesh.triangles.iter().flat_map(|triangle| sides(*triangle));
    all.filter(|side| counts[&undirected(*side)] == 1).map(|side| side.map(|vertex| vertex as usize)).collect()
}

/// Vertices that share an edge with each vertex.
fn neighbours(mesh: &Mesh) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new(); mesh.vertices.len()];
    for [a, b, c] in mesh.triangles.iter().map(|triangle| triangle.map(|vertex| vertex as usize)) {
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
}
