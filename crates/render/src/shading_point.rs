//! The point that a ray hits, with its local frame.

use super::scene::{HeightMap, Mesh, Part};
use super::trace::Hit;
use super::vector::{add_scaled, cross, double, subtract};
use brdfc_formats::direction::{Vector, dot, normalize};

/// WGSL of the local frame.
pub const SHADING_POINT_WGSL: &str = include_str!("shading_point.wgsl");

/// Minimum cosine between normal and viewer, to which normals are bent. Shading normals of smooth meshes turn away from
/// the viewer at outlines, where a BRDF has no value.
const LOWEST_VIEW: f64 = 0.02;

/// A point on a surface, seen from somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadingPoint {
    /// Position in world space.
    pub position: Vector,
    /// Unit tangent, at right angles to the normal.
    pub tangent: Vector,
    /// Unit vector, normal x tangent.
    pub bitangent: Vector,
    /// Unit vector, on the viewer's side.
    pub normal: Vector,
    /// Unit vector to the viewer, world space.
    pub to_viewer: Vector,
    /// Unit vector to the viewer in the local frame, `wo`.
    pub outgoing: Vector,
    /// Distance of the viewer.
    pub distance: f64,
    /// Texture coordinates. On back faces v is negated, so that it runs along the bitangent there, too.
    pub uv: [f64; 2],
}

impl ShadingPoint {
    /// The point of a hit, seen from `eye`.
    pub fn new(part: &Part, hit: &Hit, eye: Vector) -> Self {
        Self::bumped(&part.mesh, part.surface.bump.as_ref(), hit, eye)
    }

    /// The point of a hit without the bump map of the part.
    pub fn without_bump(part: &Part, hit: &Hit, eye: Vector) -> Self {
        Self::bumped(&part.mesh, None, hit, eye)
    }

    fn bumped(mesh: &Mesh, bump: Option<&HeightMap>, hit: &Hit, eye: Vector) -> Self {
        let corners = mesh.triangles[hit.triangle as usize].map(|corner| mesh.vertices[corner as usize]);
        let [u, v] = hit.barycentric.map(f64::from);
        let weights = [1.0 - u - v, u, v];
        let mean = |of: [Vector; 3]| [0, 1, 2].map(|k| (0..3).map(|corner| weights[corner] * of[corner][k]).sum());
        let positions = corners.map(|corner| double(corner.position));
        let position = mean(positions);
        let to_eye = subtract(eye, position);
        let distance = dot(to_eye, to_eye).sqrt();
        let to_viewer = to_eye.map(|c| c / distance);

        let mut normal = normalize(mean(corners.map(|corner| double(corner.normal))));
        let face = cross(subtract(positions[1], positions[0]), subtract(positions[2], positions[0]));
        let from_behind = dot(face, to_viewer) < 0.0;
        if from_behind {
            normal = normal.map(|c| -c);
        }
        let uv = [0, 1].map(|k| (0..3).map(|corner| weights[corner] * f64::from(corners[corner].uv[k])).sum());
        let along = mean(corners.map(|corner| double(corner.tangent)));
        if let Some(bump) = bump {
            let tangent = orthonormal(along, normal);
            let bitangent = cross(normal, tangent);
            let [du, dv] = bump.gradient(uv);
            normal = normalize(add_scaled(add_scaled(normal, -du, tangent), -dv, bitangent));
        }
        normal = bent(normal, to_viewer);
        let tangent = orthonormal(along, normal);
        let mut point = Self {
            position,
            tangent,
            bitangent: cross(normal, tangent),
            normal,
            to_viewer,
            outgoing: [0.0; 3],
            distance,
            uv: if from_behind { [uv[0], -uv[1]] } else { uv },
        };
        point.outgoing = point.local(to_viewer);
        point
    }

    /// Converts a world-space vector to the frame x = tangent, y = bitangent, z = normal.
    pub fn local(&self, v: Vector) -> Vector {
        [dot(v, self.tangent), dot(v, self.bitangent), dot(v, self.normal)]
    }

