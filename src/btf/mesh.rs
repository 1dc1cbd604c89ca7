//! Meso-geometry: a triangle mesh over the unit tile that goes on periodically.

use brdfc_formats::direction::{Vector, cross, dot, normalize, subtract};

/// A corner of a triangle: a vertex in one of the repetitions of the tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    /// Index of the vertex.
    pub vertex: u32,
    /// Which repetition: the corner stands at the vertex's position plus this many tiles along x and y.
    pub tile: [i32; 2],
}

/// A surface that repeats after 1 along x and y: every edge has a triangle on either side, where need be in the next
/// tile. Overhangs are allowed.
///
/// Triangles are counter-clockwise seen from outside (from above, where the surface is no overhang).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PeriodicMesh {
    /// Where vertices are, in tiles. Vertices that coincide in different tiles are one vertex.
    pub positions: Vec<Vector>,
    /// Unit shading normals of the vertices.
    pub normals: Vec<Vector>,
    /// What vertices are made of.
    pub materials: Vec<VertexMaterial>,
    /// Three corners each.
    pub triangles: Vec<[Corner; 3]>,
}

/// Most materials that one surface blends.
pub const MAX_MATERIALS: usize = 4;

/// Which materials a vertex has; interpolated over triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VertexMaterial {
    /// Shares of the surface's materials; not negative, sum 1.
    pub weights: [f32; MAX_MATERIALS],
    /// Multiplies the reflectance: linear RGB, 0 to 1.
    pub tint: [f32; 3],
}

impl Default for VertexMaterial {
    /// The first material as it is.
    fn default() -> Self {
        Self { weights: [1.0, 0.0, 0.0, 0.0], tint: [1.0; 3] }
    }
}

impl PeriodicMesh {
    /// Where a corner is.
    pub fn position(&self, corner: Corner) -> Vector {
        let [x, y, z] = self.positions[corner.vertex as usize];
        [x + f64::from(corner.tile[0]), y + f64::from(corner.tile[1]), z]
    }

    /// Where the corners of a triangle are.
    pub fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.triangles[triangle].map(|corner| self.position(corner))
    }

    /// Lowest and highest z.
    pub fn height_range(&self) -> [f64; 2] {
        let z = self.positions.iter().map(|p| p[2]);
        [z.clone().fold(f64::INFINITY, f64::min), z.fold(f64::NEG_INFINITY, f64::max)]
    }

    /// A mesh through a grid of `columns` x `rows` points, row by row, that is joined at its ends: point `(column, row)`
    /// comes from parameters `(column / columns, row / rows)`, and at `columns` the surface goes on one tile along x, at
    /// `rows` one tile along y. Quads are split along their shorter diagonal. Normals are means over the triangles at a
    /// vertex, weighted by their angles there.
    ///
    /// # Panics
    /// With fewer than 3 columns or rows, or another number of points or materials.
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
