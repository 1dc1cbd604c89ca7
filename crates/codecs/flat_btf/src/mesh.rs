//! Meso-geometry: a triangle mesh over the unit tile that repeats periodically.

use brdfc_formats::direction::{Vector, cross, dot, normalize, subtract};
use brdfc_readers::meso::TriangleMesh;
use std::collections::BTreeMap;

/// A corner of a triangle: a vertex in one of the repetitions of the tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    /// Index of the vertex.
    pub vertex: u32,
    /// Repetition of the tile: the corner's position is the vertex's position plus this many tiles along x and y.
    pub tile: [i32; 2],
}

/// A surface with period 1 along x and y. Every edge has a triangle on either side, possibly in the next tile.
/// Overhangs are allowed.
///
/// Triangles are counter-clockwise when seen from outside: from above, except on overhangs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PeriodicMesh {
    /// Positions of the vertices, in tiles. Vertices that coincide in different tiles are one vertex.
    pub positions: Vec<Vector>,
    /// Unit shading normals of the vertices.
    pub normals: Vec<Vector>,
    /// Materials of the vertices.
    pub materials: Vec<VertexMaterial>,
    /// Triangles of three corners each.
    pub triangles: Vec<[Corner; 3]>,
}

/// Maximum number of materials that one surface blends.
pub const MAX_MATERIALS: usize = 4;

/// Material weights of a vertex, interpolated over triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VertexMaterial {
    /// Shares of the surface's materials; not negative, sum 1.
    pub weights: [f32; MAX_MATERIALS],
    /// Multiplies the reflectance: linear RGB, 0 to 1.
    pub tint: [f32; 3],
}

impl Default for VertexMaterial {
    /// The first material, untinted.
    fn default() -> Self {
        Self { weights: [1.0, 0.0, 0.0, 0.0], tint: [1.0; 3] }
    }
}

impl PeriodicMesh {
    /// Position of a corner.
    pub fn position(&self, corner: Corner) -> Vector {
        let [x, y, z] = self.positions[corner.vertex as usize];
        [x + f64::from(corner.tile[0]), y + f64::from(corner.tile[1]), z]
    }

