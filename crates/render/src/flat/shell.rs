//! Space around a surface in coordinates of its tiles: a shell map (Porumbescu et al. 2005).
//!
//! Each triangle is extruded to a prism between the lowest and the highest point of the relief, and each prism divided
//! into three tetrahedra, in which tile coordinates are linear. A ray is cut at their faces, and each piece is cast
//! against the repeated tile. No displaced mesh is made, so that the number of tiles costs nothing.

use crate::scene::Mesh;
use crate::vector::{add_scaled, cross, double, subtract};
use brdfc_flat_btf::caster::PeriodicCaster;
use brdfc_flat_btf::surface::Hit;
use brdfc_formats::direction::{Vector, dot, normalize};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::{Ray, RayHit};
use std::time::Duration;

/// A part of a prism. Corners are above the lower or the upper end of a vertex of its triangle.
struct Cell {
    /// Triangle of the mesh.
    triangle: u32,
    /// Corner of the triangle below each corner of the cell.
    below: [usize; 4],
    /// Tile coordinates of the corners: u, v, height.
    corners: [Vector; 4],
    /// Barycentric weight of each corner at a position p: `weights[k] · (p, 1)`.
    weights: [[f64; 4]; 4],
}

/// Piece of a ray in a cell.
struct Piece {
    cell: usize,
    /// Distances at which the ray enters and leaves the cell.
    range: [f64; 2],
}

/// The first point at which a ray meets the relief.
pub(super) struct ShellHit {
    cell: usize,
    /// Distance from the origin, in world space.
    pub(super) distance: f64,
    /// Barycentric weights in the cell.
    weights: [f64; 4],
    /// The point of the repeated tile.
    pub(super) on_tile: Hit,
}

/// The space between the lowest and the highest point of a relief on a surface.
pub(super) struct Shell<'a> {
    mesh: &'a Mesh,
    caster: &'a PeriodicCaster,
    /// Side of a tile at each vertex.
    sides: Vec<f64>,
    cells: Vec<Cell>,
    /// `None` without cells.
    tree: Option<Bvh2>,
}

/// Padding of boxes, relative to the extent of the mesh: the tree is in single precision.
const PADDING: f64 = 1e-6;
/// Longest gap between pieces of a ray that stays inside, in tiles.
const GAP: f64 = 1e-4;

