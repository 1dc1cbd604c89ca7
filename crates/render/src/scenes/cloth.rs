//! A square cloth over a round pedestal, with hanging folds.

use super::drape::Drape;
use super::grid_mesh::through;
use super::sky;
use crate::scene::{Camera, Part, PointLight, Scene, Surface};
use std::f64::consts::PI;

/// Quads per side: 10,952 triangles.
const QUADS: usize = 74;

pub(super) fn scene() -> Scene {
    // The floor is too far down to be reached.
    let drape = Drape { side: 3.1, quads: QUADS, offset: [0.05, -0.04], radius: 0.8, rim: 0.14, floor: -9.0, seed: 7 };
    Scene {
        parts: vec![Part { name: "cloth", mesh: through(&drape.fall(), QUADS), surface: Surface::default() }],
        camera: Camera { eye: [0.9, 1.5, 4.6], target: [0.03, -0.64, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 29.0 },
        // From the side, across the folds.
        lights: vec![
            PointLight { position: [-3.6, 2.2, 2.4], intensity: [PI * 22.0; 3] },
            PointLight { position: [2.6, 2.4, 3.4], intensity: [PI * 7.0; 3] },
        ],
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}
