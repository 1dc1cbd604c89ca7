//! Mean value weights of a mesh's edges.

use crate::mesh::{Corner, PeriodicMesh};
use brdfc_formats::direction::{cross, dot, subtract};

/// A directed edge: from a vertex to a corner in a tile, seen from the vertex's own tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub from: u32,
    pub to: Corner,
    pub weight: f64,
}

/// `w_ij = (tan(α_(i-1) / 2) + tan(α_i / 2)) / |x_j - x_i|` (Floater 2003) of all directed edges, by vertex, in a fixed
/// order. Not normalised: callers divide each row by its sum.
pub(super) fn mean_value_weights(mesh: &PeriodicMesh) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(6 * mesh.triangles.len());
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(index);
        for k in 0..3 {
            let here = triangle[k];
            let [next, last] = [(k + 1) % 3, (k + 2) % 3];
            let (along, other) = (subtract(corners[next], corners[k]), subtract(corners[last], corners[k]));
            let normal = cross(along, other);
            let sine = dot(normal, normal).sqrt();
            // tan(α / 2) = sin α / (1 + cos α), with both times the lengths of the edges.
            let lengths = dot(along, along).sqrt() * dot(other, other).sqrt();
            let half_tangent = sine / (lengths + dot(along, other)).max(f64::MIN_POSITIVE);
            for (to, edge) in [(triangle[next], along), (triangle[last], other)] {
                let tile = [0, 1].map(|axis| to.tile[axis] - here.tile[axis]);
                let weight = half_tangent / dot(edge, edge).sqrt();
                edges.push(Edge { from: here.vertex, to: Corner { vertex: to.vertex, tile }, weight });
            }
        }
    }
    edges.sort_by_key(|edge| (edge.from, edge.to.vertex, edge.to.tile));
    // Each edge gets contributions from the triangles on both sides.
    edges
        .chunk_by(|a, b| (a.from, a.to) == (b.from, b.to))
        .map(|pair| Edge { weight: pair.iter().map(|edge| edge.weight).sum(), ..pair[0] })
        .collect()
}
