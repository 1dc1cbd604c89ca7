//! Meshes from parametric surfaces.

use crate::render::scene::{Mesh, Vertex};
use crate::render::vector::{add_scaled, cross, subtract};
use brdfc_formats::direction::{Vector, dot, normalize};

/// Step of the differences that tangents come from, in parameters.
const STEP: f64 = 1e-4;

/// A grid of `columns` x `rows` quads over `(u, v)` in the unit square. Normals are `dP/du x dP/dv`, tangents `dP/du`.
pub(super) fn surface(columns: usize, rows: usize, position: impl Fn(f64, f64) -> Vector) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (column as f64 / columns as f64, row as f64 / rows as f64);
            let difference = |a: Vector, b: Vector| normalize(subtract(b, a));
            let along_u = difference(position(u - STEP, v), position(u + STEP, v));
            let along_v = difference(position(u, v - STEP), position(u, v + STEP));
            let normal = normalize(cross(along_u, along_v));
            mesh.vertices.push(vertex(position(u, v), normal, along_u, [u, v]));
        }
    }
    mesh.triangles = quads(columns, rows);
    mesh
}

/// A vertex whose tangent is put at right angles to its normal.
pub(super) fn vertex(position: Vector, normal: Vector, tangent: Vector, uv: [f64; 2]) -> Vertex {
    let tangent = normalize(add_scaled(tangent, -dot(normal, tangent), normal));
    let single = |v: Vector| v.map(|c| c as f32);
    Vertex { position: single(position), normal: single(normal), tangent: single(tangent), uv: uv.map(|c| c as f32) }
}

/// Two triangles for each quad of a grid of vertices that is stored row by row; counter-clockwise where u goes right
/// and v goes up.
pub(super) fn quads(columns: usize, rows: usize) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(2 * columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let at = |c: usize, r: usize| ((row + r) * (columns + 1) + column + c) as u32;
            triangles.push([at(0, 0), at(1, 0), at(1, 1)]);
            triangles.push([at(0, 0), at(1, 1), at(0, 1)]);
        }
    }
    triangles
}
