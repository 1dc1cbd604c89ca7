//! Curvature from a G-buffer.
//!
//! Uses only f32 additions, multiplications, divisions and square roots, in a fixed order, so that a shader can compute
//! the same values.

use super::gbuffer::{BACKGROUND, GBuffer};
use rayon::prelude::*;

/// Curvature of points without a neighbour on the same surface: more than any surface has.
pub const UNKNOWN: f32 = 1e9;

/// Limit for steps that leave the surface, over an edge that hides something. Such a step is at an angle to the normals
/// at its ends. This is twice the sine of the largest angle between a step and the tangent planes that is still a step
/// on one surface, squared. On a sphere the angle is 0 for steps of any length.
const MAX_RISE_SQUARED: f32 = 0.0625;

/// Normal curvature of every point, 1/unit of positions: the largest `|Δn| / |Δp|` over its eight neighbours on the
/// same surface. 0 for the background, [`UNKNOWN`] without such a neighbour.
///
/// If the direction of strongest curvature lies between two neighbours, the nearest one is up to 22.5° off where the
/// surface is seen head on (8 % less on a cylinder), and more where it is foreshortened.
pub fn curvature(buffer: &GBuffer) -> Vec<f32> {
    (0..buffer.part.len()).into_par_iter().map(|pixel| curvature_at(buffer, pixel)).collect()
}

fn curvature_at(buffer: &GBuffer, pixel: usize) -> f32 {
    if buffer.part[pixel] == BACKGROUND {
        return 0.0;
    }
    let (x, y) = (pixel % buffer.width, pixel / buffer.width);
    // Negative until a neighbour is found.
    let mut largest = -1.0f32;
    for row in y.saturating_sub(1)..(y + 2).min(buffer.height) {
        for column in x.saturating_sub(1)..(x + 2).min(buffer.width) {
            let neighbour = row * buffer.width + column;
            if neighbour != pixel && buffer.part[neighbour] == buffer.part[pixel] {
                largest = largest.max(turn_squared(buffer, pixel, neighbour));
            }
        }
    }
    if largest < 0.0 { UNKNOWN } else { largest.sqrt() }
}

/// `|Δn|² / |Δp|²` of a step to a neighbour; -1 if the step leaves the surface.
fn turn_squared(buffer: &GBuffer, from: usize, to: usize) -> f32 {
    let length_squared = step_squared(buffer, from, to);
    if length_squared < 0.0 {
        return -1.0;
    }
    let turn = [0, 1, 2].map(|k| buffer.normal[to][k] - buffer.normal[from][k]);
    dot(turn, turn) / length_squared
}

