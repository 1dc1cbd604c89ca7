//! A landscape of ridges, seen from just above.

use super::grid_mesh::surface;
use super::noise::{fractal, value_noise};
use super::sky;
use crate::render::scene::{Camera, Part, PointLight, Scene, Surface};
use std::f64::consts::PI;

/// Quads per side: 45,000 triangles.
const QUADS: usize = 150;
/// Length of a side.
const EXTENT: f64 = 300.0;

/// Height over the plane: hills, ridges and small bumps.
fn height(x: f64, z: f64) -> f64 {
    let hills = 16.0 * value_noise(x / 90.0 + 3.1, z / 90.0 + 8.7, 1, None);
    let ridges = 9.0 * fractal(x / 38.0, z / 38.0, 11, 3, 0.45, |n| 1.0 - 2.0 * n.abs());
    let bumps = 1.7 * fractal(x / 8.0, z / 8.0, 29, 2, 0.6, |n| n);
    // A valley along the line of sight, where the camera stands.
    let valley = (x / 70.0).powi(2).min(1.0);
    (hills + ridges) * (0.35 + 0.65 * valley) + bumps
}

pub(super) fn scene() -> Scene {
    let mesh = surface(QUADS, QUADS, |u, v| {
        let (x, z) = (EXTENT * (u - 0.5), EXTENT * (0.5 - v));
        [x, height(x, z), z]
    });
    let eye_z = 0.5 * EXTENT - 2.0;
    let eye = [0.0, height(0.0, eye_z) + 9.0, eye_z];
    Scene {
        parts: vec![Part { name: "terrain", mesh, surface: Surface::default() }],
        camera: Camera { eye, target: [0.0, eye[1] - 22.0, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 42.0 },
        // Low and opposite, so that glossy slopes glitter.
        lights: vec![
            PointLight { position: [-60.0, 130.0, -260.0], intensity: [1.0, 0.92, 0.8].map(|c| PI * 9e4 * c) },
            // What lies in the shade is seen by the sky behind the viewer.
            PointLight { position: [120.0, 260.0, 320.0], intensity: [0.7, 0.85, 1.0].map(|c| PI * 2.5e4 * c) },
        ],
        environment: sky::environment(),
        background: [0.42, 0.55, 0.72],
    }
}