    /// Converts a vector of the local frame to world space: the inverse of [`Self::local`].
    pub fn world(&self, v: Vector) -> Vector {
        [0, 1, 2].map(|k| v[0] * self.tangent[k] + v[1] * self.bitangent[k] + v[2] * self.normal[k])
    }
}

/// The component of `v` at right angles to the unit vector `normal`, as a unit vector.
fn orthonormal(v: Vector, normal: Vector) -> Vector {
    normalize(add_scaled(v, -dot(normal, v), normal))
}

/// The normal, turned towards the viewer if the viewer is at the horizon or below.
pub(crate) fn bent(normal: Vector, to_viewer: Vector) -> Vector {
    let cosine = dot(normal, to_viewer);
    if cosine < LOWEST_VIEW { normalize(add_scaled(normal, LOWEST_VIEW - cosine, to_viewer)) } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Surface;
    use crate::testing::quad;

    const MIDDLE: Hit = Hit { part: 0, triangle: 0, barycentric: [0.25, 0.5] };

    fn part() -> Part {
        Part { name: "part", mesh: quad(2.0, 0.0), surface: Surface::default() }
    }

    #[test]
    fn the_frame_is_that_of_the_vertices() {
        let point = ShadingPoint::new(&part(), &MIDDLE, [0.0, 3.0, 4.0]);
        assert_eq!(point.tangent, [1.0, 0.0, 0.0]);
        assert_eq!(point.bitangent, [0.0, 1.0, 0.0]);
        let to_eye = subtract([0.0, 3.0, 4.0], point.position);
        assert!((point.distance - dot(to_eye, to_eye).sqrt()).abs() < 1e-12);
        assert!((0..3).all(|k| (point.outgoing[k] * point.distance - to_eye[k]).abs() < 1e-12));
    }

    #[test]
    fn local_vectors_come_back() {
        let mut part = part();
        part.mesh.vertices.iter_mut().for_each(|vertex| vertex.normal = [0.36, 0.48, 0.8]);
        let point = ShadingPoint::new(&part, &MIDDLE, [0.0, 3.0, 4.0]);
        let back = point.world(point.local([0.2, -0.5, 0.7]));
        assert!((0..3).all(|k| (back[k] - [0.2, -0.5, 0.7][k]).abs() < 1e-12), "{back:?}");
        assert_ne!(point.local([0.2, -0.5, 0.7]), back);
    }

    #[test]
    fn from_behind_the_normal_is_turned() {
        let point = ShadingPoint::new(&part(), &MIDDLE, [0.0, 3.0, -4.0]);
        assert_eq!(point.normal, [0.0, 0.0, -1.0]);
        assert!(point.outgoing[2] > 0.0);
        assert_eq!(point.bitangent, cross(point.normal, point.tangent));
    }

    /// A step along the tangent increases u, one along the bitangent increases v.
    #[test]
    fn coordinates_follow_the_frame_from_both_sides() {
        for height in [4.0, -4.0] {
            let at = |barycentric| ShadingPoint::new(&part(), &Hit { barycentric, ..MIDDLE }, [0.0, 3.0, height]);
            let [a, b] = [[0.25, 0.5], [0.35, 0.3]].map(at);
            let step = a.local(subtract(b.position, a.position));
            // The square has sides of 2 and coordinates of 0 to 1.
            assert!((0..2).all(|k| (2.0 * (b.uv[k] - a.uv[k]) - step[k]).abs() < 1e-12), "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_normal_that_turns_away_is_bent_back() {
        let mut part = part();
        for vertex in &mut part.mesh.vertices {
            vertex.normal = [0.99, 0.0, 0.141_067_4];
        }
        let point = ShadingPoint::new(&part, &MIDDLE, [0.5 - 0.72, 0.0, 2.91]);
        assert!(point.outgoing[2] > 0.9 * LOWEST_VIEW && point.outgoing[2] < 1.1 * LOWEST_VIEW, "{point:?}");
        assert!((dot(point.normal, point.normal) - 1.0).abs() < 1e-12);
        assert!(dot(point.normal, point.tangent).abs() < 1e-12);
    }
}
