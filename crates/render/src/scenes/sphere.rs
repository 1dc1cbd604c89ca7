//! A ball.

use super::grid_mesh::{quads, vertex};
use super::sky;
use crate::scene::{Camera, Mesh, Part, PointLight, Scene, Surface};
use std::f64::consts::{PI, TAU};

/// The unit sphere around a centre, with tangents along circles of latitude.
pub(super) fn ball(radius: f64, centre: [f64; 3], columns: usize, rows: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        // From the bottom up, so that u goes right and v up on the outside.
        let theta = PI * (1.0 - row as f64 / rows as f64);
        for column in 0..=columns {
            let phi = -TAU * column as f64 / columns as f64;
            let normal = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
            let position = [0, 1, 2].map(|k| centre[k] + radius * normal[k]);
            let uv = [column as f64 / columns as f64, row as f64 / rows as f64];
            mesh.vertices.push(vertex(position, normal, [phi.sin(), 0.0, -phi.cos()], uv));
        }
    }
    mesh.triangles = quads(columns, rows);
    // At the poles one triangle of each quad has no area.
    mesh.triangles.retain(|t| {
        let at = |corner: u32| mesh.vertices[corner as usize].position;
        let apart = |a: [f32; 3], b: [f32; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > 1e-6);
        apart(at(t[0]), at(t[1])) && apart(at(t[1]), at(t[2])) && apart(at(t[2]), at(t[0]))
    });
    mesh
}

pub(super) fn scene() -> Scene {
    Scene {
        parts: vec![Part { name: "sphere", mesh: ball(1.0, [0.0; 3], 144, 72), surface: Surface::default() }],
        camera: Camera { eye: [0.0, 0.0, 4.6], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 31.0 },
        // Radiance 1 of a white matte surface at distance d needs π d².
        lights: vec![PointLight { position: [-2.5, 3.0, 4.0], intensity: [PI * 24.0; 3] }],
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}
