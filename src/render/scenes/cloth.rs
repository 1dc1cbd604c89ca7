//! A square cloth over a round pedestal, with hanging folds.

use super::grid_mesh::surface;
use super::sky;
use crate::render::scene::{Camera, Mesh, Part, PointLight, Scene, Surface};
use brdfc_formats::direction::Vector;
use std::f64::consts::PI;

/// Quads per side: 10,952 triangles.
const QUADS: usize = 74;

/// A square of side `2 half`, laid over a disc of radius `pedestal` at the origin; what hangs over falls in `folds` folds.
///
/// A point keeps its distance from the centre along the cloth: first across the disc, then round its edge, then down. The
/// farther down, the more cloth there is for the circumference, and the deeper the folds.
pub(super) fn drape(half: f64, pedestal: f64, folds: f64, quads: usize) -> Mesh {
    surface(quads, quads, |u, v| {
        let (x, z) = (half * (2.0 * u - 1.0), half * (1.0 - 2.0 * v));
        hang(x, z, pedestal, folds)
    })
}

fn hang(x: f64, z: f64, pedestal: f64, folds: f64) -> Vector {
    let along = x.hypot(z).max(1e-9);
    let azimuth = z.atan2(x);
    // The edge is rounded with this radius.
    let round = 0.22 * pedestal;
    let flat = pedestal - round;
    let (radius, height, hanging) = if along < flat {
        (along, 0.0, 0.0)
    } else if along < flat + round * PI / 2.0 {
        let turn = (along - flat) / round;
        (flat + round * turn.sin(), -round * (1.0 - turn.cos()), 0.0)
    } else {
        let down = along - flat - round * PI / 2.0;
        (pedestal, -round - down, down)
    };
    // Folds start at the edge and grow; some are deeper than others.
    let start = ((along - 0.8 * flat) / (0.6 * pedestal)).clamp(0.0, 1.0);
    let start = start * start * (3.0 - 2.0 * start);
    let wander = 0.35 * (2.0 * azimuth + 0.7).sin() + 0.2 * (3.0 * azimuth + 2.1).cos();
    let wave = (folds * azimuth + 1.3 * wander).cos();
    let deep = 1.0 + 0.3 * (2.0 * azimuth - 0.4).sin();
    let depth = start * (0.035 * pedestal + 0.3 * hanging) * deep;
    let outwards = radius + depth * (0.75 + 0.8 * wave) + 0.12 * hanging;
    // Cloth that swings outwards in a fold hangs a little higher.
    let lift = 0.16 * depth * (1.0 + wave);
    let sideways = 0.3 * depth * (folds * azimuth + 1.3 * wander).sin() / outwards.max(1e-9);
    let turned = azimuth + sideways;
    let crease = 0.006 * (5.0 * x + 2.0 * z).sin() * (4.0 * z - 3.0 * x).cos();
    [outwards * turned.cos(), height + lift + crease, outwards * turned.sin()]
}

pub(super) fn scene() -> Scene {
    Scene {
        parts: vec![Part { name: "cloth", mesh: drape(1.55, 0.8, 8.0, QUADS), surface: Surface::default() }],
        camera: Camera { eye: [0.9, 2.1, 4.0], target: [0.0, -0.46, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 37.0 },
        lights: vec![
            PointLight { position: [-2.6, 3.2, 2.8], intensity: [PI * 20.0; 3] },
            PointLight { position: [3.5, 1.2, 2.0], intensity: [PI * 6.0; 3] },
        ],
        environment: sky::environment(),
        background: [0.02; 3],
    }
}
