//! The reference for a flat BTF: the displaced surface itself, ray cast.

use super::displaced::reference_object;
use crate::sample_means::sample_means;
use crate::scene::{Frame, Mesh, Scene};
use crate::shading_point::bent;
use crate::vector::{add_scaled, cross, double, subtract};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::surface::{Appearance, SurfacePoint};
use brdfc_formats::direction::{Vector, dot, normalize};
use brdfc_metrics::image::LinearImage;
use std::f64::consts::PI;

/// World space seen from a plane that is covered with tiles.
struct Tiling {
    /// Origin of tile coordinates.
    origin: Vector,
    /// Unit vectors along u, along v, and up.
    axes: [Vector; 3],
    /// Side of a tile in units of world space.
    side: f64,
}

impl Tiling {
    /// The plane of a mesh's first triangle. `None` if u and v are not at right angles or differ in scale, or if the
    /// mesh is not plane.
    fn new(mesh: &Mesh, repeat: u32) -> Option<Self> {
        let corners = mesh.triangles.first()?.map(|corner| &mesh.vertices[corner as usize]);
        let [a, b, c] = corners.map(|corner| double(corner.position));
        let [p, q, r] = corners.map(|corner| corner.uv.map(f64::from));
        let ([e, f], [g, h]) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
        let determinant = e * h - f * g;
        let (along, across) = (subtract(b, a), subtract(c, a));
        let solve = |s: f64, t: f64| [0, 1, 2].map(|k| (s * along[k] + t * across[k]) / determinant);
        let (u, v) = (solve(h, -f), solve(-g, e));
        let scale = dot(u, u).sqrt();
        let square = dot(u, v).abs() < 1e-5 * scale * scale && (dot(v, v).sqrt() / scale - 1.0).abs() < 1e-5;
        let axes = [normalize(u), normalize(v), normalize(cross(u, v))];
        let origin = add_scaled(add_scaled(a, -p[0], u), -p[1], v);
        let off = |position| dot(subtract(double(position), origin), axes[2]).abs();
        let plane = mesh.vertices.iter().all(|vertex| off(vertex.position) < 1e-5 * scale);
        (determinant != 0.0 && square && plane).then_some(Self { origin, axes, side: scale / f64::from(repeat) })
    }

    /// A direction in the plane's axes, of the same length.
    fn direction(&self, v: Vector) -> Vector {
        self.axes.map(|axis| dot(axis, v))
    }

    /// A point in tiles.
    fn point(&self, p: Vector) -> Vector {
        self.direction(subtract(p, self.origin)).map(|c| c / self.side)
    }
}

/// Draws a scene with the real displaced surface on it: the repetition of `model`, `repeat` tiles per unit of uv, under
/// direct light with cast shadows. On a plane with square tiles, seen from above its relief, the surface has no end; other
/// objects are displaced along their normals, by heights in units of a tile's side at each vertex, outlines included.
pub fn reference(scene: &Scene, frame: Frame, model: &MesoModel, appearance: &Appearance, repeat: u32) -> LinearImage {
    let plane = match &scene.parts[..] {
        [part] => Tiling::new(&part.mesh, repeat),
        _ => None,
    };
    match plane.filter(|plane| plane.point(scene.camera.eye)[2] > model.caster.heights()[1]) {
        Some(plane) => on_plane(scene, frame, model, appearance, &plane, repeat),
        None => reference_object(scene, frame, model, appearance, repeat),
    }
}

/// Rays, distances and directions to lights are exact for each point of the displaced surface. Only shadow rays continue
/// beyond a light, which is above the whole surface. The plane's edge is where a ray crosses z = 0 at uv of 0 and 1.
fn on_plane(
    scene: &Scene,
    frame: Frame,
    model: &MesoModel,
    appearance: &Appearance,
    tiling: &Tiling,
    repeat: u32,
) -> LinearImage {
    let eye = tiling.point(scene.camera.eye);
    let lights: Vec<(Vector, [f64; 3])> =
        scene.lights.iter().map(|light| (tiling.point(light.position), light.intensity)).collect();
    let last = f64::from(repeat);
    sample_means(scene, frame, |pixel, sample| {
        let [x, y] = frame.sample_position(pixel, sample);
        let ray = normalize(tiling.direction(scene.camera.ray(frame, x, y)));
        if ray[2] >= 0.0 {
            return None;
        }
        let at = add_scaled(eye, -eye[2] / ray[2], ray);
        if !(0.0..=last).contains(&at[0]) || !(0.0..=last).contains(&at[1]) {
            return None;
        }
        let view = ray.map(|c| -c);
        let point = model.point(&model.seen([at[0], at[1]], view).hit);
        // As on objects: see `Displaced::new`.
        let point = SurfacePoint { normal: bent(point.normal, view), ..point };
        let mut radiance = [0.0; 3];
        for (position, intensity) in &lights {
            let to_light = subtract(*position, point.position);
            let squared = dot(to_light, to_light);
            let light = to_light.map(|c| c / squared.sqrt());
            if model.caster.sees_sky(&point, light) {
                let value = appearance.relative_radiance(&point, view, light);
                let scale = 1.0 / (PI * squared * tiling.side * tiling.side);
                (0..3).for_each(|k| radiance[k] += f64::from(value[k]) * intensity[k] * scale);
            }
        }
        Some(radiance)
    })
}