impl<'a> Shell<'a> {
    /// Space around a mesh with `repeat` tiles per unit of uv. Triangles without area, in space or in uv, have none.
    pub(super) fn new(mesh: &'a Mesh, caster: &'a PeriodicCaster, repeat: u32) -> Self {
        let sides = sides(mesh, f64::from(repeat));
        let heights = caster.heights();
        let mut cells = Vec::with_capacity(3 * mesh.triangles.len());
        let mut boxes = Vec::with_capacity(3 * mesh.triangles.len());
        let extent = mesh.vertices.iter().flat_map(|vertex| vertex.position).fold(0.0f32, |most, c| most.max(c.abs()));
        let padding = PADDING * f64::from(extent);
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            if tiles_of(mesh, triangle, f64::from(repeat)) == 0.0 {
                continue;
            }
            // In the order of vertices, so that neighbours divide their common side alike.
            let mut order = [0, 1, 2];
            order.sort_by_key(|corner| triangle[*corner]);
            let [a, b, c] = order;
            // Above a corner of the triangle: 0 the lower end, 1 the upper end.
            for corners in
                [[(a, 0), (b, 0), (c, 0), (c, 1)], [(a, 0), (b, 0), (b, 1), (c, 1)], [(a, 0), (a, 1), (b, 1), (c, 1)]]
            {
                let place = |(corner, end): (usize, usize)| {
                    let vertex = triangle[corner] as usize;
                    let (position, normal) =
                        (double(mesh.vertices[vertex].position), double(mesh.vertices[vertex].normal));
                    let [u, v] = mesh.vertices[vertex].uv.map(|c| f64::from(c) * f64::from(repeat));
                    (add_scaled(position, heights[end] * sides[vertex], normal), [u, v, heights[end]])
                };
                let placed = corners.map(place);
                let Some(weights) = weights(placed.map(|(position, _)| position)) else { continue };
                let (low, high) = bounds(placed.map(|(position, _)| position));
                let single = |v: Vector, by: f64| v.map(|c| (c + by) as f32).into();
                boxes.push(Aabb::new(single(low, -padding), single(high, padding)));
                cells.push(Cell {
                    triangle: index as u32,
                    below: corners.map(|(corner, _)| corner),
                    corners: placed.map(|(_, tile)| tile),
                    weights,
                });
            }
        }
        let build = || build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let tree = (!boxes.is_empty()).then(build);
        Self { mesh, caster, sides, cells, tree }
    }

    /// The first point of the relief on a ray along a unit vector.
    pub(super) fn nearest(&self, origin: Vector, direction: Vector) -> Option<ShellHit> {
        let mut found: Option<ShellHit> = None;
        self.visit(origin, direction, |piece| {
            let nearest = found.as_ref().map_or(f64::INFINITY, |hit| hit.distance);
            if piece.range[0] < nearest
                && let Some(hit) = self.cast(&piece, origin, direction)
                && hit.distance < nearest
            {
                found = Some(hit);
            }
            found.as_ref().map_or(f64::INFINITY, |hit| hit.distance)
        });
        found
    }

    /// Returns true if a ray from inside along a unit vector meets the relief before it leaves the space.
    pub(super) fn is_blocked(&self, origin: Vector, direction: Vector) -> bool {
        let mut pieces = Vec::new();
        self.visit(origin, direction, |piece| {
            pieces.push(piece);
            f64::INFINITY
        });
        pieces.sort_by(|a, b| a.range[0].total_cmp(&b.range[0]));
        let mut reached = 0.0f64;
        for piece in &pieces {
            let cell = &self.cells[piece.cell];
            let side = self.sides[self.mesh.triangles[cell.triangle as usize][0] as usize];
            if piece.range[0] > reached + GAP * side {
                return false;
            }
            if self.cast(piece, origin, direction).is_some() {
                return true;
            }
            reached = reached.max(piece.range[1]);
        }
        false
    }

    /// Tangent, bitangent and normal of the surface below a point, and the side of a tile there.
    pub(super) fn frame(&self, hit: &ShellHit) -> ([Vector; 3], f64) {
        let cell = &self.cells[hit.cell];
        let (mut tangent, mut normal, mut side) = ([0.0; 3], [0.0; 3], 0.0);
        for (weight, corner) in hit.weights.iter().zip(cell.below) {
            let vertex = self.mesh.triangles[cell.triangle as usize][corner] as usize;
            tangent = add_scaled(tangent, *weight, double(self.mesh.vertices[vertex].tangent));
            normal = add_scaled(normal, *weight, double(self.mesh.vertices[vertex].normal));
            side += weight * self.sides[vertex];
        }
        let normal = normalize(normal);
        let tangent = normalize(add_scaled(tangent, -dot(tangent, normal), normal));
        ([tangent, cross(normal, tangent), normal], side)
    }

    /// Gradients of the tile coordinates in world space.
    pub(super) fn gradients(&self, hit: &ShellHit) -> [Vector; 3] {
        let Cell { corners, weights, .. } = &self.cells[hit.cell];
        [0, 1, 2]
            .map(|axis| [0, 1, 2].map(|k| (0..4).map(|corner| weights[corner][k] * corners[corner][axis]).sum::<f64>()))
    }

    /// Casts a piece of a ray against the tile.
    fn cast(&self, piece: &Piece, origin: Vector, direction: Vector) -> Option<ShellHit> {
        let cell = &self.cells[piece.cell];
        let tile =
            |weights: [f64; 4]| [0, 1, 2].map(|axis| (0..4).map(|k| weights[k] * cell.corners[k][axis]).sum::<f64>());
        let along = tile(cell.weights.map(|w| w[0] * direction[0] + w[1] * direction[1] + w[2] * direction[2]));
        let speed = dot(along, along).sqrt();
        let start = tile(cell.at(add_scaled(origin, piece.range[0], direction)));
        let length = speed * (piece.range[1] - piece.range[0]);
        let on_tile = self.caster.nearest_within(start, along.map(|c| c / speed), length)?;
        let distance = piece.range[0] + on_tile.distance / speed;
        let weights = cell.at(add_scaled(origin, distance, direction));
        Some(ShellHit { cell: piece.cell, distance, weights, on_tile })
    }

    /// Calls `visit` for the pieces of a ray in cells, in any order. It returns the distance beyond which none matters.
    fn visit(&self, origin: Vector, direction: Vector, mut visit: impl FnMut(Piece) -> f64) {
        let Some(tree) = &self.tree else { return };
        let single = |v: Vector| v.map(|c| c as f32).into();
        let ray = Ray::new_inf(single(origin), single(direction));
        let mut last = f64::INFINITY;
        tree.ray_traverse(ray, &mut RayHit::none(), |_, id| {
            let cell = tree.primitive_indices[id] as usize;
            if let Some(range) = self.cells[cell].range(origin, direction) {
                last = visit(Piece { cell, range });
            }
            // A hit a hair farther, for boxes in single precision.
            (last * (1.0 + 1e-6)) as f32
        });
    }
}