    /// Positions of the corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.triangles[triangle].map(|corner| self.position(corner))
    }

    /// Lowest and highest z.
    pub fn height_range(&self) -> [f64; 2] {
        let z = self.positions.iter().map(|p| p[2]);
        [z.clone().fold(f64::INFINITY, f64::min), z.fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Area of the projection on the reference plane in tiles, with parts that face down counted as negative: 1 for a
    /// sheet over the tile.
    pub fn projected_area(&self) -> f64 {
        let area = |triangle| {
            let [a, b, c] = self.corners(triangle);
            0.5 * cross(subtract(b, a), subtract(c, a))[2]
        };
        (0..self.triangles.len()).map(area).sum()
    }

    /// Builds a mesh from a grid of `columns` x `rows` points, row by row, that is joined at its ends. Point `(column,
    /// row)` has parameters `(column / columns, row / rows)`. At `columns` the surface continues one tile along x, at
    /// `rows` one tile along y. Quads are split along their shorter diagonal. Normals are means over the triangles at a
    /// vertex, weighted by their angles there.
    ///
    /// # Panics
    /// Panics with fewer than 3 columns or rows, or if the number of points or materials differs from `columns * rows`.
    pub fn from_grid(columns: usize, rows: usize, points: Vec<Vector>, materials: Vec<VertexMaterial>) -> Self {
        assert!(columns >= 3 && rows >= 3, "a grid of {columns} x {rows} cannot be joined");
        assert_eq!(points.len(), columns * rows, "one point for each vertex");
        assert_eq!(materials.len(), points.len(), "one material for each vertex");
        let mut mesh = Self { positions: points, materials, ..Self::default() };
        let corner = |column: usize, row: usize| Corner {
            vertex: (row % rows * columns + column % columns) as u32,
            tile: [(column / columns) as i32, (row / rows) as i32],
        };
        for row in 0..rows {
            for column in 0..columns {
                let [a, b] = [corner(column, row), corner(column + 1, row)];
                let [d, c] = [corner(column, row + 1), corner(column + 1, row + 1)];
                let distance = |p: Corner, q: Corner| {
                    let (p, q) = (mesh.position(p), mesh.position(q));
                    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>()
                };
                let split =
                    if distance(a, c) <= distance(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                mesh.triangles.extend(split);
            }
        }
        mesh.normals = mesh.smooth_normals();
        mesh
    }

    /// Returns one tile as a mesh for files: corners in other tiles become vertices of their own. Tints become vertex
    /// colours; the material weights of vertices are lost.
    pub fn to_triangle_mesh(&self) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        let mut known = BTreeMap::new();
        let mut index = |corner: &Corner, mesh: &mut TriangleMesh| {
            *known.entry((corner.vertex, corner.tile)).or_insert_with(|| {
                mesh.positions.push(self.position(*corner));
                mesh.colours.push(self.materials[corner.vertex as usize].tint);
                mesh.positions.len() as u32 - 1
            })
        };
        for triangle in &self.triangles {
            let corners = [0, 1, 2].map(|k| index(&triangle[k], &mut mesh));
            mesh.triangles.push(corners);
        }
        mesh
    }

    /// Unit normals at vertices: means over the triangles there, weighted by their angles.
    pub fn smooth_normals(&self) -> Vec<Vector> {
        let mut normals = vec![[0.0; 3]; self.positions.len()];
        for (index, triangle) in self.triangles.iter().enumerate() {
            let corners = self.corners(index);
            for k in 0..3 {
                let (along, other) =
                    (subtract(corners[(k + 1) % 3], corners[k]), subtract(corners[(k + 2) % 3], corners[k]));
                let normal = cross(along, other);
                let angle = dot(normal, normal).sqrt().atan2(dot(along, other));
                let normal = normalize(normal);
                let sum = &mut normals[triangle[k].vertex as usize];
                (0..3).for_each(|axis| sum[axis] += angle * normal[axis]);
            }
        }
        normals.into_iter().map(normalize).collect()
    }
}

/// Parameters of the corners of a triangle.
pub fn corner_coordinates(mesh: &PeriodicMesh, coordinates: &[[f64; 2]], triangle: usize) -> [[f64; 2]; 3] {
    mesh.triangles[triangle].map(|corner| {
        let c = coordinates[corner.vertex as usize];
        [c[0] + f64::from(corner.tile[0]), c[1] + f64::from(corner.tile[1])]
    })
}

/// Twice the signed area of a triangle of parameters; positive when its corners go counter-clockwise.
pub fn twice_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    /// Number of times that each edge is traversed, in either direction; keys are its ends and the tiles that it
    /// crosses.
    pub fn edges(mesh: &PeriodicMesh) -> BTreeMap<(u32, u32, [i32; 2]), [usize; 2]> {
        let mut edges: BTreeMap<_, [usize; 2]> = BTreeMap::new();
        for triangle in &mesh.triangles {
            for side in 0..3 {
                let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
                let step = [0, 1].map(|k| to.tile[k] - from.tile[k]);
                let (along, back) = ((from.vertex, to.vertex, step), (to.vertex, from.vertex, step.map(|s| -s)));
                edges.entry(along.min(back)).or_default()[usize::from(back < along)] += 1;
            }
        }
        edges
    }

    proptest! {
        /// For any points, the grid is a torus that covers the tile once.
        #[test]
        fn grids_are_sheets(
            (columns, rows, offsets) in (3usize..9, 3usize..9).prop_flat_map(|(columns, rows)| {
                let offset = [-0.4..0.4, -0.4..0.4, -1.0..1.0];
                (Just(columns), Just(rows), prop::collection::vec(offset, columns * rows))
            }),
        ) {
            let place = |i: usize| [(i % columns) as f64 / columns as f64, (i / columns) as f64 / rows as f64, 0.0];
            let points: Vec<Vector> =
                offsets.iter().enumerate().map(|(i, o)| [0, 1, 2].map(|k| place(i)[k] + o[k])).collect();
            let mesh = PeriodicMesh::from_grid(columns, rows, points, vec![VertexMaterial::default(); columns * rows]);
            let edges = edges(&mesh);
            prop_assert!(edges.values().all(|passes| *passes == [1, 1]));
            prop_assert_eq!(mesh.positions.len() + mesh.triangles.len(), edges.len());
            prop_assert!((mesh.projected_area() - 1.0).abs() < 1e-12, "{}", mesh.projected_area());
            prop_assert!(mesh.normals.iter().all(|n| (dot(*n, *n) - 1.0).abs() < 1e-12));
        }
    }

    #[test]
    fn missing_triangles_are_detected() {
        let points = (0..9).map(|i| [f64::from(i % 3) / 3.0, f64::from(i / 3) / 3.0, 0.0]).collect();
        let mut mesh = PeriodicMesh::from_grid(3, 3, points, vec![VertexMaterial::default(); 9]);
        assert!((mesh.projected_area() - 1.0).abs() < 1e-15);
        mesh.triangles.pop();
        assert!((mesh.projected_area() - 17.0 / 18.0).abs() < 1e-15);
        assert!(edges(&mesh).values().any(|passes| *passes != [1, 1]));
    }
}