/// `|Δp|²` of a step to a neighbour, above 0; -1 if the step leaves the surface.
pub(crate) fn step_squared(buffer: &GBuffer, from: usize, to: usize) -> f32 {
    let ([p, q], [m, n]) = ([from, to].map(|i| buffer.position[i]), [from, to].map(|i| buffer.normal[i]));
    let step = [0, 1, 2].map(|k| q[k] - p[k]);
    let length_squared = dot(step, step);
    let rise = dot(step, [0, 1, 2].map(|k| m[k] + n[k]));
    let leaves = length_squared <= 0.0 || rise * rise > MAX_RISE_SQUARED * length_squared;
    if leaves { -1.0 } else { length_squared }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Frame, Mesh, Vertex};
    use crate::scenes::Builtin;
    use crate::testing::{plain_scene, quad};

    const FRAME: Frame = Frame { width: 64, height: 64, samples: 1 };

    fn seen_from(eye: [f64; 3]) -> Camera {
        Camera { eye, target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 30.0 }
    }

    /// A cylinder around the axis at `angle` to x in the plane z = 0.
    fn cylinder(radius: f64, angle: f64) -> Mesh {
        let columns = 720;
        let along = [angle.cos(), angle.sin(), 0.0];
        let aside = [-angle.sin(), angle.cos(), 0.0];
        let mut mesh = Mesh::default();
        for column in 0..=columns {
            let phi = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            let normal = [0, 1, 2].map(|k| phi.cos() * aside[k] + if k == 2 { phi.sin() } else { 0.0 });
            for end in [-3.0, 3.0] {
                let position = [0, 1, 2].map(|k| (radius * normal[k] + end * along[k]) as f32);
                let (normal, tangent) = (normal.map(|c| c as f32), along.map(|c| c as f32));
                mesh.vertices.push(Vertex { position, normal, tangent, uv: [0.0; 2], raised_by: 0.0, border: 0.0 });
            }
        }
        for at in (0..2 * columns as u32).step_by(2) {
            mesh.triangles.extend([[at, at + 2, at + 1], [at + 1, at + 2, at + 3]]);
        }
        mesh
    }

    /// Values of pixels whose neighbours all show a surface that is seen at up to 60°.
    fn inside(buffer: &GBuffer) -> Vec<f32> {
        let values = curvature(buffer);
        let clear = |pixel: usize| {
            let facing = dot(buffer.normal[pixel], buffer.to_viewer[pixel]) > 0.5;
            facing && buffer.part[pixel] != BACKGROUND
        };
        let found: Vec<f32> = (0..values.len()).filter(|pixel| clear(*pixel)).map(|pixel| values[pixel]).collect();
        assert!(found.len() > 400, "{}", found.len());
        found
    }

    fn within(values: &[f32], low: f64, high: f64) -> bool {
        values.iter().all(|c| (low..high).contains(&f64::from(*c)))
    }

    #[test]
    fn a_ball_has_the_inverse_of_its_radius() {
        for radius in [0.25f32, 1.0, 4.0] {
            let mut scene = Builtin::Sphere.scene();
            for vertex in &mut scene.parts[0].mesh.vertices {
                vertex.position = vertex.position.map(|c| radius * c);
            }
            scene.camera.eye = scene.camera.eye.map(|c| f64::from(radius) * c);
            let found = inside(&GBuffer::new(&scene, FRAME));
            let expected = f64::from(1.0 / radius);
            assert!(within(&found, 0.95 * expected, 1.05 * expected), "{radius}: {found:?}");
            // The control: normals that turn half as fast.
            for vertex in &mut scene.parts[0].mesh.vertices {
                let [x, y, z] = vertex.normal;
                let length = (x * x + y * y + (1.0 + z) * (1.0 + z)).sqrt().max(1e-3);
                vertex.normal = [x / length, y / length, (1.0 + z) / length];
            }
            let flat = inside(&GBuffer::new(&scene, FRAME));
            assert!(!flat.iter().any(|c| (0.95..1.05).contains(&(f64::from(*c) / expected))), "{flat:?}");
        }
    }

    #[test]
    fn a_plane_has_none() {
        for eye in [[0.0, 0.0, 5.0], [3.0, 2.0, 3.0]] {
            let buffer = GBuffer::new(&plain_scene(quad(2.0, 0.0), seen_from(eye)), FRAME);
            assert!(inside(&buffer).iter().all(|c| *c == 0.0));
        }
    }

    #[test]
    fn a_cylinder_has_the_inverse_of_its_radius_across() {
        for radius in [0.5, 1.5] {
            let scene = plain_scene(cylinder(radius, 0.0), seen_from([0.0, 0.0, 6.0]));
            let found = inside(&GBuffer::new(&scene, FRAME));
            assert!(within(&found, 0.95 / radius, 1.05 / radius), "{found:?}");
            // Between two neighbours some curvature is missed, and more at 60°.
            let turned = plain_scene(cylinder(radius, 0.39), seen_from([0.0, 0.0, 6.0]));
            let found = inside(&GBuffer::new(&turned, FRAME));
            assert!(within(&found, 0.75 / radius, 1.05 / radius), "{found:?}");
        }
    }

    /// The shapes with a smooth and a bumpy half are included.
    #[test]
    fn smooth_halves_have_known_curvatures_and_bumpy_ones_more() {
        for (builtin, expected) in [(Builtin::BumpyBall, 1.0), (Builtin::RibbedTorus, 1.0 / 0.36)] {
            let buffer = GBuffer::new(&builtin.scene(), Frame { width: 128, height: 128, samples: 1 });
            let values = curvature(&buffer);
            let of = |low: f32, high: f32| -> Vec<f64> {
                let seen = |pixel: &usize| {
                    let facing = dot(buffer.normal[*pixel], buffer.to_viewer[*pixel]) > 0.6;
                    facing && (low..high).contains(&buffer.position[*pixel][0])
                };
                (0..values.len()).filter(seen).map(|pixel| f64::from(values[pixel]) / expected).collect()
            };
            let (smooth, bumpy) = (of(-1.2, -0.45), of(0.3, 1.2));
            let close = smooth.iter().filter(|c| (0.8..1.05).contains(*c)).count();
            assert!(smooth.len() > 500 && close == smooth.len(), "{builtin:?}: {close} of {}", smooth.len());
            let more = bumpy.iter().filter(|c| **c > 1.5).count();
            assert!(3 * more > bumpy.len() && bumpy.len() > 500, "{builtin:?}: {more} of {}", bumpy.len());
        }
    }

    /// A plane in front of another with a different orientation, as one part and as two.
    #[test]
    fn outlines_and_other_parts_do_not_count() {
        let mut mesh = quad(3.0, 0.0);
        let front = quad(1.0, 1.0);
        mesh.triangles.extend(front.triangles.iter().map(|t| t.map(|corner| corner + 4)));
        mesh.vertices.extend(front.vertices.iter().map(|vertex| {
            let [x, y, z] = vertex.position;
            Vertex { position: [x, y, z - 0.75 * x], normal: [0.6, 0.0, 0.8], ..*vertex }
        }));
        let mut scene = plain_scene(mesh.clone(), seen_from([0.3, 0.2, 7.0]));
        let buffer = GBuffer::new(&scene, FRAME);
        let values = curvature(&buffer);
        assert!(values.iter().all(|c| *c == 0.0), "{:?}", values.iter().copied().fold(0.0, f32::max));
        // The control: a normal that changes on the surface itself does count.
        let mut bent = buffer.clone();
        bent.normal[32 * 64 + 32] = [0.68, 0.0, 0.733];
        assert!(curvature(&bent)[32 * 64 + 32] > 1.0 && curvature(&bent)[32 * 64 + 33] > 1.0);

        let mut second = scene.parts[0].clone();
        second.mesh.triangles.drain(..2);
        scene.parts[0].mesh.triangles.truncate(2);
        scene.parts.push(second);
        let apart = GBuffer::new(&scene, FRAME);
        assert!(apart.part.contains(&0) && apart.part.contains(&1));
        assert!(curvature(&apart).iter().all(|c| *c == 0.0));
    }

    #[test]
    fn a_point_without_neighbours_is_not_known() {
        let scene = plain_scene(quad(0.1, 0.0), seen_from([0.0, 0.0, 5.0]));
        let buffer = GBuffer::new(&scene, Frame { width: 13, height: 13, samples: 1 });
        let found = curvature(&buffer);
        assert_eq!(buffer.part.iter().filter(|part| **part != BACKGROUND).count(), 1);
        assert_eq!((found[6 * 13 + 6], found[0]), (UNKNOWN, 0.0));
    }
}
