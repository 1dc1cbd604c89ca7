//! Points of a surface and their materials.

use super::mesh::{MAX_MATERIALS, PeriodicMesh, VertexMaterial};
use super::tile_image::TileImage;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, add_scaled, cross, dot, normalize, rotate_to_normal, subtract};
use std::f64::consts::PI;

/// Distance from the surface at which secondary rays start, in tiles: single precision requires it on tiles of size 1.
pub const RAY_OFFSET: f64 = 1e-5;

/// Intersection of a ray with the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Index of the triangle in the mesh.
    pub triangle: u32,
    /// Repetition of the tile in which the ray hits the triangle.
    pub tile: [i32; 2],
    /// Weights of the second and third corner.
    pub barycentric: [f32; 2],
    /// Distance from the origin, in tiles.
    pub distance: f64,
}

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position, in tiles.
    pub position: Vector,
    /// Unit shading normal: vertex normals, interpolated.
    pub normal: Vector,
    /// Unit normal of its triangle.
    pub geometric_normal: Vector,
    /// Material at the point, blended between the vertices.
    pub material: VertexMaterial,
}

impl SurfacePoint {
    /// Creates the point with barycentric weights `[u, v]` of the second and third corner of a triangle, `tile` tiles
    /// away.
    pub fn new(mesh: &PeriodicMesh, triangle: usize, [u, v]: [f64; 2], tile: [i32; 2]) -> Self {
        let weights = [1.0 - u - v, u, v];
        let corners = mesh.corners(triangle);
        let vertices = mesh.triangles[triangle].map(|corner| corner.vertex as usize);
        let mean = |values: [Vector; 3]| -> Vector {
            [0, 1, 2].map(|axis| (0..3).map(|k| weights[k] * values[k][axis]).sum())
        };
        let mut position = mean(corners);
        (0..2).for_each(|k| position[k] += f64::from(tile[k]));
        let mut material = VertexMaterial { weights: [0.0; 4], tint: [0.0; 3] };
        for k in 0..3 {
            let (part, weight) = (&mesh.materials[vertices[k]], weights[k] as f32);
            (0..4).for_each(|m| material.weights[m] += weight * part.weights[m]);
            (0..3).for_each(|c| material.tint[c] += weight * part.tint[c]);
        }
        Self {
            position,
            normal: normalize(mean(vertices.map(|vertex| mesh.normals[vertex]))),
            geometric_normal: geometric_normal(corners),
            material,
        }
    }

    /// Origin of rays that leave the surface here: [`RAY_OFFSET`] above its triangle, along the shading normal. At the
    /// bottom of a crease, the geometric normal of one side leads behind the other side. Uses the geometric normal only
    /// if the shading normal hardly rises above the triangle.
    pub fn ray_origin(&self) -> Vector {
        let rise = dot(self.normal, self.geometric_normal);
        if rise > 0.1 {
            add_scaled(self.position, RAY_OFFSET / rise, self.normal)
        } else {
            add_scaled(self.position, RAY_OFFSET, self.geometric_normal)
        }
    }

    /// Creates the point of a hit.
    pub fn of_hit(mesh: &PeriodicMesh, hit: &Hit) -> Self {
        Self::new(mesh, hit.triangle as usize, hit.barycentric.map(f64::from), hit.tile)
    }
}

/// Unit normal of a triangle, on the side from which its corners go counter-clockwise.
pub fn geometric_normal(corners: [Vector; 3]) -> Vector {
    normalize(cross(subtract(corners[1], corners[0]), subtract(corners[2], corners[0])))
}

/// The materials of a surface.
///
/// Their tangent frame is the frame of the reference plane, rotated by the shortest rotation from its normal to the
/// shading normal.
#[derive(Default)]
pub struct Appearance {
    /// Sources, one for each weight of [`VertexMaterial`] in use; 1 to 4.
    pub sources: Vec<Box<dyn Source>>,
    /// Multiplies tints: linear RGB, 0 to 1, projected vertically onto the tile.
    pub colour: Option<TileImage<3>>,
    /// Shares of the sources, in place of the vertices' shares; need not sum to 1.
    pub weights: Option<TileImage<4>>,
}