impl Cell {
    /// Barycentric weights at a position.
    fn at(&self, [x, y, z]: Vector) -> [f64; 4] {
        self.weights.map(|w| w[0] * x + w[1] * y + w[2] * z + w[3])
    }

    /// Distances at which a ray enters and leaves the cell.
    fn range(&self, origin: Vector, direction: Vector) -> Option<[f64; 2]> {
        let (mut enters, mut leaves) = (0.0f64, f64::INFINITY);
        for (weight, from) in self.weights.iter().zip(self.at(origin)) {
            let slope = weight[0] * direction[0] + weight[1] * direction[1] + weight[2] * direction[2];
            let zero = -from / slope;
            if slope > 0.0 {
                enters = enters.max(zero);
            } else if slope < 0.0 {
                leaves = leaves.min(zero);
            } else if from < 0.0 {
                return None;
            }
        }
        (enters < leaves && leaves.is_finite()).then_some([enters, leaves])
    }
}

/// Side of a tile at each vertex: the root of the area that a tile covers, mean of the triangles around.
pub(super) fn sides(mesh: &Mesh, repeat: f64) -> Vec<f64> {
    let mut areas = vec![[0.0; 2]; mesh.vertices.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| &mesh.vertices[corner as usize]);
        let [a, b, c] = corners.map(|corner| double(corner.position));
        let face = cross(subtract(b, a), subtract(c, a));
        let tiles = tiles_of(mesh, triangle, repeat);
        for corner in triangle {
            let area = &mut areas[*corner as usize];
            *area = [area[0] + dot(face, face).sqrt(), area[1] + tiles];
        }
    }
    areas.into_iter().map(|[area, tiles]| if tiles > 0.0 { (area / tiles).sqrt() } else { 0.0 }).collect()
}

/// Area of a triangle in tiles, twice.
fn tiles_of(mesh: &Mesh, triangle: &[u32; 3], repeat: f64) -> f64 {
    let [p, q, r] = triangle.map(|corner| mesh.vertices[corner as usize].uv.map(|c| f64::from(c) * repeat));
    ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).abs()
}

/// Barycentric weights of a tetrahedron as linear functions of the position. `None` without a volume.
fn weights([a, b, c, d]: [Vector; 4]) -> Option<[[f64; 4]; 4]> {
    let (ab, ac, ad) = (subtract(b, a), subtract(c, a), subtract(d, a));
    let volume = dot(ab, cross(ac, ad));
    let longest = [ab, ac, ad].map(|e| dot(e, e)).into_iter().fold(0.0, f64::max).sqrt();
    if volume.abs() <= 1e-12 * longest.powi(3) {
        return None;
    }
    let of = |normal: Vector| {
        let [x, y, z] = normal.map(|c| c / volume);
        [x, y, z, -(x * a[0] + y * a[1] + z * a[2])]
    };
    let [b, c, d] = [of(cross(ac, ad)), of(cross(ad, ab)), of(cross(ab, ac))];
    let mut first = [0.0, 0.0, 0.0, 1.0];
    (0..4).for_each(|k| first[k] -= b[k] + c[k] + d[k]);
    Some([first, b, c, d])
}

/// Lowest and highest coordinates.
fn bounds(corners: [Vector; 4]) -> (Vector, Vector) {
    let along = |axis: usize, of: fn(f64, f64) -> f64| corners.map(|corner| corner[axis]).into_iter().reduce(of);
    let all = |of: fn(f64, f64) -> f64| [0, 1, 2].map(|axis| along(axis, of).expect("four corners"));
    (all(f64::min), all(f64::max))
}
