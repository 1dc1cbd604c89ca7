//! Ray casting: the visible surface of each sample of an image.

use super::scene::{Frame, Scene};
use super::vector::{cross, double, subtract};
use brdfc_formats::direction::{Vector, dot};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use std::time::Duration;

/// The first intersection of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Index of the part.
    pub part: u32,
    /// Index of the triangle in the part's mesh.
    pub triangle: u32,
    /// Weights of the second and third corner.
    pub barycentric: [f32; 2],
}

/// Hits of the samples of an image, pixel by pixel, samples of a pixel by rows; `None` for the background.
#[derive(Debug, Clone, PartialEq)]
pub struct Hits(pub Vec<Option<Hit>>);

/// Tolerance outside a triangle, in barycentric coordinates, which closes the seams between triangles.
const EDGE: f64 = 1e-9;

/// The triangles of a scene, prepared for ray casting. Both sides are visible.
pub(crate) struct Caster {
    triangles: Vec<[Vector; 3]>,
    /// Part and triangle of each.
    names: Vec<(u32, u32)>,
    tree: Option<Bvh2>,
}

impl Caster {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut triangles = Vec::new();
        let mut names = Vec::new();
        for (part, mesh) in scene.parts.iter().map(|part| &part.mesh).enumerate() {
            for (triangle, corners) in mesh.triangles.iter().enumerate() {
                triangles.push(corners.map(|corner| double(mesh.vertices[corner as usize].position)));
                names.push((part as u32, triangle as u32));
            }
        }
        // Converts to obvhs's vectors, whose version of glam may differ.
        let corner = |v: Vector| v.map(|c| c as f32).into();
        let boxed: Vec<Triangle> =
            triangles.iter().map(|[a, b, c]| Triangle { v0: corner(*a), v1: corner(*b), v2: corner(*c) }).collect();
        let build = || build_bvh2_from_tris(&boxed, BvhBuildParams::medium_build(), &mut Duration::default());
        let tree = (!triangles.is_empty()).then(build);
        Self { triangles, names, tree }
    }

    /// The nearest hit of a ray.
    pub(crate) fn nearest(&self, origin: Vector, direction: Vector) -> Option<Hit> {
        let mut nearest: Option<(f64, Hit)> = None;
        self.visit(origin, direction, |distance, hit| {
            if nearest.is_none_or(|(found, _)| distance < found) {
                nearest = Some((distance, hit));
            }
            distance as f32
        });
        nearest.map(|(_, hit)| hit)
    }

    /// All hits of a ray, from near to far.
    pub(crate) fn all(&self, origin: Vector, direction: Vector) -> Vec<Hit> {
        let mut hits = Vec::new();
        self.visit(origin, direction, |distance, hit| {
            hits.push((distance, hit));
            f32::INFINITY
        });
        hits.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1.part, a.1.triangle).cmp(&(b.1.part, b.1.triangle))));
        hits.into_iter().map(|(_, hit)| hit).collect()
    }

    /// Calls `visit` for hits. It returns the distance beyond which none matters.
    fn visit(&self, origin: Vector, direction: Vector, mut visit: impl FnMut(f64, Hit) -> f32) {
        let Some(tree) = &self.tree else { return };
        let single = |v: Vector| v.map(|c| c as f32).into();
        // The tree works in single precision, triangles are intersected in double.
        tree.ray_traverse(Ray::new_inf(single(origin), single(direction)), &mut RayHit::none(), |_, id| {
            let number = tree.primitive_indices[id] as usize;
            let Some((distance, barycentric)) = intersect(&self.triangles[number], origin, direction) else {
                return f32::INFINITY;
            };
            let (part, triangle) = self.names[number];
            visit(distance, Hit { part, triangle, barycentric: barycentric.map(|c| c as f32) })
        });
    }
}

/// Casts one ray for each sample.
pub fn trace(scene: &Scene, frame: Frame) -> Hits {
    let caster = Caster::new(scene);
    let samples = frame.samples_per_pixel();
    let cast = |pixel: usize, sample: usize| {
        let [x, y] = frame.sample_position(pixel, sample);
        caster.nearest(scene.camera.eye, scene.camera.ray(frame, x, y))
    };
    let mut hits = vec![None; frame.width * frame.height * samples];
    hits.par_chunks_mut(frame.width * samples).enumerate().for_each(|(row, hits)| {
        for (index, hit) in hits.iter_mut().enumerate() {
            *hit = cast(row * frame.width + index / samples, index % samples);
        }
    });
    Hits(hits)
}