impl Appearance {
    /// `f_r` in 1/sr, linear RGB, not negative; 0 where either direction is below the horizon of the shading normal.
    pub fn reflectance(&self, point: &SurfacePoint, view: Vector, light: Vector) -> [f64; 3] {
        if dot(point.normal, view) <= 0.0 || dot(point.normal, light) <= 0.0 {
            return [0.0; 3];
        }
        let pair = DirectionPair::new(rotate_to_normal(point.normal, light), rotate_to_normal(point.normal, view));
        let mut sum = [0.0f64; 3];
        for (source, share) in self.sources.iter().zip(self.shares(point)) {
            if share != [0.0; 3] {
                let f_r = source.eval(pair, &mut Tally::default());
                (0..3).for_each(|k| sum[k] += f64::from(share[k]) * f_r[k].max(0.0));
            }
        }
        sum
    }

    /// Share of each source in the reflectance of a point, for each channel: weights times tint and colour.
    pub fn shares(&self, point: &SurfacePoint) -> [[f32; 3]; MAX_MATERIALS] {
        let [x, y, _] = point.position;
        let weights = self.weights.as_ref().map_or(point.material.weights, |map| {
            let weights = map.at(x, y);
            let sum: f32 = weights.iter().take(self.sources.len()).sum();
            // Black pixels select the first material.
            if sum > 0.0 { weights.map(|w| w / sum) } else { [1.0, 0.0, 0.0, 0.0] }
        });
        let colour = self.colour.as_ref().map_or([1.0; 3], |map| map.at(x, y));
        let tint = [0, 1, 2].map(|k: usize| point.material.tint[k] * colour[k]);
        weights.map(|weight| tint.map(|tint| weight * tint))
    }

    /// Radiance towards `view` under a light from far away, over the radiance of a white diffuser that faces the light:
    /// `π f_r cos θi`. Ignores shadows.
    pub fn relative_radiance(&self, point: &SurfacePoint, view: Vector, light: Vector) -> [f32; 3] {
        let scale = PI * dot(point.normal, light);
        self.reflectance(point, view, light).map(|f_r| (scale * f_r) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::bumps;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::from_polar;

    #[test]
    fn a_white_diffuser_that_faces_the_light_is_one() {
        let mesh = bumps(8, 0.0);
        let point = SurfacePoint::new(&mesh, 5, [0.2, 0.3], [0, 0]);
        let white = Appearance { sources: vec![parse_synth("synth:lambert?kd=1").unwrap()], ..Default::default() };
        let view = from_polar(0.7, 2.0);
        let facing = white.relative_radiance(&point, view, [0.0, 0.0, 1.0]);
        assert!(facing.iter().all(|v| (v - 1.0).abs() < 1e-6), "{facing:?}");
        let slanted = white.relative_radiance(&point, view, from_polar(1.0, 0.3));
        assert!((f64::from(slanted[0]) - 1.0f64.cos()).abs() < 1e-6);
        assert_eq!(white.relative_radiance(&point, from_polar(1.6, 0.0), [0.0, 0.0, 1.0]), [0.0; 3]);
    }

    #[test]
    fn materials_are_blended_and_tinted() {
        let mut mesh = bumps(8, 0.0);
        mesh.materials.fill(VertexMaterial { weights: [0.25, 0.75, 0.0, 0.0], tint: [1.0, 0.5, 0.0] });
        let sources = vec![parse_synth("synth:lambert?kd=0.8").unwrap(), parse_synth("synth:lambert?kd=0.4").unwrap()];
        let seen = Appearance { sources, ..Default::default() }.relative_radiance(
            &SurfacePoint::new(&mesh, 0, [0.1, 0.1], [0, 0]),
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 1.0],
        );
        assert!((seen[0] - 0.5).abs() < 1e-6 && (seen[1] - 0.25).abs() < 1e-6 && seen[2] == 0.0, "{seen:?}");
    }
}
