//! Ray casting against the endless repetition of a tile.
//!
//! One tree holds the triangles of all repetitions that overlap one tile. A ray traverses that tree once for each tile
//! it crosses, with its origin moved into the tile: coordinates stay near 1, where single precision is sufficient.

use super::mesh::PeriodicMesh;
use super::surface::{Hit, SurfacePoint};
use super::triangle_tree::{Segment, TriangleTree};
use brdfc_formats::direction::{Vector, add_scaled, dot};
use glam::Vec3A;

/// A mesh prepared for ray casting.
pub struct PeriodicCaster {
    tree: TriangleTree,
    /// For each triangle of the tree, its index in the mesh and its repetition of the tile.
    placed: Vec<(u32, [i32; 2])>,
    heights: [f64; 2],
}

/// Distance that a ray is followed into the next tile, so that none slips through between two tiles. In tiles.
const OVERLAP: f64 = 1e-6;
/// Maximum number of tiles that a ray crosses. Rays of [`MAX_POLAR_DEGREES`] over a relief of [`super::weld::MAX_HEIGHT`]
/// cross fewer.
const MAX_TILES: usize = 4096;
/// Largest polar angle of views and lights, degrees.
pub const MAX_POLAR_DEGREES: f64 = 89.0;

impl PeriodicCaster {
    /// Builds the tree.
    pub fn new(mesh: &PeriodicMesh) -> Self {
        let (mut placed, mut triangles) = (Vec::new(), Vec::new());
        for index in 0..mesh.triangles.len() {
            let corners = mesh.corners(index);
            let range = |axis: usize| {
                let c = corners.map(|corner| corner[axis]);
                let (low, high) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
                // Repetition `k` covers [low + k, high + k]: include all that overlap [0, 1].
                (-(high + OVERLAP)).ceil() as i32..=(1.0 + OVERLAP - low).floor() as i32
            };
            for y in range(1) {
                for x in range(0) {
                    let moved = corners.map(|c| add_scaled(c, 1.0, [f64::from(x), f64::from(y), 0.0]));
                    triangles.push(moved.map(single));
                    placed.push((index as u32, [x, y]));
                }
            }
        }
        let [low, high] = mesh.height_range();
        Self { tree: TriangleTree::new(&triangles), placed, heights: [low - OVERLAP, high + OVERLAP] }
    }

    /// Lowest and highest z of the surface.
    pub fn heights(&self) -> [f64; 2] {
        self.heights
    }

    /// Finds the surface point that a distant eye in direction `view` sees behind the point `at`: the first point at
    /// which the line through `at` along `view` meets the surface from above. `view` has z > 0.
    pub fn seen(&self, at: Vector, view: Vector) -> Option<Hit> {
        let above = (self.heights[1] - at[2]) / view[2];
        let origin = add_scaled(at, above, view);
        self.nearest(origin, view.map(|c| -c))
    }

    /// Finds the first intersection of the ray from `origin` along the unit vector `direction`.
    pub fn nearest(&self, origin: Vector, direction: Vector) -> Option<Hit> {
        self.nearest_within(origin, direction, f64::INFINITY)
    }

    /// Same as [`Self::nearest`] for a piece of a ray of this length, in tiles.
    pub fn nearest_within(&self, origin: Vector, direction: Vector, length: f64) -> Option<Hit> {
        let mut found = None;
        self.march(origin, direction, length, |part, tile, start| {
            let Some(hit) = self.tree.nearest(part) else { return false };
            let (triangle, repetition) = self.placed[hit.triangle as usize];
            found = Some(Hit {
                triangle,
                tile: [0, 1].map(|k| repetition[k] + tile[k]),
                barycentric: hit.barycentric,
                distance: start + f64::from(hit.distance),
            });
            true
        });
        found
    }

    /// Returns true if the ray from `origin` along the unit vector `direction` meets the surface.
    pub fn is_blocked(&self, origin: Vector, direction: Vector) -> bool {
        let mut blocked = false;
        self.march(origin, direction, f64::INFINITY, |part, _, _| {
            blocked = self.tree.is_blocked(part);
            blocked
        });
        blocked
    }

