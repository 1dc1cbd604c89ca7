//! A square cloth over a round pedestal, with hanging folds.

use super::drape::{Pedestal, drape};
use super::sky;
use crate::render::scene::{Camera, Part, PointLight, Scene, Surface};
use std::f64::consts::PI;

/// Quads per side: 10,952 triangles.
const QUADS: usize = 74;

pub(super) fn scene() -> Scene {
    let pedestal = Pedestal { radius: 0.78, edge: 0.14, floor: -1.25 };
    Scene {
        parts: vec![Part {
            name: "cloth",
            mesh: drape(3.3, [0.04, -0.03], pedestal, QUADS),
            surface: Surface::default(),
        }],
        camera: Camera { eye: [0.7, 1.75, 4.0], target: [0.0, -0.58, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 35.0 },
        lights: vec![
            PointLight { position: [-2.6, 3.2, 2.8], intensity: [PI * 20.0; 3] },
            PointLight { position: [3.5, 1.2, 2.0], intensity: [PI * 6.0; 3] },
        ],
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}
