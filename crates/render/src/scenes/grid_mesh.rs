//! Meshes from parametric surfaces.

use crate::scene::{Mesh, Vertex};
use crate::vector::{add_scaled, cross, subtract};
use brdfc_formats::direction::{Vector, dot, normalize};

/// Parameter step of the differences that give tangents.
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

/// A grid of quads through points that are stored row by row, `columns + 1` in each. Normals are means over the
/// triangles of a point, which follow the mesh on rough ground better than differences do. Tangents are differences
/// along a row.
pub(super) fn through(points: &[Vector], columns: usize) -> Mesh {
    let width = columns + 1;
    let rows = points.len() / width - 1;
    let triangles = quads(columns, rows);
    let mut normals = vec![[0.0; 3]; points.len()];
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|corner| points[corner as usize]);
        let normal = normalize(cross(subtract(b, a), subtract(c, a)));
        triangle
            .iter()
            .for_each(|corner| normals[*corner as usize] = add_scaled(normals[*corner as usize], 1.0, normal));
    }
    let vertices = (0..points.len()).map(|index| {
        let (column, row) = (index % width, index / width);
        let [before, after] = [column.saturating_sub(1), (column + 1).min(columns)].map(|c| points[row * width + c]);
        let uv = [column as f64 / columns as f64, row as f64 / rows as f64];
        vertex(points[index], normalize(normals[index]), subtract(after, before), uv)
    });
    Mesh { vertices: vertices.collect(), triangles }
}

/// A vertex whose tangent is made orthogonal to its normal.
pub(super) fn vertex(position: Vector, normal: Vector, tangent: Vector, uv: [f64; 2]) -> Vertex {
    let tangent = normalize(add_scaled(tangent, -dot(normal, tangent), normal));
    let single = |v: Vector| v.map(|c| c as f32);
    Vertex {
        position: single(position),
        normal: single(normal),
        tangent: single(tangent),
        uv: uv.map(|c| c as f32),
        raised_by: 0.0,
        border: 0.0,
    }
}

/// Two triangles for each quad of a grid of vertices that is stored row by row; counter-clockwise if u goes right and v
/// goes up.
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