/// Distance in units of `direction`, and weights of the second and third corner (Möller and Trumbore 1997).
fn intersect(corners: &[Vector; 3], origin: Vector, direction: Vector) -> Option<(f64, [f64; 2])> {
    let [a, b, c] = *corners;
    let (e1, e2) = (subtract(b, a), subtract(c, a));
    let p = cross(direction, e2);
    let determinant = dot(e1, p);
    if determinant == 0.0 {
        return None;
    }
    let from = subtract(origin, a);
    let u = dot(from, p) / determinant;
    let q = cross(from, e1);
    let v = dot(direction, q) / determinant;
    let distance = dot(e2, q) / determinant;
    let inside = u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE;
    (inside && distance > 0.0).then_some((distance, [u, v]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Mesh, Vertex};
    use crate::testing::{plain_scene, quad};

    const FRAME: Frame = Frame { width: 40, height: 30, samples: 2 };

    /// A bumpy closed surface around the origin.
    fn closed() -> Mesh {
        let (columns, rows) = (40usize, 20usize);
        let vertex = |row: usize, column: usize| {
            let theta = std::f64::consts::PI * row as f64 / rows as f64;
            let phi = std::f64::consts::TAU * (column % columns) as f64 / columns as f64;
            let radius = 1.0 + 0.2 * (5.0 * phi).sin() * theta.sin();
            let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()].map(|c| (radius * c) as f32);
            Vertex { position: d, normal: d, tangent: [1.0, 0.0, 0.0], uv: [0.0; 2], raised_by: 0.0, border: 0.0 }
        };
        let mut mesh = Mesh::default();
        for row in 0..=rows {
            mesh.vertices.extend((0..columns).map(|column| vertex(row, column)));
        }
        for row in 0..rows {
            for column in 0..columns {
                let at = |r: usize, c: usize| (r * columns + c % columns) as u32;
                mesh.triangles.push([at(row, column), at(row, column + 1), at(row + 1, column)]);
                mesh.triangles.push([at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)]);
            }
        }
        mesh
    }

    #[test]
    fn a_closed_surface_has_no_holes_from_inside() {
        let camera =
            Camera { eye: [0.05, 0.1, -0.02], target: [1.0, 0.3, 0.2], up: [0.0, 1.0, 0.0], field_of_view: 120.0 };
        let scene = plain_scene(closed(), camera);
        assert!(trace(&scene, Frame { width: 200, height: 150, samples: 2 }).0.iter().all(Option::is_some));
        // The control: a missing triangle leaves a hole.
        let mut open = scene.clone();
        let seen = trace(&scene, FRAME).0[0].unwrap().triangle as usize;
        open.parts[0].mesh.triangles.remove(seen);
        assert!(trace(&open, FRAME).0.iter().any(Option::is_none));
    }

    #[test]
    fn the_nearest_surface_is_seen_from_both_sides() {
        let camera = Camera { eye: [0.0, 0.0, 5.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 20.0 };
        let mut mesh = quad(4.0, 0.0);
        let nearer = quad(4.0, 1.0);
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(nearer.vertices);
        mesh.triangles.extend(nearer.triangles.iter().map(|t| t.map(|corner| corner + first)));
        let scene = plain_scene(mesh, camera);
        assert!(trace(&scene, FRAME).0.iter().all(|hit| hit.is_some_and(|hit| hit.triangle >= 2)));
        let behind = plain_scene(scene.parts[0].mesh.clone(), Camera { eye: [0.0, 0.0, -5.0], ..camera });
        assert!(trace(&behind, FRAME).0.iter().all(|hit| hit.is_some_and(|hit| hit.triangle < 2)));
    }

    #[test]
    fn barycentric_coordinates_give_the_point_on_the_ray() {
        let camera =
            Camera { eye: [0.3, -0.2, 5.0], target: [0.1, 0.1, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 20.0 };
        let scene = plain_scene(quad(4.0, 0.0), camera);
        let hits = trace(&scene, FRAME);
        for pixel in [0, 17, 599, 1199] {
            let hit = hits.0[4 * pixel + 1].unwrap();
            let mesh = &scene.parts[0].mesh;
            let corners = mesh.triangles[hit.triangle as usize].map(|c| double(mesh.vertices[c as usize].position));
            let [u, v] = hit.barycentric.map(f64::from);
            let point = [0, 1, 2].map(|k| (1.0 - u - v) * corners[0][k] + u * corners[1][k] + v * corners[2][k]);
            let [x, y] = FRAME.sample_position(pixel, 1);
            let direction = camera.ray(FRAME, x, y);
            let off = cross(direction, subtract(point, camera.eye));
            assert!(dot(off, off).sqrt() < 1e-5, "{off:?}");
        }
    }

    #[test]
    fn an_empty_scene_is_background() {
        let camera = Camera { eye: [0.0, 0.0, 5.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 20.0 };
        assert!(trace(&plain_scene(Mesh::default(), camera), FRAME).0.iter().all(Option::is_none));
    }
}
