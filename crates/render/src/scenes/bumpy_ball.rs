//! A ball with a smooth half and a half covered with round bumps, for environment lighting.

use super::grid_mesh::vertex;
use super::sky;
use super::sphere::ball;
use crate::scene::{Camera, Mesh, Part, Scene, Surface};
use crate::vector::{add_scaled, double};
use brdfc_formats::direction::{Vector, dot, normalize};
use std::f64::consts::PI;

/// Number of points spread evenly over the whole ball; only those on one side are bumps.
const POINTS: usize = 128;
/// Centre direction of the bumps, which cover up to a right angle from it.
const SIDE: Vector = [0.94, 0.10, 0.33];
/// Height of a bump.
const HEIGHT: f64 = 0.03;
/// Radius of a bump, radians.
const RADIUS: f64 = 0.19;

/// Directions of the bumps: points of a spiral at the golden angle.
fn bumps() -> Vec<Vector> {
    let golden = PI * (3.0 - 5f64.sqrt());
    let point = |index: usize| {
        let y = 1.0 - 2.0 * (index as f64 + 0.5) / POINTS as f64;
        let (sine, azimuth) = ((1.0 - y * y).sqrt(), golden * index as f64);
        [sine * azimuth.cos(), y, sine * azimuth.sin()]
    };
    // Complete bumps only: the other half is a sphere.
    let inside = |d: &Vector| dot(*d, normalize(SIDE)) > RADIUS.sin();
    (0..POINTS).map(point).filter(inside).collect()
}

/// Distance from the centre in a direction, and its gradient over the unit sphere. Twice continuously differentiable:
/// each bump is `h (1 - s)³` with `s = (1 - cos γ) / (1 - cos r)`, γ the angle to its middle.
fn radius(d: Vector, bumps: &[Vector]) -> (f64, Vector) {
    let extent = 1.0 - RADIUS.cos();
    let (mut radius, mut gradient) = (1.0, [0.0; 3]);
    for bump in bumps {
        let cosine = dot(d, *bump);
        let rest = 1.0 - (1.0 - cosine) / extent;
        if rest > 0.0 {
            radius += HEIGHT * rest.powi(3);
            // The gradient of the cosine is the part of the bump's direction at right angles to d.
            let slope = 3.0 * HEIGHT * rest * rest / extent;
            gradient = add_scaled(gradient, slope, add_scaled(*bump, -cosine, d));
        }
    }
    (radius, gradient)
}

fn mesh(columns: usize, rows: usize) -> Mesh {
    let bumps = bumps();
    let mut mesh = ball(1.0, [0.0; 3], columns, rows);
    for corner in &mut mesh.vertices {
        let d = normalize(double(corner.normal));
        let (radius, gradient) = radius(d, &bumps);
        // A surface r(d) d has the normal r d - ∇r.
        let normal = normalize(add_scaled(d.map(|c| radius * c), -1.0, gradient));
        let tangent = double(corner.tangent);
        *corner = vertex(d.map(|c| radius * c), normal, tangent, corner.uv.map(f64::from));
    }
    mesh
}

pub(super) fn scene() -> Scene {
    Scene {
        parts: vec![Part { name: "ball", mesh: mesh(320, 160), surface: Surface::default() }],
        camera: Camera { eye: [0.0, 0.0, 4.6], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 30.0 },
        lights: Vec::new(),
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{cross, subtract};

    /// Normal by differences of positions.
    fn measured_normal(d: Vector, bumps: &[Vector]) -> Vector {
        let aside = normalize(cross(d, [0.3, 0.9, 0.2]));
        let across = cross(d, aside);
        let at = |offset: Vector| {
            let d = normalize(add_scaled(d, 1e-5, offset));
            d.map(|c| radius(d, bumps).0 * c)
        };
        let along = |v: Vector| subtract(at(v), at(v.map(|c| -c)));
        normalize(cross(along(aside), along(across)))
    }

    #[test]
    fn normals_are_those_of_the_surface() {
        let bumps = bumps();
        let (mut turned, mut largest) = (0, 0.0f64);
        for corner in mesh(60, 30).vertices {
            let (normal, d) = (double(corner.normal), normalize(double(corner.position)));
            let expected = measured_normal(d, &bumps);
            assert!(dot(normal, expected) > 1.0 - 1e-6, "{corner:?} {expected:?}");
            // The control: the normals of the smooth ball differ.
            let angle = dot(d, expected).clamp(-1.0, 1.0).acos();
            turned += usize::from(angle > 0.05);
            largest = largest.max(angle);
        }
        assert!(turned > 200 && (0.2..0.5).contains(&largest), "{turned} {largest}");
    }

    #[test]
    fn one_half_is_a_sphere() {
        let (mut smooth, mut highest) = (0, 0.0f64);
        for corner in mesh(60, 30).vertices {
            let position = double(corner.position);
            let length = dot(position, position).sqrt();
            highest = highest.max(length);
            if dot(position, normalize(SIDE)) < 0.0 {
                assert!((length - 1.0).abs() < 1e-6 && dot(position, double(corner.normal)) > 1.0 - 1e-6);
                smooth += 1;
            }
        }
        assert!(smooth > 800 && highest > 1.0 + 0.8 * HEIGHT && highest < 1.0 + 1.5 * HEIGHT, "{smooth} {highest}");
    }
}
