//! A square on the ground, seen obliquely.

use super::grid_mesh::surface;
use super::sky;
use crate::scene::{Camera, Part, PointLight, Scene, Surface};
use std::f64::consts::PI;

pub(super) fn scene() -> Scene {
    let mesh = surface(4, 4, |u, v| [2.0 * u - 1.0, 0.0, 1.0 - 2.0 * v]);
    Scene {
        parts: vec![Part { name: "plane", mesh, surface: Surface::default() }],
        camera: Camera {
            eye: [0.35, 1.75, 2.9],
            target: [0.02, -0.06, 0.05],
            up: [0.0, 1.0, 0.0],
            field_of_view: 33.0,
        },
        // From the left and the back, so that relief shows.
        lights: vec![PointLight { position: [-2.6, 2.1, -1.0], intensity: [PI * 14.0; 3] }],
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}