    /// Returns true if a point of the surface is visible (or lit) from infinitely far away in `direction`.
    pub fn sees_sky(&self, point: &SurfacePoint, direction: Vector) -> bool {
        dot(point.geometric_normal, direction) > 0.0 && !self.is_blocked(point.ray_origin(), direction)
    }

    /// Number of tiles that a ray crosses between the surface's lowest and highest point, up to `distance`.
    pub fn tiles(&self, origin: Vector, direction: Vector, distance: f64) -> usize {
        let mut count = 0;
        self.march(origin, direction, f64::INFINITY, |part, _, start| {
            count += 1;
            start + f64::from(part.length) >= distance
        });
        count
    }

    /// Calls `visit` with the part of the ray in each tile that it crosses between the surface's lowest and highest
    /// point: the ray in the tile's own coordinates, the tile, and the distance at which that part begins. Stops after
    /// `length`, or when `visit` returns true.
    fn march(
        &self,
        origin: Vector,
        direction: Vector,
        length: f64,
        mut visit: impl FnMut(&Segment, [i32; 2], f64) -> bool,
    ) {
        let [low, high] = self.heights;
        let (mut start, mut end) = (0.0f64, length);
        if direction[2] == 0.0 {
            if origin[2] < low || origin[2] > high {
                return;
            }
        } else {
            let (a, b) = ((low - origin[2]) / direction[2], (high - origin[2]) / direction[2]);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
        if start > end {
            return;
        }
        let mut entry = add_scaled(origin, start, direction);
        let mut tile = [entry[0].floor(), entry[1].floor()];
        let along = single(direction);
        for _ in 0..MAX_TILES {
            // Distance at which the ray leaves the tile along each axis.
            let leave = [0, 1].map(|k| {
                let border = if direction[k] > 0.0 { tile[k] + 1.0 } else { tile[k] };
                if direction[k] == 0.0 { f64::INFINITY } else { ((border - origin[k]) / direction[k]).max(start) }
            });
            let axis = usize::from(leave[1] < leave[0]);
            let stop = leave[axis].min(end);
            let local = single([entry[0] - tile[0], entry[1] - tile[1], entry[2]]);
            let part = Segment { origin: local, direction: along, length: (stop - start + OVERLAP) as f32 };
            if visit(&part, tile.map(|t| t as i32), start) || leave[axis] >= end {
                return;
            }
            start = leave[axis];
            entry = add_scaled(origin, start, direction);
            tile[axis] += direction[axis].signum();
        }
    }
}

fn single(v: Vector) -> Vec3A {
    Vec3A::from_array(v.map(|c| c as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::VertexMaterial;
    use crate::testing::{bumps, height_field};
    use brdfc_formats::direction::from_polar;

    /// Position of a hit, computed from its triangle.
    fn point(mesh: &PeriodicMesh, hit: &Hit) -> Vector {
        let corners = mesh.corners(hit.triangle as usize);
        let [u, v] = hit.barycentric.map(f64::from);
        let p = [0, 1, 2].map(|k| (1.0 - u - v) * corners[0][k] + u * corners[1][k] + v * corners[2][k]);
        [p[0] + f64::from(hit.tile[0]), p[1] + f64::from(hit.tile[1]), p[2]]
    }

    #[test]
    fn a_plane_is_hit_where_the_line_crosses_it() {
        let height = 0.125;
        let mesh = height_field(7, |_, _| height);
        let caster = PeriodicCaster::new(&mesh);
        for (theta, phi) in [(0.0, 0.0), (0.3, 1.0), (0.9, 4.0), (1.4, 2.5), (1.55, 0.1)] {
            let view = from_polar(theta, phi);
            for at in [[0.1, 0.2, 0.0], [0.999, 0.001, 0.0], [-3.4, 7.7, 0.0]] {
                let hit = caster.seen(at, view).expect("a plane is always hit");
                let expected = add_scaled(at, height / view[2], view);
                let found = point(&mesh, &hit);
                let tolerance = 2e-6 / view[2];
                assert!((0..3).all(|k| (found[k] - expected[k]).abs() < tolerance), "{found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn tiles_do_not_leak() {
        // A closed surface: from above every ray hits, at every angle, on every border.
        let mesh = bumps(16, 0.2);
        let caster = PeriodicCaster::new(&mesh);
        for k in 0..4000 {
            let (x, y) = (f64::from(k % 64) / 16.0 - 2.0, f64::from(k / 64) / 16.0);
            let view = from_polar(1.5 * f64::from(k % 97) / 97.0, f64::from(k % 13));
            assert!(caster.seen([x, y, 0.0], view).is_some(), "{k}");
        }
        let mut torn = mesh.clone();
        torn.triangles.remove(40);
        let caster = PeriodicCaster::new(&torn);
        let [a, b, c] = mesh.corners(40);
        let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        assert!(caster.seen(middle, [0.0, 0.0, 1.0]).is_none());
    }

    #[test]
    fn the_same_everywhere_in_the_repetition() {
        let mesh = bumps(16, 0.2);
        let caster = PeriodicCaster::new(&mesh);
        let view = from_polar(1.2, 0.7);
        for k in 0..100 {
            let at = [f64::from(k) * 0.037, f64::from(k) * 0.011, 0.0];
            let here = caster.seen(at, view).unwrap();
            let there = caster.seen([at[0] + 5.0, at[1] - 3.0, 0.0], view).unwrap();
            let (p, q) = (point(&mesh, &here), point(&mesh, &there));
            assert!((p[0] + 5.0 - q[0]).abs() < 1e-5 && (p[1] - 3.0 - q[1]).abs() < 1e-5 && (p[2] - q[2]).abs() < 1e-5);
        }
    }

    #[test]
    fn a_wall_in_the_next_tile_casts_its_shadow_here() {
        // A ridge at x = 0.9; low light from the left. The copy in the tile on the left casts a shadow on the ground.
        let ridge = |x: f64, _: f64| if (x - 0.9).abs() < 0.03 { 0.3 } else { 0.0 };
        let mesh = height_field(64, ridge);
        let caster = PeriodicCaster::new(&mesh);
        let up = [0.0, 0.0, 1.0];
        let from_left = from_polar(1.3, std::f64::consts::PI);
        let point = |normal| SurfacePoint {
            position: [0.2, 0.5, 0.0],
            normal,
            geometric_normal: normal,
            material: VertexMaterial::default(),
        };
        assert!(!caster.sees_sky(&point(up), from_left), "behind the ridge of the tile on the left");
        assert!(caster.sees_sky(&point(up), from_polar(0.3, std::f64::consts::PI)));
        assert!(!caster.sees_sky(&point([0.0, 0.0, -1.0]), up), "faces away");
    }

    #[test]
    fn triangles_that_hang_over_the_border_are_seen_on_both_sides() {
        let mut points = Vec::new();
        for row in 0..8 {
            for column in 0..8 {
                // Shifted by half a tile, so that triangles cross the border of the tile.
                points.push([
                    f64::from(column) / 8.0 - 0.53,
                    f64::from(row) / 8.0 + 0.31,
                    0.01 * f64::from(column % 2),
                ]);
            }
        }
        let mesh = PeriodicMesh::from_grid(8, 8, points, vec![VertexMaterial::default(); 64]);
        let caster = PeriodicCaster::new(&mesh);
        for k in 0..400 {
            let at = [f64::from(k % 20) / 20.0, f64::from(k / 20) / 20.0, 0.0];
            let hit = caster.seen(at, [0.0, 0.0, 1.0]).unwrap();
            let found = point(&mesh, &hit);
            assert!((found[0] - at[0]).abs() < 1e-5 && (found[1] - at[1]).abs() < 1e-5);
        }
    }
}
